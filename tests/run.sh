#!/usr/bin/env bash
# Installs, builds and runs every test, sanitized and optimised. The last line tells how many passed and failed.
#   SBRDF_PRESETS="dev"         only these presets (default: dev release)
#   SBRDF_CTEST_ARGS="-R Merl"  more arguments for ctest
#   SBRDF_SKIP_INSTALL=1        do not look for missing packages
#   SBRDF_TEST_DATA=FOLDER      measured files (default: ../shared/data beside this repository)
#   CI=true                     missing measured files are a failure, not a skipped test
set -uo pipefail
export LC_ALL=C
cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1

read -ra presets <<< "${SBRDF_PRESETS:-dev release}"
read -ra ctest_args <<< "${SBRDF_CTEST_ARGS:-}"
if [ "${CI:-}" = true ]; then
  export SBRDF_REQUIRE_TEST_DATA=1
fi
if [ -z "${SBRDF_SKIP_INSTALL:-}" ]; then
  ./tools/install_packages.sh || exit 1
fi

passed=0 failed=0 skipped=0 broken=0

# junit_count FILE ATTRIBUTE: a count from the head of ctest's report, where each attribute has a line of its own.
junit_count() {
  sed -n "s/^[[:space:]]*$2=\"\([0-9]*\)\".*/\1/p; /<testcase/q" "$1"
}

run_preset() {
  local preset=$1 report=$PWD/build/$1/ctest.xml status=0
  printf '\n== %s: build\n' "$preset"
  cmake --preset "$preset" > "build/configure_$preset.log" 2>&1 || { cat "build/configure_$preset.log"; return 1; }
  cmake --build --preset "$preset" || return 1

  printf '\n== %s: test\n' "$preset"
  rm -f "$report"
  ctest --preset "$preset" --output-junit "$report" ${ctest_args[@]+"${ctest_args[@]}"} || status=1
  [ -f "$report" ] || return 1
  local tests failures skips
  tests=$(junit_count "$report" tests)
  failures=$(junit_count "$report" failures)
  skips=$(junit_count "$report" skipped)
  passed=$((passed + tests - failures - skips))
  failed=$((failed + failures))
  skipped=$((skipped + skips))
  return $status
}

mkdir -p build
for preset in "${presets[@]}"; do
  if ! run_preset "$preset"; then
    broken=1
    echo "$preset: failed" >&2
  fi
done

# A build that broke ran no test: it still counts as a failure.
[ $broken -eq 1 ] && [ $failed -eq 0 ] && failed=1
echo
echo "$passed passed, $failed failed, $skipped skipped"
exit $broken
