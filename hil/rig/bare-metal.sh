# The camera side on an emulated Cortex-M7: sourced by hil/run.

board_triple=thumbv7em-none-eabihf
# Payloads of this many frames, some damaged (hil/src/gate/payloads.rs).
board_frames=90
# Bounds on what the board may use, bytes: its stack of 128 KiB, and data beside it (SSRAM has 4 MiB).
board_stack_limit=126976
board_static_limit=2097152

# The board's program, and its twin for the host.
build_bare_metal() {
  fetch_bare_metal
  local manifest=firmware-config/bare-metal/Cargo.toml
  CARGO_TARGET_DIR=$work/bare-metal/target cargo build "${build_core[@]}" --locked --release \
    --manifest-path $manifest --bin board --target "$board_triple"
  CARGO_TARGET_DIR=$work/bare-metal/target cargo build --locked --release --manifest-path $manifest --bin twin
}

bare_metal() {
  fetch_guest
  build_guest
  build_bare_metal
  film
  board "$@"
}

# The film on the board and on its twin.
board() {
  local json=""
  [ "${1:-}" = --json ] && json=1
  local at=$work/bare-metal begun=$SECONDS
  mkdir -p "$at"
  "$work/gate" payloads "$work/film.raw" "$board_frames" "$at/payloads.bin"
  local program=$at/target/$board_triple/release/board
  (cd "$at" && target/release/twin payloads.bin >twin.log)
  # One instruction a nanosecond: the board's timer counts instructions.
  (cd "$at" && timeout 600 qemu-system-arm -M mps2-an500 -cpu cortex-m7 -nographic -icount shift=0 \
    -semihosting-config enable=on,target=native -kernel "$program" </dev/null >board.log) \
    || { echo "hil: the board did not end in order: see $at/board.log" >&2; exit 2; }
  grep -v '^board ' "$at/board.log" | diff "$at/twin.log" - >"$at/difference" || true
  local equal=0 turns words static ok=true
  turns=$(grep -c '^turn ' "$at/twin.log")
  [ -s "$at/difference" ] || [ "$turns" -lt "$((board_frames - 5))" ] || equal=1
  read -r -a words <<<"$(grep '^board ' "$at/board.log")"
  local mean=${words[2]} longest=${words[4]} stack=${words[6]}
  # .data and .bss; the stack has a section of its own.
  static=$("$work/gate" sections "$program")
  [ "$equal" = 1 ] && [ "$stack" -le "$board_stack_limit" ] && [ "$static" -le "$board_static_limit" ] || ok=false
  if [ -n "$json" ]; then
    printf '{"command": "hil/run bare-metal", "turns": %s, "checks": [' "$turns"
    printf '{"name": "bare_metal_equal", "value": %s, "unit": "1", "target": "= 1", "ok": %s}, ' "$equal" \
      "$([ "$equal" = 1 ] && echo true || echo false)"
    printf '{"name": "stack_bytes", "value": %s, "unit": "B", "target": "<= %s", "ok": %s}, ' "$stack" \
      "$board_stack_limit" "$([ "$stack" -le "$board_stack_limit" ] && echo true || echo false)"
    printf '{"name": "static_bytes", "value": %s, "unit": "B", "target": "<= %s", "ok": %s}, ' "$static" \
      "$board_static_limit" "$([ "$static" -le "$board_static_limit" ] && echo true || echo false)"
    printf '{"name": "instructions_per_turn", "value": %s, "unit": "1", "target": "told", "ok": true}, ' "$mean"
    printf '{"name": "instructions_longest_turn", "value": %s, "unit": "1", "target": "told", "ok": true}, ' \
      "$longest"
    printf '{"name": "wall_s", "value": %s, "unit": "s", "target": "told", "ok": true}]}\n' $((SECONDS - begun))
  else
    echo "$turns turns on the board, equal to the host's to the bit: $([ "$equal" = 1 ] && echo yes || echo NO)"
    echo "instructions a turn: $mean, the longest $longest"
    echo "stack: $stack bytes of at most $board_stack_limit; static: $static of at most $board_static_limit"
    echo "wall: $((SECONDS - begun)) s"
  fi
  head -20 "$at/difference" >&2
  $ok
}
