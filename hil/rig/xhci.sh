# The rig with QEMU's host controller: the camera outside of the guest, over usbredir. Sourced by hil/run.

# The driver of a real host controller, of the same kernel.
fetch_xhci() {
  [ -e "$cache/xhci/xhci-pci.ko" ] && return
  rm -rf "$cache/xhci" && mkdir -p "$cache/xhci.part"
  drivers "$cache/xhci.part" '*/usb/host/xhci-hcd.ko' '*/usb/host/xhci-pci.ko'
  mv "$cache/xhci.part" "$cache/xhci"
}

# xhci [--json]: stall, cancel, reset and unplug behind xhci-hcd. In real time: nothing is said of when.
xhci() {
  local json="" begun=$SECONDS at=$work/xhci judged=0
  for word in "$@"; do
    case $word in
      --json) json=--json ;;
      *) usage >&2; exit 2 ;;
    esac
  done
  fetch_guest
  fetch_xhci
  build_guest
  film
  local tree=$at/tree
  rm -rf "$tree" && mkdir -p "$tree"/{bin,modules,proc,sys,dev,tmp}
  cp "$cache"/guest/usb*.ko "$cache"/xhci/*.ko "$tree/modules/"
  cp "$cache/guest/busybox" "$work/meniscus" "$work/meniscus-hil-guest" "$tree/bin/"
  install -m 755 hil/rig/xhci-init "$tree/init"
  "$work/gate" xhci-plans >"$tree/plans"
  (cd "$tree" && find . | LC_ALL=C sort | cpio --quiet -o -H newc >"$at/image.cpio")
  rm -rf "$tree"
  # The socket's path may have at most 107 bytes.
  local socket
  socket=$(mktemp -u)
  "$work/gate" xhci-watch "$at/log" 1500 "$socket" "$work/film.raw" \
    qemu-system-aarch64 -M virt -cpu cortex-a72 -smp 2 -accel tcg,thread=multi -m 1536 \
    -nographic -no-reboot -nic none -chardev "socket,id=camera,path=$socket" \
    -device qemu-xhci,id=usb -device usb-redir,chardev=camera,bus=usb.0 \
    -kernel "$cache/guest/vmlinuz" -initrd "$at/image.cpio" -append "console=ttyAMA0 panic=-1 quiet" \
    || { echo "hil: the guest did not end in order: see $at/log" >&2; exit 2; }
  # shellcheck disable=SC2086
  "$work/gate" xhci $json --wall=$((SECONDS - begun)) "$at/log" || judged=$?
  return "$judged"
}
