# The x86-64 package as a person gets it, in a fresh Debian of its own; and the container. Sourced by hil/run.

# A small Debian with what the package depends on, kept as an archive.
x86_base=$cache/x86/$guest_release-1.tar

fetch_x86() {
  [ -e "$x86_base" ] && return
  need debootstrap debootstrap
  local at=$cache/x86
  [ "$(id -u)" = 0 ] || missing "root: a Debian is set up in $at"
  rm -rf "$at" && mkdir -p "$at"
  debootstrap --arch=amd64 --variant=minbase --include=adduser,init-system-helpers,systemd,udev "$guest_release" \
    "$at/tree" http://deb.debian.org/debian >"$work/debootstrap-x86.log" 2>&1 \
    || missing "Debian for x86-64: deb.debian.org does not answer (see $work/debootstrap-x86.log)"
  rm -rf "$at"/tree/var/cache/apt/archives/*.deb "$at"/tree/var/lib/apt/lists/*
  tar -C "$at/tree" -cf "$at/base.part" .
  rm -rf "$at/tree"
  mv "$at/base.part" "$x86_base"
}

# within ROOT WORD...: a command in ROOT, with nothing of this machine's environment.
within() {
  local root=$1
  shift
  env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C DEBIAN_FRONTEND=noninteractive \
    unshare --mount --pid --fork --mount-proc="$root/proc" chroot "$root" "$@"
}

# install_x86 [--json]: installed, run, removed and purged; then the container's steps, without a container engine.
install_x86() {
  local json="" begun=$SECONDS at=$work/install root=$work/install/root rows="" bad=0 log
  for word in "$@"; do
    case $word in
      --json) json=1 ;;
      *) usage >&2; exit 2 ;;
    esac
  done
  mkdir -p "$work"
  fetch_x86
  [ "$(id -u)" = 0 ] || missing "root: the package is installed in $root"
  rm -rf "$at" && mkdir -p "$root"
  export MENISCUS_MAINTAINER="${MENISCUS_MAINTAINER:-The rig <rig@localhost>}"
  package "$at" generic-x86 >"$at/package.log"
  tar -C "$root" -xf "$x86_base"
  cp "$at"/meniscus_*_amd64.deb "$root/tmp/meniscus.deb"
  log=$at/install.log

  # row NAME COMMAND...: 1 if the command succeeds.
  row() {
    local name=$1 ok=true value=1
    shift
    "$@" >>"$log" 2>&1 || { ok=false value=0 bad=1; }
    rows+="${rows:+, }{\"name\": \"$name\", \"value\": $value, \"unit\": \"1\", \"target\": \"= 1\", \"ok\": $ok}"
    [ -n "$json" ] || printf '%-22s %s\n' "$name" "$ok"
  }
  row package_installed within "$root" dpkg -i /tmp/meniscus.deb
  row main_job_passes within "$root" runuser -u meniscus -- meniscus run --patient --check --out /tmp/run
  row service_would_run within "$root" meniscus service check
  row package_upgraded within "$root" dpkg -i /tmp/meniscus.deb
  row package_purged within "$root" dpkg -P meniscus
  row nothing_left test ! -e "$root/usr/bin/meniscus" -a ! -e "$root/var/lib/meniscus" -a ! -e "$root/etc/meniscus" \
    -a ! -e "$root/lib/systemd/system/meniscus.service"

  # The last stage of the Containerfile: the static program alone, under its user.
  local container=$at/container
  mkdir -p "$container"
  cp "$target/$native_triple/release/meniscus" "$container/meniscus"
  install -d -o 65534 -g 65534 "$container/reports"
  row container_main_job chroot --userspec=65534:65534 "$container" /meniscus run --patient --check --out /reports/run
  rm -rf "$root" "$container"
  if [ -n "$json" ]; then
    echo "{\"command\": \"hil/run install\", \"wall_s\": $((SECONDS - begun)), \"checks\": [$rows]}"
  fi
  [ "$bad" = 0 ] || echo "hil: see $log" >&2
  return "$bad"
}
