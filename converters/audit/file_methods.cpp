#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "converters/audit/methods.h"
#include "converters/baselines/schemes.h"
#include "converters/files/dense/table_head.h"
#include "converters/tables/dense_table.h"
#include "formats/core/byte_source.h"
#include "formats/rgl/tensor_file.h"

namespace sbrdf::internal {
namespace {

// Files of other formats, as this library writes and reads them.

/// One that is tried: what is written, how it is read, and the bytes of its numbers where these say what is overhead.
struct FileTrial {
  std::string setting;
  std::string_view extension;
  Options writing = {};
  Options reading = {};
  std::uint64_t payload = 0;  ///< 0: `overhead` is what is known
  std::uint64_t overhead = 0;
  std::uint64_t beside = 0;  ///< bytes of a second file that belongs to it
};

Result<Kept> kept_file(Workbench& bench, const FileTrial& trial, const Progress& progress) {
  const Result<FileBytes> file = bench.file(trial.extension, trial.writing, progress);
  if (!file) return file.error();
  Result<Kept> kept = bench.kept(trial.setting, *file, trial.reading);
  if (!kept) return kept.error();
  kept->bytes += trial.beside;
  kept->overhead =
      trial.payload > 0 ? kept->bytes - std::min(kept->bytes, trial.payload) : std::min(kept->bytes, trial.overhead);
  return kept;
}

/// `trial_of` each of so many in turn, from the smallest, until one reaches the target, or there is none.
template <class TrialOf>
Result<Found> find_file(Workbench& bench, double percent, std::size_t count, const TrialOf& trial_of,
                        const Progress& progress) {
  Smallest smallest(percent);
  StepwiseProgress steps(progress);
  for (std::size_t k = 0; k < count && !smallest.reached(); ++k) {
    const std::optional<FileTrial> trial = trial_of(k);
    if (!trial) break;
    Result<Kept> kept = kept_file(bench, *trial, steps.step(1.0 / static_cast<double>(count - k)));
    if (kept) {
      smallest.take(*std::move(kept));
    } else if (!smallest.complain(kept.error())) {
      return kept.error();
    }
  }
  return std::move(smallest).found();
}

/// A table on the steps of the ladder, from the first that should reach the target, until one does.
template <class TrialOn>
Result<Found> find_on_ladder(Workbench& bench, double percent, const TrialOn& trial_on, const Progress& progress) {
  constexpr std::size_t kMost = 4;
  GridLadder& ladder = bench.ladder();
  std::size_t first = ladder.reach(percent);
  if (first == ladder.size()) --first;  // the nearest there is
  return find_file(
      bench, percent, kMost,
      [&](std::size_t k) -> std::optional<FileTrial> {
        const LadderStep& step = ladder.step(first + k);
        if (first + k >= ladder.size()) return std::nullopt;
        return trial_on(step.grid);
      },
      progress);
}

std::uint64_t numbers_on(const Workbench& bench, const Grid& grid) {
  return grid.node_count() * bench.subject().channel_count();
}

Options with_grid(const Grid& grid) { return Options().set("grid", grid_text(grid)); }

/// The array, and beside it the file that says where its nodes are, without a report.
FileTrial npy_trial(const Workbench& bench, const Grid& grid, ValueType type, std::string_view what) {
  TableHead head;
  head.grid = grid;
  head.channels = bench.subject().original().traits().channels;
  head.type = type;
  head.reach = reach_of(bench.subject().original().traits());
  return {on_grid(what, grid),
          ".npy",
          with_grid(grid).set("type", std::string(name_of(kValueTypeNames, type))),
          with_grid(grid),
          size_of(type) * numbers_on(bench, grid),
          0,
          emit_table_head(head).size()};
}

}  // namespace

Result<Found> find_float(Workbench& bench, double percent, const Progress& progress) {
  return find_on_ladder(
      bench, percent, [&](const Grid& grid) { return npy_trial(bench, grid, ValueType::kFloat32, "NPY, floats"); },
      progress);
}

Result<Found> find_half(Workbench& bench, double percent, const Progress& progress) {
  return find_on_ladder(
      bench, percent, [&](const Grid& grid) { return npy_trial(bench, grid, ValueType::kFloat16, "NPY, half floats"); },
      progress);
}

namespace {

/// What such a file of half floats takes beside its numbers, by one that has next to none.
std::uint64_t overhead_of_format(Workbench& bench, std::string_view extension, const Options& options) {
  const Grid grid = parse_grid("half-difference/0:90:90:90").value();
  Options few = options;
  few.set("grid", grid_text(grid));
  const Result<FileBytes> file = bench.file(extension, few, {});
  if (!file) return 0;
  return (*file)->size() - std::min<std::uint64_t>((*file)->size(), 2 * numbers_on(bench, grid));
}

/// A table on the ladder in a format whose numbers are packed.
Result<Found> find_packed(Workbench& bench, double percent, std::string_view extension, std::string_view what,
                          const Options& options, const Progress& progress) {
  const std::uint64_t overhead = overhead_of_format(bench, extension, options);
  return find_on_ladder(
      bench, percent,
      [&](const Grid& grid) {
        Options writing = options;
        writing.set("grid", grid_text(grid));
        return FileTrial{on_grid(what, grid), extension, writing, {}, 0, overhead};
      },
      progress);
}

}  // namespace

Result<Found> find_hdf5(Workbench& bench, double percent, const Progress& progress) {
  return find_packed(bench, percent, ".h5", "half floats, shuffle, deflate 9",
                     Options().set("type", "float16").set("deflate", "9"), progress);
}

Result<Found> find_exr(Workbench& bench, double percent, const Progress& progress) {
  return find_packed(bench, percent, ".exr", "half floats", Options().set("type", "float16"), progress);
}

Result<Found> find_merl(Workbench& bench, double percent, const Progress& progress) {
  constexpr std::uint64_t kNumbers = std::uint64_t{3} * 90 * 90 * 180;
  return find_file(
      bench, percent, 1,
      [](std::size_t) {
        return FileTrial{"doubles, 90 x 90 x 180 cells", ".binary", Options().set("merl-shape", "90,90,180"),
                         Options().set("merl-turn", "half"), 8 * kNumbers};
      },
      progress);
}

Result<Found> find_utia(Workbench& bench, double percent, const Progress& progress) {
  constexpr std::uint64_t kNumbers = std::uint64_t{3} * 6 * 48 * 6 * 48;
  return find_file(
      bench, percent, 1,
      [](std::size_t) {
        return FileTrial{"doubles, 6 x 48 x 6 x 48 nodes", ".bin", {}, {}, 8 * kNumbers};
      },
      progress);
}

namespace {

/// Bytes of the numbers of an RGL file.
std::uint64_t rgl_payload(const std::vector<std::byte>& bytes) {
  const Result<TensorFile> file = parse_tensor_file(bytes);
  if (!file) return 0;
  std::uint64_t sum = 0;
  for (const TensorField& field : file->fields) {
    if (field.name != "description") sum += field.bytes.size();
  }
  return sum;
}

}  // namespace

Result<Found> find_rgl(Workbench& bench, double percent, const Progress& progress) {
  static constexpr std::array<std::array<int, 3>, 4> kSizes = {{{8, 16, 8}, {16, 32, 8}, {32, 64, 16}, {64, 128, 32}}};
  Smallest smallest(percent);
  StepwiseProgress steps(progress);
  // A material that came as one also stands as it is, its differences between both ways included.
  if (const auto stored = bench.subject().original().stored("rgl")) {
    const Result<std::vector<std::byte>> bytes = read_range(*stored, 0, stored->size());
    if (!bytes) return bytes.error();
    const std::vector<std::byte>& as_it_is = *bytes;
    Result<Kept> kept = bench.kept("as it is", std::make_shared<const std::vector<std::byte>>(as_it_is), {});
    if (kept) {
      kept->overhead = kept->bytes - std::min(kept->bytes, rgl_payload(as_it_is));
      smallest.take(*std::move(kept));
    }
  }
  // With 33 azimuths of the light, the largest size is beyond what is written.
  const std::size_t sizes = bench.subject().symmetries().isotropic ? kSizes.size() : kSizes.size() - 1;
  for (const auto& [size, warp, thetas] : std::span(kSizes).first(sizes)) {
    const FileTrial trial = {fmt::format("{} x {} colours for each light", size, size), ".bsdf",
                             Options()
                                 .set("rgl-size", std::to_string(size))
                                 .set("rgl-warp-size", std::to_string(warp))
                                 .set("rgl-theta", std::to_string(thetas))};
    const Result<FileBytes> file = bench.file(trial.extension, trial.writing, steps.step(0.4));
    Result<Kept> kept = file ? bench.kept(trial.setting, *file, {}) : Result<Kept>(file.error());
    if (!kept) {
      if (!smallest.complain(kept.error())) return kept.error();
      continue;
    }
    kept->overhead = kept->bytes - std::min(kept->bytes, rgl_payload(**file));
    if (smallest.take(*std::move(kept))) break;
  }
  return std::move(smallest).found();
}

Result<Found> find_barycentric(Workbench& bench, double percent, const Progress& progress) {
  std::vector<UniformScheme> schemes = paper_schemes();
  std::sort(schemes.begin(), schemes.end(),
            [](const UniformScheme& a, const UniformScheme& b) { return a.direction_count() < b.direction_count(); });
  // Every third suffices to tell what such samples can do.
  std::vector<UniformScheme> tried;
  for (std::size_t k = 0; k < schemes.size(); k += 3) tried.push_back(schemes[k]);
  // Of a file with few numbers in it, as of those that are packed.
  const UniformScheme& smallest = tried.front();
  const Result<FileBytes> file = bench.file(".h5", Options().set("scheme", smallest.name), {});
  const std::uint64_t numbers = sizeof(float) * smallest.reciprocal_pair_count() * bench.subject().channel_count();
  const std::uint64_t overhead = file ? (*file)->size() - std::min<std::uint64_t>((*file)->size(), numbers) : 0;
  return find_file(
      bench, percent, tried.size(),
      [&](std::size_t k) {
        const UniformScheme& scheme = tried[k];
        const std::uint64_t pairs = scheme.reciprocal_pair_count();
        return FileTrial{
            fmt::format("{} pairs, scheme {}", pairs, scheme.name), ".h5", Options().set("scheme", scheme.name),
            Options().set("interpolation", "barycentric"),          0,     overhead};
      },
      progress);
}

}  // namespace sbrdf::internal
