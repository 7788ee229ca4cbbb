// How much of a sliced file a reader takes for one pair of directions, and for theta below 40 degrees.
//   loading_benchmark PRECISION FILE.sbrdf ...
// Each file is coded in small chunks with the given bound (0: lossless); what is loaded in part is compared with the
// whole before anything is printed.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <vector>

#include "codec/evaluation/evaluator.h"
#include "codec/evaluation/needs.h"
#include "codec/file/encoder.h"
#include "codec/file/reader.h"
#include "tests/support/read_sliced.h"

namespace {

using namespace sbrdf::internal;

constexpr int kPairs = 60;

/// Bytes that would be left to read if chunks could be cut to the samples needed, at the mean size of a chunk's
/// samples: what no choice of chunks goes below without a denser code.
double least_bytes(const SlicedReader& reader, const SlicedBrdf& sliced, const LatticeParts& needed, std::size_t head) {
  const SlicedIndex& index = reader.index();
  const std::size_t pieces = index.layout.piece_depths.size();
  const LatticeBlocks blocks = make_blocks(reader.lattice(), index.layout);
  const ChunkOrder order(blocks, pieces);
  auto bytes = static_cast<double>(head);
  for (std::size_t block = 0; block < blocks.crossings.size(); ++block) {
    std::size_t used = 0;
    for (const std::uint32_t k : blocks.crossings[block]) used += needed.crossings[k] ? 1 : 0;
    bytes += static_cast<double>(index.chunk_sizes[ChunkOrder::crossings(block)] * used) /
             static_cast<double>(blocks.crossings[block].size());
  }
  for (std::size_t kind = 0; kind < kAxisCount; ++kind) {
    for (std::size_t block = 0; block < blocks.slices[kind].size(); ++block) {
      std::size_t used = 0;
      std::size_t all = 0;
      for (const std::uint32_t k : blocks.slices[kind][block]) {
        all += sliced.sample_counts[k];
        used += needed.slices[k] ? sliced.sample_counts[k] : 0;
      }
      for (std::size_t piece = 0; piece < pieces && all > 0; ++piece) {
        bytes +=
            static_cast<double>(index.chunk_sizes[order.slices(piece, kind, block)] * used) / static_cast<double>(all);
      }
    }
  }
  return bytes;
}

bool measure(const char* path, double precision) {
  const Result<DecodedSliced> given = read_sliced(path);
  if (!given) return false;
  const std::vector<std::byte> bytes = encode_sliced(given->sliced, given->lattice, {precision, ChunkSize::kSplit});
  const DecodedSliced whole = decode_sliced(bytes).value();
  const Evaluator evaluator(whole.sliced, whole.lattice);
  std::size_t taken = 0;
  const CallbackSource source(bytes.size(), [&](std::uint64_t offset, std::span<std::byte> target) {
    taken += target.size();
    std::memcpy(target.data(), bytes.data() + offset, target.size());
    return ok_status();
  });
  const SlicedReader reader = SlicedReader::open(source).value();
  const std::size_t head = taken;
  std::mt19937_64 random(1);
  const auto uniform = [&](double end) { return end * static_cast<double>(random() >> 11U) * 0x1p-53; };
  const auto direction = [&](double theta_end) {
    const double theta = uniform(theta_end);
    return direction_from_degrees(theta, uniform(360));
  };
  const auto same = [&](const PartialSliced& part, const DirectionPair& pair) {
    std::vector<float> expected(whole.sliced.channel_count());
    std::vector<float> got(expected.size());
    evaluator.evaluate(pair, expected);
    return part.evaluate(pair, got) && std::memcmp(expected.data(), got.data(), got.size() * sizeof(float)) == 0;
  };
  double sum = 0;
  std::size_t most = 0;
  bool all_same = true;
  for (int k = 0; k < kPairs; ++k) {
    const DirectionPair pair = {direction(80), direction(80)};
    taken = head;
    all_same = same(reader.load(cells_of(reader.lattice(), std::span(&pair, 1))).value(), pair) && all_same;
    sum += static_cast<double>(taken);
    most = std::max(most, taken);
  }
  const CellSet below_40 = cells_in(reader.lattice(), {0, 40}, {0, 40});
  taken = head;
  const PartialSliced part = reader.load(below_40).value();
  const std::size_t region = taken;
  for (int k = 0; k < kPairs; ++k) all_same = same(part, {direction(40), direction(40)}) && all_same;
  if (!all_same) {
    std::fprintf(stderr, "%s: a part differs from the whole\n", path);
    return false;
  }
  const double percent = 100 / static_cast<double>(bytes.size());
  std::printf(
      "%-28s %8zu bytes, head %5.2f %%  one pair %5.1f %%, at most %5.1f %%  theta < 40: %5.1f %%, needed %5.1f "
      "%%\n",
      path, bytes.size(), percent * static_cast<double>(head), percent * sum / kPairs,
      percent * static_cast<double>(most), percent * static_cast<double>(region),
      percent * least_bytes(reader, whole.sliced, needs_of(reader.lattice(), below_40), head));
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "loading_benchmark PRECISION FILE.sbrdf ...\n");
    return 1;
  }
  bool ok = true;
  for (int k = 2; k < argc; ++k) ok = measure(argv[k], std::atof(argv[1])) && ok;
  return ok ? 0 : 1;
}
