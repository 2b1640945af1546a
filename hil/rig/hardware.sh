# A real camera at this machine: what of the gate needs no simulated one. Sourced by hil/run.

# The same scenarios as far as nobody has to pull a plug: enumerate, calibrate, record, stream.
hardware() {
  local json=""
  for word in "$@"; do [ "$word" != --json ] || json=1; done
  cargo build --locked --release -p meniscus-cli --bin meniscus
  local program=$target/release/meniscus at=$work/hardware passed=0 lines=()
  mkdir -p "$at"
  local names=(doctor record stream)
  for name in "${names[@]}"; do
    local ok=false
    case $name in
      doctor) "$program" doctor --json >"$at/$name.json" 2>"$at/$name.err" && ok=true ;;
      record) "$program" record --source usb --seconds 2 --out "$at/x.mcap" >"$at/$name.txt" 2>"$at/$name.err" \
        && ok=true ;;
      stream) "$program" run --source usb --seconds 60 --json --check --out "$at" --turns "$at/turns.csv" \
        >"$at/$name.json" 2>"$at/$name.err" && ok=true ;;
    esac
    $ok && passed=$((passed + 1))
    lines+=("{\"name\": \"$name\", \"ok\": $ok}")
    [ -n "$json" ] || echo "$name: $($ok && echo ok || echo "MISSED: $(tail -1 "$at/$name.err")")"
  done
  if [ -n "$json" ]; then
    local all
    all=$(printf '%s, ' "${lines[@]}")
    printf '{"command": "hil/run gate --hardware", "scenarios": [%s], "checks": [' "${all%, }"
    printf '{"name": "scenarios_passed", "value": %s, "unit": "1", "target": "= %s", "ok": %s}]}\n' \
      "$passed" "${#names[@]}" "$([ "$passed" = "${#names[@]}" ] && echo true || echo false)"
  fi
  [ "$passed" = "${#names[@]}" ]
}
