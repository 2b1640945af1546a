# The Debian package for a board or a computer: sourced by hil/run.

# package [DIR] [BOARD]: meniscus_VERSION_ARCHITECTURE.deb with the profile of BOARD (raspberry-pi-5 by default). A board gets
# the program of a board, a computer the whole one.
package() {
  local into=${1:-$work/package} board=${2:-raspberry-pi-5} version file
  version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
  file=$into/meniscus_${version}_$(architecture "$board").deb
  case $(architecture "$board") in
    amd64) native --release -p meniscus-cli --bin meniscus ;;
    *) build_board ;;
  esac
  pack "$file" "$version" "$board"
  echo "$file"
}

# Debian's name for the processor of a board.
architecture() {
  case $1 in
    generic-x86) echo amd64 ;;
    *) echo arm64 ;;
  esac
}

# Whoever builds a package answers for it: MENISCUS_MAINTAINER, or who git says is at this machine.
maintainer() {
  local name email
  [ -n "${MENISCUS_MAINTAINER:-}" ] && { echo "$MENISCUS_MAINTAINER"; return; }
  name=$(git config user.name || true) email=$(git config user.email || true)
  [ -n "$name" ] && [ -n "$email" ] || {
    echo "hil: who maintains the package? Set MENISCUS_MAINTAINER='Your Name <you@example.org>', or git's user.name and user.email" >&2
    return 2
  }
  echo "$name <$email>"
}

# pack FILE VERSION BOARD [COMPRESSION]: the package, of a program that is built.
pack() {
  local file=$1 version=$2 tree=$work/deb profile=firmware-config/boards/$3.toml program by
  [ -e "$profile" ] || { echo "hil: no profile $profile; there are: $(ls firmware-config/boards)" >&2; exit 2; }
  by=$(maintainer) || exit 2
  case $(architecture "$3") in
    amd64) program=$target/$native_triple/release/meniscus ;;
    *) program=$target/$triple/board/meniscus ;;
  esac
  need dpkg-deb dpkg
  rm -rf "$tree" && mkdir -p "$(dirname "$file")" "$tree/DEBIAN"
  install -D -m 755 "$program" "$tree/usr/bin/meniscus"
  install -D -m 644 firmware-config/systemd/meniscus.service "$tree/lib/systemd/system/meniscus.service"
  install -D -m 644 firmware-config/systemd/meniscus.toml "$tree/etc/meniscus/meniscus.toml"
  install -D -m 644 firmware-config/systemd/journald@meniscus.conf "$tree/etc/systemd/journald@meniscus.conf"
  install -D -m 644 firmware-config/udev/60-meniscus-d435.rules "$tree/lib/udev/rules.d/60-meniscus-d435.rules"
  install -D -m 644 "$profile" "$tree/etc/meniscus/board.toml"
  install -m 755 firmware-config/systemd/postinst firmware-config/systemd/prerm firmware-config/systemd/postrm \
    "$tree/DEBIAN/"
  # Files that a person may edit, and an upgrade leaves alone.
  printf '%s\n' /etc/meniscus/board.toml /etc/meniscus/meniscus.toml /etc/systemd/journald@meniscus.conf >"$tree/DEBIAN/conffiles"
  cat >"$tree/DEBIAN/control" <<TEXT
Package: meniscus
Version: $version
Architecture: $(architecture "$3")
Maintainer: $by
Depends: adduser, init-system-helpers (>= 1.54), systemd (>= 245), udev
Section: science
Priority: optional
Description: watches the free surface of a sloshing liquid and knows the whole liquid
 Reads a RealSense D435 over plain USB and runs as a service; the program is static.
TEXT
  SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null || echo 0) \
    dpkg-deb --root-owner-group "-Z${4:-xz}" --build "$tree" "$file" >"$work/package.log"
}
