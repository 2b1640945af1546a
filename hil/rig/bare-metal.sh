# The camera side on an emulated Cortex-M7: sourced by hil/run.

board_triple=thumbv7em-none-eabihf
# Payloads of this many frames, some damaged (hil/src/gate/payloads.rs).
board_frames=90
# Bounds on what the board may use, bytes: its stack of 128 KiB, and data beside it (SSRAM has 4 MiB).
board_stack_limit=126976
board_static_limit=2097152
# Instructions of a frame that the small variant of the estimator may take, every payload included.
board_small_limit=6000000

# The board's program of each variant of the estimator, and its twin for the host. Both lie where the link proof is built: the
# twin's crates are the same.
build_bare_metal() {
  fetch_bare_metal
  local manifest=firmware-config/bare-metal/Cargo.toml from=$root/firmware-config/target to=$work/bare-metal/programs variant
  mkdir -p "$to"
  for variant in full small; do
    local features=()
    [ "$variant" = full ] || features=(--features small)
    CARGO_TARGET_DIR=$from cargo build "${build_core[@]}" --locked --release --manifest-path $manifest \
      "${features[@]}" --bin board --target "$board_triple"
    cp "$from/$board_triple/release/board" "$to/board-$variant"
    CARGO_TARGET_DIR=$from cargo build --locked --release --manifest-path $manifest "${features[@]}" --bin twin
    cp "$from/release/twin" "$to/twin-$variant"
  done
}

bare_metal() {
  fetch_guest
  build_guest
  build_bare_metal
  film
  board "$@"
}

# The film on the board and on its twin, with each variant.
board() {
  local json="" begun=$SECONDS ok=true variant
  [ "${1:-}" = --json ] && json=1
  mkdir -p "$work/bare-metal"
  "$work/gate" payloads "$work/film.raw" "$board_frames" "$work/bare-metal/payloads.bin"
  local checks=() words=()
  for variant in full small; do board_variant "$variant"; done
  board_informational wall_s $((SECONDS - begun)) s
  if [ -n "$json" ]; then
    local IFS=,
    printf '{"command": "hil/run bare-metal", "turns": %s, "checks": [%s]}\n' "$turns" "${checks[*]}"
  else
    printf '%s\n' "${words[@]}"
  fi
  $ok
}

# A check: name, value, unit, target, whether it holds: true, false, or null without a target.
board_check() {
  checks+=("{\"name\": \"$1\", \"value\": $2, \"unit\": \"$3\", \"target\": \"$4\", \"ok\": $5}")
  words+=("$(printf '%-38s %12s %-2s %s' "$1" "$2" "$3" "$4")")
  [ "$5" != false ] || ok=false
}

# A value without a target.
board_informational() {
  board_check "$1" "$2" "$3" informational null
}

# A check that holds where the value is at most the limit.
board_at_most() {
  board_check "$1" "$2" "$3" "<= $4" "$([ "$2" -le "$4" ] && echo true || echo false)"
}

# One variant on the board and on its twin. Of the full one the names of the checks have no prefix.
board_variant() {
  local variant=$1 at=$work/bare-metal prefix=small_
  [ "$variant" = small ] || prefix=""
  local program=$at/programs/board-$variant
  (cd "$at" && "programs/twin-$variant" payloads.bin >"twin-$variant.log")
  # One instruction a nanosecond: the board's timer counts instructions.
  (cd "$at" && timeout 600 qemu-system-arm -M mps2-an500 -cpu cortex-m7 -nographic -icount shift=0 \
    -semihosting-config enable=on,target=native -kernel "$program" </dev/null >"board-$variant.log") \
    || { echo "hil: the board did not end in order: see $at/board-$variant.log" >&2; exit 2; }
  grep -v -e '^board ' -e '^stages ' "$at/board-$variant.log" | diff "$at/twin-$variant.log" - >"$at/difference" || true
  local equal=0 numbers stages
  turns=$(grep -c '^turn ' "$at/twin-$variant.log")
  [ -s "$at/difference" ] || [ "$turns" -lt "$((board_frames - 5))" ] || equal=1
  head -20 "$at/difference" >&2
  read -r -a numbers <<<"$(grep '^board ' "$at/board-$variant.log")"
  read -r -a stages <<<"$(grep '^stages ' "$at/board-$variant.log")"
  board_check "${prefix}bare_metal_equal" "$equal" 1 "= 1" "$([ "$equal" = 1 ] && echo true || echo false)"
  board_at_most "${prefix}stack_bytes" "${numbers[6]}" B "$board_stack_limit"
  # .data and .bss; the stack has a section of its own.
  board_at_most "${prefix}static_bytes" "$("$work/gate" sections "$program")" B "$board_static_limit"
  board_informational "${prefix}instructions_per_turn" "${numbers[2]}" 1
  if [ "$variant" = small ]; then
    board_at_most small_instructions_per_frame "${numbers[8]}" 1 "$board_small_limit"
    board_at_most small_instructions_tracking "${stages[12]}" 1 "$board_small_limit"
  else
    board_informational instructions_per_frame "${numbers[8]}" 1
    board_informational instructions_tracking "${stages[12]}" 1
  fi
  board_informational "${prefix}instructions_longest_turn" "${numbers[4]}" 1
  local field
  # Instructions of a tracked turn by stage: name and number.
  for field in 1 3 5 7 9; do
    board_informational "${prefix}instructions_${stages[field]}" "${stages[field + 1]}" 1
  done
}
