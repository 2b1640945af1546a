//! No start files and no C library: what the core needs beyond `core`, the linker must miss.

fn main() {
    for arg in ["-nostartfiles", "-static", "-lc", "-Wl,--gc-sections"] {
        println!("cargo::rustc-link-arg-bins={arg}");
    }
    println!("cargo::rerun-if-changed=build.rs");
}
