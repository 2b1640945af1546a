# The rig with the kernel's own camera driver: the simulated camera's colour stream as a webcam. Sourced by hil/run.

# uvcvideo and what it stands on, of the same kernel.
fetch_uvcvideo() {
  [ -e "$cache/uvcvideo/uvcvideo.ko" ] && return
  rm -rf "$cache/uvcvideo" "$cache/uvcvideo.part" && mkdir -p "$cache/uvcvideo.part"
  drivers "$cache/uvcvideo.part" '*/media/mc/mc.ko' '*/media/v4l2-core/videodev.ko' \
    '*/videobuf2/videobuf2-common.ko' '*/videobuf2/videobuf2-memops.ko' '*/videobuf2/videobuf2-v4l2.ko' \
    '*/videobuf2/videobuf2-vmalloc.ko' '*/media/usb/uvc/uvcvideo.ko'
  mv "$cache/uvcvideo.part" "$cache/uvcvideo"
}

# webcam [SECONDS]: heights by a webcam behind uvcvideo, in virtual time, and every frame on the books.
webcam() {
  local seconds=${1:-60} at=$work/webcam
  fetch_guest
  fetch_uvcvideo
  mkdir -p "$at"
  cross --release -p meniscus-webcam --example real_kernel
  judge
  cp "$target/release/meniscus-hil-gate" "$work/gate"
  # The film, and the heights that it was rendered from, by the program of this machine.
  if [ ! -e "$at/truth.f32" ]; then
    cargo run --locked --release -p meniscus-cli -- camera film --frames 360 --out "$at/film.raw" --json >"$at/film.json"
    python3 hil/rig/heights.py recordings/glycerine-unseen.safetensors 360 "$at/truth.f32"
  fi
  local tree=$at/tree
  rm -rf "$tree" && mkdir -p "$tree"/{bin,modules,proc,sys,dev,tmp}
  cp "$cache"/guest/*.ko "$cache"/uvcvideo/*.ko "$tree/modules/"
  cp "$cache/guest/busybox" "$target/$triple/release/examples/real_kernel" "$tree/bin/"
  cp "$at/film.raw" "$at/truth.f32" "$tree/"
  echo "$seconds" >"$tree/seconds"
  install -m 755 hil/rig/webcam-init "$tree/init"
  (cd "$tree" && find . | LC_ALL=C sort | cpio --quiet -o -H newc >"$at/image.cpio")
  rm -rf "$tree"
  emulate "$at/log" 3000 "$(cores | head -1)" -m 1536 -initrd "$at/image.cpio" -append "$kernel_words" \
    || { echo "hil: the guest did not end in order: see $at/log" >&2; exit 2; }
  local facts
  facts=$(sed -n 's/^HIL //p' "$at/log" | tr -d '\r')
  echo "$facts"
  case $facts in *'"checks"'*) ;; *) echo "hil: the guest has no figures: see $at/log" >&2; exit 2 ;; esac
  ! grep -q '"ok":false' <<<"$facts"
}
