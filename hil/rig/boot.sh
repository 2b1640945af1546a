# The guest: its image and its boot. Sourced by hil/run.

# The first file system: programs, modules, the film, and the plans in $work/plans.
image() {
  local tree=$work/tree
  rm -rf "$tree" && mkdir -p "$tree"/{bin,modules,proc,sys,dev,tmp}
  cp "$cache"/guest/*.ko "$tree/modules/"
  cp "$cache/guest/busybox" "$work/meniscus" "$work/meniscus-hil-guest" "$tree/bin/"
  install -m 755 hil/rig/init "$tree/init"
  cp "$work/plans" "$tree/plans"
  ln "$work/film.raw" "$tree/film.raw" 2>/dev/null || cp "$work/film.raw" "$tree/film.raw"
  (cd "$tree" && find . | LC_ALL=C sort | cpio --quiet --reproducible -o -H newc >"$work/image.part")
  mv "$work/image.part" "$work/image.cpio"
}

# Boots the image, LOG SECONDS. One instruction is one nanosecond, so time is virtual: a busy host changes nothing.
boot() {
  "$work/gate" watch "$1" "$2" \
    qemu-system-aarch64 -M virt,dtb-randomness=off -seed 1 -rtc base=2026-01-01,clock=vm -cpu cortex-a72 \
    -m 1536 -smp 1 -accel tcg,thread=single -icount shift=0,sleep=off -nographic -no-reboot -nic none \
    -kernel "$cache/guest/vmlinuz" -initrd "$work/image.cpio" \
    -append "console=ttyAMA0 panic=-1 nokaslr quiet"
}
