# The Debian package for a board: sourced by hil/run.

# package [DIR] [BOARD]: meniscus_VERSION_arm64.deb with the profile of BOARD (raspberry-pi-5 by default).
package() {
  local into=${1:-$work/package} board=${2:-raspberry-pi-5} tree=$work/deb version
  local profile=firmware-config/boards/$board.toml
  [ -e "$profile" ] || { echo "hil: no profile $profile; there are: $(ls firmware-config/boards)" >&2; exit 2; }
  need dpkg-deb dpkg
  cross --bin meniscus
  version=$(sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -1)
  rm -rf "$tree" && mkdir -p "$into" "$tree/DEBIAN"
  install -D -m 755 "$target/$triple/release/meniscus" "$tree/usr/bin/meniscus"
  install -D -m 644 firmware-config/systemd/meniscus.service "$tree/lib/systemd/system/meniscus.service"
  install -D -m 644 firmware-config/systemd/journald@meniscus.conf "$tree/etc/systemd/journald@meniscus.conf"
  install -D -m 644 firmware-config/udev/60-meniscus-d435.rules "$tree/lib/udev/rules.d/60-meniscus-d435.rules"
  install -D -m 644 "$profile" "$tree/etc/meniscus/board.toml"
  install -m 755 firmware-config/systemd/postinst firmware-config/systemd/prerm "$tree/DEBIAN/"
  echo /etc/meniscus/board.toml >"$tree/DEBIAN/conffiles"
  cat >"$tree/DEBIAN/control" <<TEXT
Package: meniscus
Version: $version
Architecture: arm64
Maintainer: Meniscus <root@localhost>
Depends: adduser, systemd (>= 245)
Section: science
Priority: optional
Description: watches the free surface of a sloshing liquid and knows the whole liquid
 Reads a RealSense D435 over plain USB and runs as a service; the program is static.
TEXT
  SOURCE_DATE_EPOCH=$(git log -1 --format=%ct 2>/dev/null || echo 0) \
    dpkg-deb --root-owner-group --build "$tree" "$into/meniscus_${version}_arm64.deb" >"$work/package.log"
  echo "$into/meniscus_${version}_arm64.deb"
}
