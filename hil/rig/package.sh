# The Debian package for a board: sourced by hil/run.

# package [DIR] [BOARD]: meniscus_VERSION_arm64.deb with the profile of BOARD (raspberry-pi-5 by default).
package() {
  local into=${1:-$work/package} version
  cross -p meniscus-cli --bin meniscus
  version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
  local file=$into/meniscus_${version}_arm64.deb
  pack "$file" "$version" "${2:-raspberry-pi-5}"
  echo "$file"
}

# pack FILE VERSION BOARD [COMPRESSION]: the package, of a program that is built.
pack() {
  local file=$1 version=$2 tree=$work/deb profile=firmware-config/boards/$3.toml
  [ -e "$profile" ] || { echo "hil: no profile $profile; there are: $(ls firmware-config/boards)" >&2; exit 2; }
  need dpkg-deb dpkg
  rm -rf "$tree" && mkdir -p "$(dirname "$file")" "$tree/DEBIAN"
  install -D -m 755 "$target/$triple/release/meniscus" "$tree/usr/bin/meniscus"
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
Architecture: arm64
Maintainer: Meniscus <root@localhost>
Depends: adduser, init-system-helpers (>= 1.54), systemd (>= 245), udev
Section: science
Priority: optional
Description: watches the free surface of a sloshing liquid and knows the whole liquid
 Reads a RealSense D435 over plain USB and runs as a service; the program is static.
TEXT
  SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null || echo 0) \
    dpkg-deb --root-owner-group "-Z${4:-xz}" --build "$tree" "$file" >"$work/package.log"
}
