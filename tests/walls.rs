//! Each wall of the house holds, and each can be seen to fail.
//!
//! A copy of the sources is broken on purpose in one place, and the compiler or the linker has to
//! notice. The copies and what is built from them lie under `target/walls`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, MutexGuard};

/// One copy at a time: they share what is built of the dependencies.
static ONE: Mutex<()> = Mutex::new(());

/// A copy of the house.
struct Copy {
    root: PathBuf,
    _turn: MutexGuard<'static, ()>,
}

impl Copy {
    fn new() -> Self {
        let turn = ONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        let house = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
        let root = walls().join("house");
        let _old = fs::remove_dir_all(&root);
        for part in ["src", "firmware-config/src", "firmware-config/bare-metal"] {
            copy_folder(&house.join(part), &root.join(part));
        }
        let firmware =
            ["firmware-config/Cargo.toml", "firmware-config/Cargo.lock", "firmware-config/build.rs"];
        for file in ["Cargo.lock", "README.md"].into_iter().chain(firmware) {
            fs::copy(house.join(file), root.join(file)).expect(file);
        }
        // The core stands alone in the copy: the other members of the workspace are left out.
        let manifest = fs::read_to_string(house.join("Cargo.toml")).expect("the manifest");
        let alone = |line: &&str| !line.starts_with("members = ") && !line.starts_with("default-members = ");
        let manifest = manifest.lines().filter(alone).collect::<Vec<_>>().join("\n");
        fs::write(root.join("Cargo.toml"), manifest).expect("the copy's manifest");
        Self { root, _turn: turn }
    }

    /// Replaces `from` by `to` in one file; the place has to be there.
    fn break_at(&self, file: &str, from: &str, to: &str) {
        let path = self.root.join(file);
        let text = fs::read_to_string(&path).expect(file);
        assert!(text.contains(from), "{file} no longer has `{from}`: mend this test");
        fs::write(&path, text.replacen(from, to, 1)).expect(file);
    }

    /// Checks the library, on top of what is built of its dependencies.
    fn check(&self) -> Output {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("tmp lies in the target folder");
        self.cargo("", &["check", "--lib", "--offline"], target)
    }

    fn cargo(&self, folder: &str, arguments: &[&str], target: &Path) -> Output {
        Command::new(env!("CARGO"))
            .args(arguments)
            .current_dir(self.root.join(folder))
            .env("CARGO_TARGET_DIR", target)
            .output()
            .expect("cargo starts")
    }

    /// Builds the bare-metal program.
    fn link(&self) -> Output {
        self.cargo("firmware-config", &["build", "--release", "--locked"], &walls().join("target"))
    }
}

/// Where everything of this test lies.
fn walls() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("walls")
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder for the copy");
    for entry in fs::read_dir(from).expect("the sources") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.file_type().expect("a type").is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

/// The build has to fail, and to say `why`.
fn refused(output: &Output, why: &str) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "the wall did not hold: this build must fail with `{why}`");
    assert!(text.contains(why), "the build failed, but not with `{why}`:\n{text}");
}

fn accepted(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// The camera-side core is `no_std`: it can name neither `Vec` nor `std`.
#[test]
fn the_core_has_no_vec_and_no_std() {
    let copy = Copy::new();
    accepted(&copy.check());
    copy.break_at("src/latent/window.rs", "pub const WINDOW", "pub type Rows = Vec<Row>;\npub const WINDOW");
    refused(&copy.check(), "cannot find type `Vec`");
    drop(copy);

    let copy = Copy::new();
    copy.break_at(
        "src/latent/window.rs",
        "use heapless::Deque;",
        "use heapless::Deque;\nuse std::time::Instant;",
    );
    refused(&copy.check(), "unlinked crate `std`");
    drop(copy);

    let copy = Copy::new();
    copy.break_at(
        "src/math.rs",
        "/// Hyperbolic tangent, ",
        "extern crate alloc;\n\n/// Hyperbolic tangent, ",
    );
    refused(&copy.link(), "no global memory allocator");
}

#[test]
fn the_camera_side_links_without_a_panic() {
    let copy = Copy::new();
    accepted(&copy.link());
    let program = walls().join("target/release/meniscus-firmware");
    let symbols = Command::new("nm").arg("-C").arg(program).output().expect("nm, of binutils, is there");
    let symbols = String::from_utf8_lossy(&symbols.stdout).into_owned();
    assert!(symbols.contains("_start"), "nm has read the program: {symbols}");
    for forbidden in ["panicking", "__rust_alloc", "rust_begin_unwind"] {
        assert!(!symbols.contains(forbidden), "{forbidden} is linked:\n{symbols}");
    }

    copy.break_at(
        "src/latent/window.rs",
        "        let mut row = [0.0; FEATURES];\n",
        "        let mut row = [0.0; FEATURES];\n        row[core::hint::black_box(7)] = 1.0;\n",
    );
    refused(&copy.link(), "a_panic_path_is_left_in_the_core");
}
