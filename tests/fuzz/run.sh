#!/usr/bin/env bash
# Builds the fuzzers and runs each for some seconds, on a copy of its seeds: nothing is written into the tree.
#   tests/fuzz/run.sh SECONDS [TARGET ...]     all targets unless some are named
# One line per target tells how many inputs it ran and whether it passed. An input that makes one fail is left in
# build/fuzz/findings; run build/fuzz/tests/fuzz/TARGET_fuzzer with it to see why. Fails if any target did.
#   SBRDF_JOBS=N   compile so many files at a time (default: as many as there are cores)
set -uo pipefail
export LC_ALL=C
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1

[[ "${1:-}" =~ ^[1-9][0-9]*$ ]] || { sed -n '2,6s/^# \{0,1\}//p' "$0" >&2; exit 1; }
seconds=$1
shift
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then
  for folder in tests/fuzz/corpus/*/; do targets+=("$(basename "$folder")"); done
fi

mkdir -p build/fuzz/findings
cmake --preset fuzz > build/fuzz/configure.log 2>&1 || { cat build/fuzz/configure.log; exit 1; }
cmake --build --preset fuzz --parallel "${SBRDF_JOBS:-$(nproc)}" || exit 1

corpus=$(mktemp -d)
trap 'rm -rf "$corpus"' EXIT
export UBSAN_OPTIONS=print_stacktrace=1
failed=0
for target in "${targets[@]}"; do
  [ -d "tests/fuzz/corpus/$target" ] || { echo "$target: no such target" >&2; exit 1; }
  cp -r "tests/fuzz/corpus/$target" "$corpus/"
  log=build/fuzz/findings/$target.log
  verdict=passed
  "build/fuzz/tests/fuzz/${target}_fuzzer" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=2048 \
    -malloc_limit_mb=1024 -print_final_stats=1 -artifact_prefix="build/fuzz/findings/$target-" \
    "$corpus/$target" > "$log" 2>&1 || verdict=failed
  executions=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")
  if [ $verdict = failed ]; then
    failed=1
    tail -n 60 "$log"
  fi
  echo "fuzz $target: ${executions:-0} executions, $verdict"
done
exit $failed
