# Cross build of what runs in the guest: sourced by hil/run.

triple=aarch64-unknown-linux-gnu

# A static program, so that the guest needs no library.
cross() {
  LIBUDEV_NO_PKG_CONFIG=1 \
    CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc \
    CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUSTFLAGS="-C target-feature=+crt-static" \
    cargo build "${build_std[@]}" --locked --target "$triple" "$@"
}

# The same for this machine, where that is an x86-64 one.
native_triple=x86_64-unknown-linux-gnu
native() {
  [ "$(uname -m)" = x86_64 ] || missing "an x86-64 machine: the package for one is built on one"
  LIBUDEV_NO_PKG_CONFIG=1 \
    CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="-C target-feature=+crt-static" \
    cargo build --locked --target "$native_triple" "$@"
}

# The program of a board, as `cargo xtask board` measures it.
build_board() {
  cross --profile board -p meniscus-cli --no-default-features --bin meniscus
}

# The judge, which runs on this machine. Of the whole workspace, so that it shares its dependencies with the tests.
judge() {
  cargo build --locked --release --workspace --bin meniscus-hil-gate
}

# The program, the guest's side, and the judge, which runs on this machine. The program has what the guest uses: it makes the
# films and records, and reads a tag, but simulates no liquid, shows no encrypted page and reads no webcam.
build_guest() {
  mkdir -p "$work"
  cross --release -p meniscus-cli -p meniscus-hil --no-default-features \
    --features meniscus-cli/bags,meniscus-cli/desk,meniscus-cli/tag --bin meniscus --bin meniscus-hil-guest
  judge
  # The film is as old as the program that made it: the same program again does not make it anew.
  cmp -s "$target/$triple/release/meniscus" "$work/meniscus" || cp "$target/$triple/release/meniscus" "$work/"
  cp "$target/$triple/release/meniscus-hil-guest" "$work/"
  cp "$target/release/meniscus-hil-gate" "$work/gate"
}

# What the camera shows, rendered by the same program that will watch it, and what that run comes to in process. A second film has
# an AprilTag above the glass.
film() {
  [ -e "$work/film.raw" ] && [ "$work/film.json" -nt "$work/meniscus" ] && return
  qemu-aarch64-static "$work/meniscus" camera film --frames 150 --motion tag:7,40 --out "$work/tag.raw"
  qemu-aarch64-static "$work/meniscus" camera film --frames 360 --out "$work/film.raw" --json >"$work/film.json.part"
  mv "$work/film.json.part" "$work/film.json"
}
