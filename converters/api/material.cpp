#include <sbrdf/sbrdf.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <thread>

#include "codec/evaluation/vector_evaluator.h"
#include "codec/file/encoder.h"
#include "codec/file/reader.h"
#include "codec/importance/importance_table.h"
#include "codec/series/series_file.h"
#include "converters/files/analytic/analytic_file.h"
#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "converters/files/sliced/series_source.h"
#include "converters/files/sliced/sliced.h"
#include "formats/core/parallel.h"
#include "formats/os/atomic_file.h"
#include "formats/os/files.h"

namespace sbrdf {
namespace {

using Bytes = std::shared_ptr<const internal::ByteSource>;
using Status = Result<std::monostate>;

constexpr std::size_t kBlock = 256;  // pairs translated and evaluated at a time

Error error_of(const internal::Error& error) {
  return {static_cast<ErrorCode>(error.code), error.message, error.offset};
}

// Angles that are no numbers are no direction of the upper hemisphere: below the horizon, where values are 0.
internal::DirectionPair finite(const internal::DirectionPair& pair) {
  const double sum = pair.i.theta + pair.i.phi + pair.v.theta + pair.v.phi;
  constexpr internal::Direction kBelow = {internal::kPi, 0};
  return std::isfinite(sum) ? pair : internal::DirectionPair{kBelow, kBelow};
}

internal::DirectionPair pair_of(const DirectionPair& pair) {
  return finite({{pair.i.theta, pair.i.phi}, {pair.v.theta, pair.v.phi}});
}

internal::DirectionPair pair_of(const glm::vec3& w_i, const glm::vec3& w_v) {
  return finite({internal::direction_from_vector(glm::dvec3(w_i)), internal::direction_from_vector(glm::dvec3(w_v))});
}

glm::vec3 vector_of(const std::array<float, 3>& w) { return {w[0], w[1], w[2]}; }

std::array<float, 3> vector_of(const Direction& direction) {
  const glm::vec3 w(internal::vector_from_direction({direction.theta, direction.phi}));
  return {w.x, w.y, w.z};
}

Traits traits_of(const internal::SourceTraits& traits) {
  return {traits.format, traits.description, traits.channels, traits.isotropic, traits.reciprocal, {}};
}

std::vector<Finding> findings_of(std::span<const internal::Finding> findings) {
  std::vector<Finding> copy;
  for (const internal::Finding& finding : findings) copy.push_back({finding.what, finding.count, finding.total});
  return copy;
}

internal::Options options_of(const Options& options, const std::optional<std::uint64_t>& memory_limit = {}) {
  internal::Options given = internal::within({memory_limit});
  for (const auto& [name, text] : options) given.set(name, text);
  return given;
}

internal::Result<Bytes> map(const std::string& path) {
  internal::Result<std::unique_ptr<internal::ByteSource>> file = internal::map_file(path);
  if (!file) return file.error();
  return Bytes(*std::move(file));
}

constexpr double kPresampledTolerance = 5e-4;

internal::Progress progress_of(const Progress& progress) { return {progress}; }

}  // namespace

struct [[gnu::visibility("hidden")]] Material::State {
  mutable Traits traits;  ///< findings come in when they are asked for
  std::string metadata;
  std::shared_ptr<const internal::BrdfSource> source;  ///< of a whole material
  std::optional<internal::PartialSliced> part;         ///< of a part; then there is no source
  std::optional<internal::VectorEvaluator> form;       ///< where it is not the source's own
  mutable std::once_flag findings_asked;
  mutable std::once_flag drawing_asked;
  mutable std::optional<internal::ImportanceTable> drawing;

  static Result<Material> open(Bytes bytes, const OpenOptions& options);
  static Result<Material> open_model(const std::string& name, const OpenOptions& options);
  static Result<Material> open_whole(Bytes bytes, const OpenOptions& options);
  static Result<Material> open_part(const Bytes& bytes, const OpenOptions& options);
  static Result<Material> open_level(const Bytes& bytes, const OpenOptions& options);
  static Material make_whole(std::shared_ptr<const internal::BrdfSource> source,
                             std::optional<internal::VectorEvaluator> form = {});

  void evaluate(std::span<const internal::DirectionPair> pairs, std::span<float> values) const {
    if (source) return source->evaluate(pairs, values);
    const std::size_t channels = traits.channels.size();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      const std::span<float> own = values.subspan(k * channels, channels);
      if (!part->evaluate(pairs[k], own)) std::fill(own.begin(), own.end(), std::nanf(""));
    }
  }

  /// On this thread.
  void evaluate_here(std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v, std::span<float> values) const {
    if (form) return form->evaluate(w_i, w_v, values);
    if (source) return source->evaluate_vectors(w_i, w_v, values);
    // A part has angles only.
    const std::size_t channels = traits.channels.size();
    for (std::size_t k = 0; k < w_i.size(); ++k) {
      const std::array pair = {pair_of(w_i[k], w_v[k])};
      evaluate(pair, values.subspan(k * channels, channels));
    }
  }

  /// On all cores. The vectors are what the source takes, x, y and z.
  void evaluate_vectors(std::span<const std::array<float, 3>> w_i, std::span<const std::array<float, 3>> w_v,
                        std::span<float> values) const {
    const std::size_t channels = traits.channels.size();
    internal::parallel_blocks(w_i.size(), kBlock, [&](std::size_t first, std::size_t size) {
      std::array<glm::vec3, kBlock> i;
      std::array<glm::vec3, kBlock> v;
      for (std::size_t done = 0; done < size; done += kBlock) {
        const std::size_t count = std::min(kBlock, size - done);
        for (std::size_t k = 0; k < count; ++k) {
          i[k] = vector_of(w_i[first + done + k]);
          v[k] = vector_of(w_v[first + done + k]);
        }
        evaluate_here(std::span(i).first(count), std::span(v).first(count),
                      values.subspan((first + done) * channels, count * channels));
      }
    });
  }

  /// Made when the first direction is drawn, or a density asked for.
  [[nodiscard]] const internal::ImportanceTable& for_drawing() const {
    std::call_once(drawing_asked, [&] {
      const auto evaluate_vectors = [&](std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
                                        std::span<float> own) { evaluate_here(w_i, w_v, own); };
      // In an arena of its own: a thread that waits for others here must not begin tasks of the caller's, which may
      // draw, too, and would wait for this.
      internal::with_threads(std::max(1U, std::thread::hardware_concurrency()), [&] {
        drawing.emplace(internal::make_importance_table({evaluate_vectors, traits.channels.size(), traits.isotropic}));
      });
    });
    return *drawing;
  }

  /// One block at most, on this thread.
  void draw_block(std::span<const std::array<float, 3>> w_i, std::span<const std::array<float, 2>> u,
                  std::span<Sample> samples, std::span<float> values) const {
    const internal::ImportanceTable& table = for_drawing();
    std::array<glm::vec3, kBlock> i;
    std::array<glm::vec3, kBlock> v;
    for (std::size_t k = 0; k < w_i.size(); ++k) {
      i[k] = vector_of(w_i[k]);
      const internal::DrawnDirection drawn = table.sample(i[k], {u[k][0], u[k][1]});
      v[k] = drawn.w_v;
      samples[k] = {{v[k].x, v[k].y, v[k].z}, drawn.pdf};
    }
    evaluate_here(std::span(i).first(w_i.size()), std::span(v).first(w_i.size()), values);
    const std::size_t channels = traits.channels.size();
    for (std::size_t k = 0; k < w_i.size(); ++k) {
      if (samples[k].pdf > 0) continue;
      const std::span own = values.subspan(k * channels, channels);
      std::fill(own.begin(), own.end(), 0.0F);
    }
  }

  /// `pair_at(k)` for k in [0, count), translated into arrays of a fixed size.
  template <class PairAt>
  void evaluate_blocks(std::size_t count, const PairAt& pair_at, std::span<float> values) const {
    const std::size_t channels = traits.channels.size();
    assert(values.size() == count * channels);
    internal::parallel_for((count + kBlock - 1) / kBlock, [&](std::uint64_t block) {
      const auto first = static_cast<std::size_t>(block) * kBlock;
      const std::size_t size = std::min(kBlock, count - first);
      std::array<internal::DirectionPair, kBlock> pairs;
      for (std::size_t k = 0; k < size; ++k) pairs[k] = pair_at(first + k);
      evaluate(std::span(pairs).first(size), values.subspan(first * channels, size * channels));
    });
  }
};

namespace {

Status check_part(const Part& part) {
  if (!(part.theta_max_deg > 0 && part.theta_max_deg <= 90)) {
    return Error{ErrorCode::kUsage, "a part's theta_max_deg must be above 0 and at most 90", {}};
  }
  if (part.level < 0 || part.level > internal::kMaxDepth) {
    return Error{ErrorCode::kUsage, "a part's level must be 0 to " + std::to_string(internal::kMaxDepth), {}};
  }
  return std::monostate{};
}

internal::CellSet cells_of(const Part& part, const internal::Lattice& lattice) {
  if (part.pairs.empty()) {
    const internal::DirectionBox box = {0, part.theta_max_deg, 0, 0};
    return internal::cells_in(lattice, box, box);
  }
  const double theta_max = internal::radians_from_degrees(part.theta_max_deg);
  std::vector<internal::DirectionPair> pairs;
  for (const DirectionPair& pair : part.pairs) {
    if (pair.i.theta <= theta_max && pair.v.theta <= theta_max) pairs.push_back(pair_of(pair));
  }
  return internal::cells_of(lattice, pairs);
}

}  // namespace

Result<Material> Material::State::open_whole(Bytes bytes, const OpenOptions& options) {
  internal::Result<std::unique_ptr<internal::BrdfSource>> source =
      internal::open_source(std::move(bytes), options_of(options.format, options.memory_limit));
  if (!source) return error_of(source.error());
  return make_whole(*std::move(source));
}

Material Material::State::make_whole(std::shared_ptr<const internal::BrdfSource> source,
                                     std::optional<internal::VectorEvaluator> form) {
  auto state = std::make_shared<State>();
  state->traits = traits_of(source->traits());
  state->metadata = source->metadata();
  state->source = std::move(source);
  state->form = std::move(form);
  return Material(std::move(state));
}

Result<Material> Material::State::open_part(const Bytes& bytes, const OpenOptions& options) {
  if (Status possible = check_part(*options.part); !possible) return possible.error();
  const internal::Result<const internal::Format*> format = internal::recognise(*bytes);
  if (!format) return error_of(format.error());
  if (!(*format)->capabilities.has(internal::Capability::kParts)) {
    return Error{ErrorCode::kUnsupported, std::string((*format)->extension) + " files cannot be loaded in part", {}};
  }
  const internal::Options given = options_of(options.format);
  const std::string whose = std::string((*format)->extension) + " files that are read";
  const internal::Status known = internal::check_options(given, (*format)->options, internal::OptionUse::kRead, whose);
  if (!known) return error_of(known.error());
  if (internal::is_series_file(*bytes)) return open_level(bytes, options);
  const internal::Result<internal::SlicedReader> reader = internal::SlicedReader::open(*bytes, {options.memory_limit});
  if (!reader) return error_of(reader.error());
  const internal::CellSet cells = cells_of(*options.part, reader->lattice());
  internal::Result<internal::PartialSliced> part = reader->load(cells, options.part->level);
  if (!part) return error_of(part.error());
  internal::Result<std::string> metadata = reader->metadata();
  if (!metadata) return error_of(metadata.error());
  auto state = std::make_shared<State>();
  state->traits = traits_of(internal::sliced_traits(reader->index().frame, reader->index().channels));
  state->metadata = *std::move(metadata);
  state->part.emplace(*std::move(part));
  return Material(std::move(state));
}

Result<Material> Material::State::open_level(const Bytes& bytes, const OpenOptions& options) {
  if (!options.part->pairs.empty() || options.part->theta_max_deg < 90) {
    return Error{ErrorCode::kUnsupported, "a dense file is loaded as a whole, or up to a level", {}};
  }
  internal::Result<std::unique_ptr<internal::BrdfSource>> source =
      internal::open_series(bytes, {options.memory_limit}, static_cast<std::uint32_t>(options.part->level));
  if (!source) return error_of(source.error());
  return make_whole(*std::move(source));
}

Result<Material> Material::State::open_model(const std::string& name, const OpenOptions& options) {
  if (options.part) return Error{ErrorCode::kUnsupported, "a model cannot be loaded in part", {}};
  if (!options.format.empty()) {
    return Error{ErrorCode::kUsage, "--" + options.format.begin()->first + ": a model has no options", {}};
  }
  internal::Result<internal::OpenedSource> opened = internal::open_source(name);
  if (!opened) return error_of(opened.error());
  return make_whole(std::move(opened->source));
}

Result<Material> Material::State::open(Bytes bytes, const OpenOptions& options) {
  return options.part ? open_part(bytes, options) : open_whole(std::move(bytes), options);
}

Result<Material> Material::open(const std::string& name, const OpenOptions& options) {
  if (internal::is_named(name)) return State::open_model(name, options);
  // A part is read where it lies; anything else is read once, where nobody can make it shorter.
  internal::Result<Bytes> bytes = options.part && internal::is_ordinary_file(name)
                                      ? map(name)
                                      : internal::open_named_bytes(name, {options.memory_limit});
  if (!bytes) return error_of(bytes.error());
  return State::open(*std::move(bytes), options);
}

Result<Material> Material::open(std::vector<std::byte> bytes, const OpenOptions& options) {
  return State::open(std::make_shared<internal::OwnedMemorySource>(std::move(bytes)), options);
}

Result<Material> Material::open(std::uint64_t size, ReadRange read, const OpenOptions& options) {
  const auto read_range = [read = std::move(read)](std::uint64_t offset, std::span<std::byte> target) {
    std::optional<Error> error = read(offset, target);
    if (!error) return internal::ok_status();
    return internal::Status(
        internal::Error{static_cast<internal::ErrorCode>(error->code), std::move(error->message), error->offset});
  };
  return State::open(std::make_shared<internal::CallbackSource>(size, read_range), options);
}

Material::Material(std::shared_ptr<const State> state) : state_(std::move(state)) {}

const Traits& Material::traits() const {
  std::call_once(state_->findings_asked, [&] {
    if (state_->source) state_->traits.findings = findings_of(state_->source->findings());
  });
  return state_->traits;
}
std::size_t Material::channel_count() const { return state_->traits.channels.size(); }
const std::string& Material::metadata() const { return state_->metadata; }

void Material::evaluate(const DirectionPair& pair, std::span<float> values) const {
  assert(values.size() == channel_count());
  const std::array pairs = {pair_of(pair)};
  state_->evaluate(pairs, values);
}

void Material::evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const {
  state_->evaluate_blocks(
      pairs.size(), [&](std::size_t k) { return pair_of(pairs[k]); }, values);
}

void Material::evaluate(std::span<const std::array<float, 3>> w_i, std::span<const std::array<float, 3>> w_v,
                        std::span<float> values) const {
  assert(w_i.size() == w_v.size());
  state_->evaluate_vectors(w_i, w_v, values);
}

Result<Material> Material::in_form(Form form) const {
  const internal::DecodedSliced* slices = state_->source ? state_->source->sliced() : nullptr;
  if (slices == nullptr) return Error{ErrorCode::kUnsupported, "only a whole sliced material has several forms", {}};
  if (form == Form::kExact) return State::make_whole(state_->source);
  const internal::VectorEvaluator exact(slices->sliced, slices->lattice);
  if (form == Form::kPresampled) return State::make_whole(state_->source, exact.presampled(kPresampledTolerance));
  if (!state_->traits.isotropic) {
    return Error{
        ErrorCode::kUnsupported, "the dense form of an anisotropic material would be too large to be fast", {}};
  }
  if (slices->lattice.corners.size() * exact.channel_count() * sizeof(float) > internal::DenseLimits().most_bytes) {
    return Error{ErrorCode::kUnsupported, "the dense form of this material would take more than 8 MiB", {}};
  }
  return State::make_whole(state_->source, exact.dense(slices->sliced, slices->lattice));
}

Sample Material::sample(const std::array<float, 3>& w_i, const std::array<float, 2>& u, std::span<float> values) const {
  assert(values.size() == channel_count());
  Sample drawn;
  state_->draw_block(std::span(&w_i, 1), std::span(&u, 1), std::span(&drawn, 1), values);
  return drawn;
}

Sample Material::sample(const Direction& i, const std::array<float, 2>& u, std::span<float> values) const {
  return sample(vector_of(i), u, values);
}

void Material::sample(std::span<const std::array<float, 3>> w_i, std::span<const std::array<float, 2>> u,
                      std::span<Sample> samples, std::span<float> values) const {
  const std::size_t channels = channel_count();
  assert(w_i.size() == samples.size() && u.size() == samples.size() && values.size() == samples.size() * channels);
  internal::parallel_for((samples.size() + kBlock - 1) / kBlock, [&](std::uint64_t block) {
    const auto first = static_cast<std::size_t>(block) * kBlock;
    const std::size_t size = std::min(kBlock, samples.size() - first);
    state_->draw_block(w_i.subspan(first, size), u.subspan(first, size), samples.subspan(first, size),
                       values.subspan(first * channels, size * channels));
  });
}

float Material::pdf(const std::array<float, 3>& w_i, const std::array<float, 3>& w_v) const {
  return state_->for_drawing().pdf(vector_of(w_i), vector_of(w_v));
}

float Material::pdf(const DirectionPair& pair) const { return pdf(vector_of(pair.i), vector_of(pair.v)); }

bool Material::covers(const DirectionPair& pair) const { return !state_->part || state_->part->covers(pair_of(pair)); }

namespace {

/// A writer is given the bytes and the report of `source` as a file of `format`.
Result<Report> write(const internal::Format& format, const internal::BrdfSource* source, internal::ByteSink& sink,
                     const SaveOptions& options) {
  if (source == nullptr) return Error{ErrorCode::kUnsupported, "a part of a material cannot be saved", {}};
  internal::Report told;
  const internal::Status saved =
      internal::save_source(format, *source, sink, options_of(options.format), told, progress_of(options.progress));
  if (!saved) return error_of(saved.error());
  Report report = {std::string(format.name), told.bytes, {}};
  for (const internal::Remark& remark : told.remarks) {
    report.remarks.push_back({remark.key, remark.value, remark.text});
  }
  return report;
}

}  // namespace

Result<Report> Material::save(const std::string& path, const SaveOptions& options) const {
  const internal::Result<const internal::Format*> format = internal::find_writer(internal::extension_of(path));
  if (!format) return error_of(format.error());
  const internal::Result<std::unique_ptr<internal::AtomicFile>> file = internal::AtomicFile::create(path);
  if (!file) return error_of(file.error());
  Result<Report> report = write(**format, state_->source.get(), **file, options);
  if (!report) return report;
  if (const internal::Status written = (*file)->commit(); !written) return error_of(written.error());
  return report;
}

Result<SavedBytes> Material::save_to_memory(std::string_view extension, const SaveOptions& options) const {
  const internal::Result<const internal::Format*> format = internal::find_writer(extension);
  if (!format) return error_of(format.error());
  internal::MemorySink sink;
  Result<Report> report = write(**format, state_->source.get(), sink, options);
  if (!report) return report.error();
  return SavedBytes{std::move(sink).take(), *std::move(report)};
}

DirectionPair pair_from_degrees(double theta_i_deg, double phi_i_deg, double theta_v_deg, double phi_v_deg) {
  const internal::Direction i = internal::direction_from_degrees(theta_i_deg, phi_i_deg);
  const internal::Direction v = internal::direction_from_degrees(theta_v_deg, phi_v_deg);
  return {{i.theta, i.phi}, {v.theta, v.phi}};
}

const char* version() { return SBRDF_VERSION; }

}  // namespace sbrdf
