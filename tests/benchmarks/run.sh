#!/usr/bin/env bash
# Makes the files that specs/results/speed.md tells of, and measures on them what its tables say, one after the other; some
# 25 minutes. Nothing else should run. Needs the preset `release` and the measured files.
#   tests/benchmarks/run.sh OUT     a folder for the files and for what each benchmark prints: OUT/NAME.txt
# Files that are there are not made again. Prints a line for each step, with its exit code and seconds.
set -uo pipefail
export LC_ALL=C
if [ $# -ne 1 ]; then
  sed -n '2,5s/^# \?//p' "${BASH_SOURCE[0]}" >&2
  exit 1
fi
mkdir -p "$1" || exit 1
out=$(cd "$1" && pwd)
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1
build=build/release
rgl=${SBRDF_TEST_DATA:-../shared/data}/rgl
mint=$rgl/chm_mint_rgb.bsdf
kurt=("Brushed alum" "Purple satin" "Red velvet" "Yellow satin" fabric002 fabric041 fabric112 fabric135 fabric139 wood01)
failed=0

step() {
  local name=$1 start=$SECONDS code=0
  shift
  "$@" > "$out/$name.txt" 2> "$out/$name.err" || code=$?
  printf '%-12s exit code %d, %d s\n' "$name" $code $((SECONDS - start))
  [ $code -eq 0 ] || failed=1
}

# make NAME SOURCE OPTIONS...
make() {
  local name=$1 source=$2
  shift 2
  [ -s "$out/$name" ] || step "${name%.*}" "$build/sbrdf" convert "$source" "$out/$name" "$@"
}

cmake --build --preset release --target sbrdf evaluation_benchmark source_benchmark codec_benchmark conversion_benchmark \
  importance_benchmark > "$out/build.txt" || { tail "$out/build.txt" >&2; exit 1; }
for samples in 1000 3000 8911 18721; do make "mint$samples.sbrdf" "$mint" --samples $samples; done
for samples in 8911 18721; do make "fabric$samples.sbrdf" kurt:fabric112 --samples $samples; done
make fabric350000.sbrdf kurt:fabric112 --samples 350000 --frame elevation --placement 10/18 --values measured
make mint.binary "$mint"

step evaluation $build/tests/evaluation_benchmark "$out"/{mint1000,mint3000,fabric8911,fabric18721,fabric350000}.sbrdf
step source $build/tests/source_benchmark "$out/mint.binary" "$mint" \
  "$out"/{mint1000,mint3000,mint8911,mint18721,fabric8911,fabric18721}.sbrdf
step codec $build/tests/codec_benchmark "$out"/{mint3000,mint8911,mint18721,fabric8911,fabric18721,fabric350000}.sbrdf
step conversion $build/tests/conversion_benchmark "$out/mint.binary"
step compare $build/sbrdf compare kurt:fabric112 "$out/fabric8911.sbrdf"
step bench $build/sbrdf bench --out "$out/bench"
step importance $build/tests/importance_benchmark "${kurt[@]/#/kurt:}" "$rgl"/*.bsdf
step stress $build/sbrdf stress
exit $failed
