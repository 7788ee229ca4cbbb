#!/usr/bin/env bash
# Installs, builds and runs every test, sanitized and optimised. The last line tells how many passed and failed. Suites
# labelled `slow` run in the optimised build only, and what the label `ci` stands for (the installed package) with CI=true
# only.
#   SBRDF_PRESETS="dev"         only these presets (default: dev release)
#   SBRDF_CTEST_ARGS="-R Merl"  more arguments for ctest
#   SBRDF_SKIP_INSTALL=1        do not look for missing packages
#   SBRDF_TEST_DATA=FOLDER      measured files (default: ../shared/data beside this repository)
#   SBRDF_FUZZ_SECONDS=10       run each fuzzer for so long, too: one build more (default: 0, not at all). Their seeds
#                               and damaged copies of them are tests of the sanitized build anyway.
#   CI=true                     missing measured files, and what runs or checks shaders, are failures, not skipped
#                               tests; a browser, Godot 3 and npm (some 500 MB) are installed for the examples for
#                               engines. By hand: CI=true ./tools/install_packages.sh, and
#                               ctest --preset release -R "BrowserDraws|GodotDraws"
set -uo pipefail
export LC_ALL=C
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

read -ra presets <<< "${SBRDF_PRESETS:-dev release}"
read -ra ctest_args <<< "${SBRDF_CTEST_ARGS:-}"
if [ "${CI:-}" = true ]; then
  export SBRDF_REQUIRE_TEST_DATA=1 SBRDF_REQUIRE_SHADER_TOOLS=1
fi
if [ -z "${SBRDF_SKIP_INSTALL:-}" ]; then
  ./tools/install_packages.sh || exit 1
fi

passed=0 failed=0 skipped=0 broken=0

run_preset() {
  local preset=$1 report=$PWD/build/$1/ctest.xml status=0 left_out=() now_passed now_failed now_skipped
  [ "$preset" = dev ] && left_out+=(slow)
  [ "${CI:-}" = true ] || left_out+=(ci)
  printf '\n== %s: build\n' "$preset"
  cmake --preset "$preset" > "build/configure_$preset.log" 2>&1 || { cat "build/configure_$preset.log"; return 1; }
  cmake --build --preset "$preset" || return 1

  printf '\n== %s: test\n' "$preset"
  rm -rf "$report" "build/$preset/gtest"
  ctest --preset "$preset" --output-junit "$report" -LE "^($(IFS='|'; echo "${left_out[*]-}"))\$" \
    ${ctest_args[@]+"${ctest_args[@]}"} || status=1
  local counts
  counts=$(python3 -B tests/checks/count_tests.py "$report" "build/$preset/gtest") || return 1
  read -r now_passed now_failed now_skipped <<< "$counts"
  passed=$((passed + now_passed)) failed=$((failed + now_failed)) skipped=$((skipped + now_skipped))
  return $status
}

# Each target is one test.
run_fuzzers() {
  local seconds=$1 log=build/fuzz.log status=0
  printf '\n== fuzz: %s seconds for each target\n' "$seconds"
  if [ "${CI:-}" != true ] && ! command -v clang++-14 > /dev/null; then
    echo "skipped: the fuzzers need clang++-14"
    skipped=$((skipped + $(find tests/fuzz/corpus -mindepth 1 -maxdepth 1 -type d | wc -l)))
    return 0
  fi
  ./tests/fuzz/run.sh "$seconds" | tee "$log" || status=1
  passed=$((passed + $(grep -c '^fuzz .* executions, passed$' "$log")))
  failed=$((failed + $(grep -c '^fuzz .* executions, failed$' "$log")))
  return $status
}

mkdir -p build
for preset in "${presets[@]}"; do
  if ! run_preset "$preset"; then
    broken=1
    echo "$preset: failed" >&2
  fi
done

fuzz_seconds=${SBRDF_FUZZ_SECONDS:-0}
if [ "$fuzz_seconds" != 0 ] && ! run_fuzzers "$fuzz_seconds"; then
  broken=1
  echo "fuzz: failed" >&2
fi

# A build that broke ran no test: it still counts as a failure.
[ $broken -eq 1 ] && [ $failed -eq 0 ] && failed=1
echo
echo "$passed passed, $failed failed, $skipped skipped"
exit $broken
