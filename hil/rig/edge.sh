# The edge board: Debian's arm64 userland under systemd, with the package installed. Sourced by hil/run.

# What a board's Debian has beyond the essential packages, as far as the package or its test needs it.
board_packages=systemd-sysv,udev,adduser,dbus
# Where that Debian is kept, an archive of its whole tree; the name changes with what is in it.
board_base=$cache/board/$guest_release-1.cpio

# Debian for the board, made once: debootstrap fetches and unpacks it, dpkg installs it.
fetch_board() {
  [ -e "$board_base" ] && return
  need debootstrap debootstrap
  local at=$cache/board
  [ "$(id -u)" = 0 ] || missing "root, once: Debian for the board is set up in $at"
  rm -rf "$at" && mkdir -p "$at"
  drivers "$at" '*/drivers/virtio/virtio_mmio.ko' '*/drivers/block/virtio_blk.ko'
  debootstrap --foreign --arch=arm64 --variant=minbase --include="$board_packages" "$guest_release" "$at/tree" \
    http://deb.debian.org/debian >"$work/debootstrap.log" 2>&1 \
    || missing "Debian's arm64 userland: deb.debian.org does not answer (see $work/debootstrap.log)"
  install_board "$at/tree" >"$work/board-base.log" 2>&1 \
    || missing "Debian's arm64 userland: it could not be set up (see $work/board-base.log)"
  # As Debian's small images do: no manuals, no translations, no packages that are installed already.
  (cd "$at/tree" && rm -rf debootstrap var/cache/apt/archives/*.deb var/lib/apt/lists/* var/log/*.log usr/share/doc/* \
    usr/share/man/* usr/share/locale/* usr/share/info/* usr/share/zoneinfo/*)
  echo board >"$at/tree/etc/hostname"
  (cd "$at/tree" && find . | LC_ALL=C sort | cpio --quiet -o -H newc >"$at/base.part")
  rm -rf "$at/tree"
  mv "$at/base.part" "$board_base"
}

# install_board TREE: in a user namespace of its own, where the packages' arm64 scripts run by QEMU; nobody outside of
# it sees that (Linux 6.7 or newer).
install_board() {
  local gate outer child=""
  gate=$(mktemp -u) && mkfifo "$gate"
  # shellcheck disable=SC2016
  unshare --user --mount --pid --fork --kill-child \
    bash -c 'read -r _ <"$1" && exec bash "$2" "$3"' board "$gate" hil/rig/board-install "$1" &
  outer=$!
  for _ in $(seq 100); do
    child=$(pgrep --parent "$outer") || true
    [ -n "$child" ] && [ "$(readlink "/proc/$child/ns/user")" != "$(readlink /proc/self/ns/user)" ] && break
    sleep 0.1
  done
  # This machine's users are its users: owners and groups of the files come out right.
  { echo "0 0 65536" >"/proc/$child/uid_map" && echo "0 0 65536" >"/proc/$child/gid_map" && echo >"$gate"; } \
    || kill "$outer"
  rm "$gate"
  wait "$outer"
}

# What is put on top of the board's own files: nothing of it is the board's.
edge_overlay() {
  local tree=$work/edge/tree module
  rm -rf "$tree" && mkdir -p "$tree/hil" "$tree/usr/bin"
  cp "$cache"/guest/*.ko "$work/meniscus-hil-guest" "$work/edge/meniscus.deb" "$work/edge/meniscus-next.deb" "$tree/hil/"
  for module in virtio_mmio virtio_blk; do cp "$cache/board/$module.ko" "$tree/hil/"; done
  cp "$cache/guest/busybox" "$tree/usr/bin/"
  install -m 755 hil/rig/edge-init "$tree/init"
  "$work/gate" sibling models/glycerine.blob "$tree/hil/own.blob"
  # Two seconds, there and back.
  head -c $((120 * 640 * 480 * 3)) "$work/film.raw" >"$tree/hil/film.raw"
  find "$tree" -exec touch --date=@0 {} +
  # Not `usr` itself: the board's own folders keep their owners and modes.
  (cd "$tree" && { echo init; find hil; echo usr/bin/busybox; } | LC_ALL=C sort \
    | cpio --quiet --reproducible -o -H newc --owner=+0:+0 >"$work/edge/overlay.cpio")
  rm -rf "$tree"
}

# power PHASE SECONDS: boots the board from $work/edge/PHASE.cpio; what changed on it comes out in $work/edge/PHASE.state.
power() {
  local at=$work/edge phase=$1 bytes
  rm -f "$at/$phase.state" && truncate -s 512M "$at/$phase.state"
  # The kernel unpacks one archive behind the other; the disk is only the way out. Nothing is recorded here: while
  # QEMU records, such a disk never answers, and two boots need not print the same.
  emulate "$at/$phase.log" "$2" "$(cores | head -1)" -m 3072 -initrd "$at/$phase.cpio" \
    -drive if=none,id=out,file="$at/$phase.state",format=raw,cache=unsafe -device virtio-blk-device,drive=out \
    -append "$kernel_words phase=$phase systemd.mask=serial-getty@ttyAMA0.service" \
    || { echo "hil: the board's boot did not end in order: see $at/$phase.log" >&2; exit 2; }
  bytes=$(sed -n 's/.*HIL-STATE \([0-9]*\).*/\1/p' "$at/$phase.log")
  [ -n "$bytes" ] || { echo "hil: the board did not hand out its state: see $at/$phase.log" >&2; exit 2; }
  truncate -s "$bytes" "$at/$phase.state"
}

# boot_edge [--json]: a person installs the package; the power goes and comes back.
boot_edge() {
  local json="" begun=$SECONDS at=$work/edge judged=0 version
  for word in "$@"; do
    case $word in
      --json) json=--json ;;
      *) usage >&2; exit 2 ;;
    esac
  done
  fetch_guest
  fetch_board
  build_guest
  build_board
  film
  mkdir -p "$at"
  version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
  export MENISCUS_MAINTAINER="${MENISCUS_MAINTAINER:-The rig <rig@localhost>}"
  pack "$at/meniscus.deb" "$version" raspberry-pi-5
  # Only the first one has to be what a person gets, to the byte.
  pack "$at/meniscus-next.deb" "$version+next" raspberry-pi-5 none
  edge_overlay
  cat "$board_base" "$at/overlay.cpio" >"$at/install.cpio"
  power install 1500
  cat "$board_base" "$at/install.state" "$at/overlay.cpio" >"$at/power-on.cpio"
  power power-on 600
  # shellcheck disable=SC2086
  "$work/gate" board $json --wall=$((SECONDS - begun)) "$at/install.log" "$at/power-on.log" || judged=$?
  rm -f "$at"/*.cpio "$at"/*.state
  return "$judged"
}
