#!/usr/bin/env bash
# quickstart.sh [FILE]: installs, builds, converts FILE to .sbrdf and back to a MERL table, and prints sizes, errors and
# times. Without FILE it first writes a MERL-format table from the published parameters of fabric112.
# Everything it writes is in build/quickstart.
set -euo pipefail
shopt -s inherit_errexit
# A decimal point, whatever the user's language, in the clock and in printf.
export LC_ALL=C

usage() {
  sed -n '2,4s/^# //p' "${BASH_SOURCE[0]}"
}

case "${1:-}" in
  -h | --help)
    usage
    exit 0
    ;;
esac
if [ $# -gt 1 ]; then
  usage >&2
  exit 1
fi
input=""
if [ $# -eq 1 ]; then
  if [ ! -f "$1" ]; then
    echo "quickstart: $1: no such file" >&2
    exit 2
  fi
  input=$(realpath -- "$1")
fi

cd "$(dirname "${BASH_SOURCE[0]}")/.."
./tools/install_packages.sh

# run_logged LOG COMMAND...: quiet unless it fails.
run_logged() {
  local log=$1
  shift
  if ! "$@" > "$log" 2>&1; then
    cat "$log" >&2
    exit 1
  fi
}
out=build/quickstart
mkdir -p "$out"
echo "Building build/release/sbrdf ..."
run_logged "$out/configure.log" cmake --preset release
run_logged "$out/build.log" cmake --build --preset release --target sbrdf
sbrdf=build/release/sbrdf

microseconds() {
  echo "${EPOCHREALTIME/./}"
}

# timed COMMAND...: runs it; the time it took is in $elapsed.
elapsed=0
timed() {
  local start stop
  start=$(microseconds)
  "$@" > "$out/last.log" || exit $?
  stop=$(microseconds)
  elapsed=$(printf '%d.%02d' $(((stop - start) / 1000000)) $(((stop - start) / 10000 % 100)))
}

# json_fields NAME...: those members of the JSON object on standard input, on one line.
json_fields() {
  python3 -c 'import json, sys
members = json.load(sys.stdin)
print(*(format(members[name], ".4g") if isinstance(members[name], float) else members[name] for name in sys.argv[1:]))' "$@"
}

if [ -z "$input" ]; then
  echo "Writing a MERL-format table of fabric112 ..."
  input=$out/fabric112.binary
  timed "$sbrdf" convert kurt:fabric112 "$input"
  first_seconds=$elapsed
else
  first_seconds=-
fi

name=$(basename -- "$input")
name=${name%.*}
name=${name:-input}
sliced=$out/$name.sbrdf
back=$out/$name-back.binary
if [ "$input" -ef "$sliced" ] || [ "$input" -ef "$back" ]; then
  echo "quickstart: $input would be overwritten; copy it elsewhere first" >&2
  exit 1
fi

echo "Converting to .sbrdf and back ..."
timed "$sbrdf" convert "$input" "$sliced"
sliced_seconds=$elapsed
timed "$sbrdf" convert "$sliced" "$back"
back_seconds=$elapsed

# The whole 2-degree grid is quick for isotropic materials only.
directions=()
note="error against the first file, on the 2-degree grid up to 80 degrees"
if [ "$("$sbrdf" info "$input" --json | json_fields isotropic)" != True ]; then
  directions=(--random 500000 --seed 1)
  note="$note, 500,000 random pairs of it"
fi

echo "Comparing ..."
bytes_of() {
  stat -c %s -- "$1"
}
input_bytes=$(bytes_of "$input")
row='%-32s %12s %8s %12s %14s %8s\n'
print_row() {
  local file=$1 seconds=$2 bytes errors mre=- rel_l1=-
  bytes=$(bytes_of "$file")
  if [ "$file" != "$input" ]; then
    errors=$("$sbrdf" compare "$input" "$file" ${directions[@]+"${directions[@]}"} --json | json_fields mre_percent rel_l1_percent)
    read -r mre rel_l1 <<< "$errors"
  fi
  # shellcheck disable=SC2059
  printf "$row" "$(basename -- "$file")" "$bytes" "$((input_bytes * 10 / bytes / 10)).$((input_bytes * 10 / bytes % 10))" \
    "$mre" "$rel_l1" "$seconds"
}
table=$(
  # shellcheck disable=SC2059
  printf "$row" file bytes ratio mre_percent rel_l1_percent seconds
  print_row "$input" "$first_seconds"
  print_row "$sliced" "$sliced_seconds"
  print_row "$back" "$back_seconds"
)
printf '\n%s\n\n(%s; files in %s)\n' "$table" "$note" "$out"
