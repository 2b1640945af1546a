//! The board's program has its own memory layout and no start files.

use std::env::var;

fn main() {
    if var("CARGO_CFG_TARGET_OS").as_deref() == Ok("none") {
        let folder = var("CARGO_MANIFEST_DIR").unwrap_or_default();
        println!("cargo::rustc-link-arg-bin=board=-T{folder}/an500.x");
    }
    println!("cargo::rerun-if-changed=an500.x");
}
