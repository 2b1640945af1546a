# What the rig needs from outside, each piece fetched once: sourced by hil/run.

# The guest is Debian's stable kernel of this release, whatever the machine itself runs.
guest_release=bookworm
keyring=/usr/share/keyrings/debian-archive-keyring.gpg

# A command of a Debian package, installed if it is not there and this is root.
need() {
  local command=$1 package=$2
  command -v "$command" >/dev/null && return
  [ "$(id -u)" = 0 ] || missing "$command: install the package $package"
  { apt-get update -q && DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends "$package"; } \
    >"$work/apt.log" 2>&1 || missing "$command: the package $package cannot be fetched (see $work/apt.log)"
}

# apt for another architecture, with lists of its own, so that the machine's are not touched.
foreign_apt() {
  local apt=$cache/apt
  mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
  echo "deb [signed-by=$keyring] http://deb.debian.org/debian $guest_release main" >"$apt/sources.list"
  local program=$1
  shift
  "$program" -o APT::Architecture=arm64 -o APT::Architectures::=arm64 -o Dir::Etc::SourceList="$apt/sources.list" \
    -o Dir::Etc::SourceParts=/dev/null -o Dir::State::Lists="$apt/lists" -o Dir::Cache="$apt/cache" \
    -o Dir::State::status=/dev/null -o APT::Sandbox::User=root "$@"
}

# Kernel, its modules and busybox for arm64.
fetch_kernel() {
  [ -e "$cache/guest/vmlinuz" ] && return
  need dpkg-deb dpkg
  [ -e "$keyring" ] || missing "$keyring: install the package debian-archive-keyring"
  rm -rf "$cache/unpacked" && mkdir -p "$cache/debs" "$cache/unpacked" "$cache/guest"
  # Lists that cannot be fetched are only a warning to apt: what tells is that the kernel's package is not known.
  foreign_apt apt-get update -q >"$work/apt.log" 2>&1 || true
  local kernel
  kernel=$(foreign_apt apt-cache depends linux-image-arm64 2>>"$work/apt.log" | sed -n 's/ *Depends: //p' | head -1) \
    || true
  [ -n "$kernel" ] || missing "Debian's arm64 packages: deb.debian.org does not answer (see $work/apt.log)"
  (cd "$cache/debs" && foreign_apt apt-get download "$kernel" busybox-static) >"$work/apt.log" 2>&1 \
    || missing "$kernel and busybox-static for arm64: deb.debian.org does not answer (see $work/apt.log)"
  for deb in "$cache"/debs/*.deb; do dpkg-deb -x "$deb" "$cache/unpacked"; done
  local modules
  modules=$(echo "$cache"/unpacked/lib/modules/*/kernel/drivers)
  cp "$modules"/usb/common/usb-common.ko "$modules"/usb/core/usbcore.ko "$modules"/usb/usbip/usbip-core.ko \
    "$modules"/usb/usbip/vhci-hcd.ko "$cache/unpacked/bin/busybox" "$cache/guest/"
  # Last: where it is, all of it is.
  cp "$cache"/unpacked/boot/vmlinuz-* "$cache/guest/vmlinuz"
  rm -rf "$cache/unpacked"
}

# drivers INTO PATTERN...: more modules of the kernel that is kept, each into the folder INTO.
drivers() {
  local into=$1 kernel
  shift
  kernel=$(echo "$cache"/debs/linux-image-*.deb)
  dpkg-deb --fsys-tarfile "$kernel" >"$into/kernel.tar"
  tar -C "$into" --transform='s|.*/||' --wildcards -xf "$into/kernel.tar" "$@"
  rm "$into/kernel.tar"
}

# The standard library for another target: by rustup, or built from Debian's source of the same version.
fetch_std() {
  local triple=$1 sysroot version
  sysroot=$(rustc --print sysroot)
  build_std=()
  [ -d "$sysroot/lib/rustlib/$triple" ] && return
  if command -v rustup >/dev/null && [ "${MENISCUS_HIL_STD:-}" != source ] \
    && rustup target add "$triple" >"$work/rustup.log" 2>&1; then
    return
  fi
  version=$(rustc --version | cut -d ' ' -f 2)
  local source=$cache/rust-src-$version
  if [ ! -d "$source" ]; then
    need dpkg-deb dpkg
    local pool=http://deb.debian.org/debian/pool/main/r/rustc
    local deb=rust-src_$version+dfsg1-2~bpo13+1_all.deb
    { mkdir -p "$cache/debs" && curl -fsS -o "$cache/debs/$deb" "$pool/$deb" \
      && dpkg-deb -x "$cache/debs/$deb" "$source.part" && mv "$source.part" "$source"; } >"$work/apt.log" 2>&1 \
      || missing "the standard library for $triple: neither rustup nor Debian's rust-src $version can be had"
  fi
  mkdir -p "$sysroot/lib/rustlib/src"
  ln -sfn "$source/usr/src/rustc-$version" "$sysroot/lib/rustlib/src/rust"
  export RUSTC_BOOTSTRAP=1
  build_std=(-Zbuild-std=std,panic_abort)
}

fetch_cross() {
  mkdir -p "$work" "$cache"
  need aarch64-linux-gnu-gcc gcc-aarch64-linux-gnu
  [ -e /usr/aarch64-linux-gnu/lib/libc.a ] || need /usr/aarch64-linux-gnu/lib/libc.a libc6-dev-arm64-cross
  fetch_std aarch64-unknown-linux-gnu
}

fetch_guest() {
  fetch_cross
  need qemu-system-aarch64 qemu-system-arm
  need qemu-aarch64-static qemu-user-static
  need cpio cpio
  fetch_kernel
}

fetch_bare_metal() {
  mkdir -p "$work" "$cache"
  need qemu-system-arm qemu-system-arm
  fetch_std thumbv7em-none-eabihf
  build_core=()
  [ ${#build_std[@]} = 0 ] || build_core=(-Zbuild-std=core)
}
