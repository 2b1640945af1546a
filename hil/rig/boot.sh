# The guest: its image and its boot. Sourced by hil/run.

# The first file system: programs, modules, the films, and the plans in $work/plans.
image() {
  local tree=$work/tree name
  rm -rf "$tree" && mkdir -p "$tree"/{bin,modules,proc,sys,dev,tmp}
  cp "$cache"/guest/*.ko "$tree/modules/"
  cp "$cache/guest/busybox" "$work/meniscus" "$work/meniscus-hil-guest" "$tree/bin/"
  install -m 755 hil/rig/init "$tree/init"
  cp "$work/plans" "$tree/plans"
  for name in film.raw tag.raw; do
    ln "$work/$name" "$tree/$name" 2>/dev/null || cp "$work/$name" "$tree/$name"
  done
  # The same files make the same image, whenever that is.
  find "$tree" -exec touch --date=@0 {} +
  (cd "$tree" && find . | LC_ALL=C sort | cpio --quiet --reproducible -o -H newc >"$work/image.part")
  mv "$work/image.part" "$work/image.cpio"
}

# boot LOG SECONDS [CORE]: boots the image. One instruction is one nanosecond, so time is virtual: a busy host
# changes nothing. Two things keep it so:
# * rr=record. QEMU has a thread for the processor and one for timers. Without recording, the second may look at
#   the clock while the first is between the guest's last instruction before a rest and the account of it; the
#   clock then jumps from a time that is too early. While it records, QEMU lets only one of them run at a time.
#   Nobody needs the recording.
# * One core of the host: the two threads wait for each other at every rest of the guest, and on one core that
#   costs least.
# Half of the memory is for the first file system, of which the films take 470 MB.
boot() {
  recorded=,rr=record,rrfile=/dev/null emulate "$1" "$2" "${3:-}" \
    -m 2048 -initrd "$work/image.cpio" -append "$kernel_words"
}

kernel_words="console=ttyAMA0 panic=-1 nokaslr quiet"

# emulate LOG SECONDS CORE WORDS...: the machine in virtual time, with these words beside; `recorded` as above.
emulate() {
  local log=$1 seconds=$2 on=()
  [ -z "$3" ] || on=(taskset --cpu-list "$3")
  shift 3
  "$work/gate" watch "$log" "$seconds" "${on[@]}" \
    qemu-system-aarch64 -M virt,dtb-randomness=off -seed 1 -rtc base=2026-01-01,clock=vm -cpu cortex-a72 \
    -smp 1 -accel tcg,thread=single -icount "shift=0,sleep=off${recorded:-}" \
    -nographic -no-reboot -nic none -kernel "$cache/guest/vmlinuz" "$@"
}

# The host's cores that may be used, one a line.
cores() {
  local ranges from to
  IFS=, read -r -a ranges <<<"$(sed -n 's/^Cpus_allowed_list:[[:space:]]*//p' /proc/self/status)"
  for range in "${ranges[@]}"; do
    IFS=- read -r from to <<<"$range"
    seq "$from" "${to:-$from}"
  done
}
