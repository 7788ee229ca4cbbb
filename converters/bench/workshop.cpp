#include "converters/bench/workshop.h"

#include <utility>

#include "codec/file/encoder.h"
#include "converters/files/format_table.h"
#include "converters/slicing/slicing.h"
#include "formats/core/byte_sink.h"

namespace sbrdf::internal {

Result<FileBytes> Workshop::once(const std::string& key, const Make& make) {
  const auto known = made_.find(key);
  if (known != made_.end()) return known->second;
  Result<std::vector<std::byte>> bytes = make();
  if (!bytes) return bytes.error();
  auto file = std::make_shared<const std::vector<std::byte>>(*std::move(bytes));
  made_.emplace(key, file);
  return FileBytes(std::move(file));
}

Result<std::vector<std::byte>> Workshop::saved(const std::string& extension, const Options& options,
                                               const Progress& progress) const {
  const Result<const Format*> format = find_writer(extension);
  if (!format) return format.error();
  MemorySink sink;
  Report report;
  if (Status done = save_source(**format, source_, sink, options, report, progress); !done) return done.error();
  return std::move(sink).take();
}

Result<std::vector<std::byte>> Workshop::encoded(const SliceOptions& options, const Progress& progress) const {
  const Result<Slicing> slicing = slice_source(source_, options, progress);
  if (!slicing) return slicing.error();
  return encode_sliced(slicing->sliced, slicing->lattice, encoding_of(*slicing, options));
}

Result<FileBytes> Workshop::sliced(std::uint64_t samples, const Progress& progress) {
  return once("sliced " + std::to_string(samples), [&] {
    SliceOptions options;
    options.stop = SampleCount{samples};
    options.structure = SearchedStructure{.evaluations = search_evaluations_};
    return encoded(options, progress);
  });
}

Result<FileBytes> Workshop::sliced_for_growth(std::uint64_t samples, const Progress& progress) {
  return once("growth " + std::to_string(samples), [&] {
    SliceOptions options;
    options.stop = SampleCount{samples};
    options.structure = SearchedStructure{.evaluations = 1};
    options.fit_values = false;
    options.precision = 0.001;
    return encoded(options, progress);
  });
}

Result<FileBytes> Workshop::file(const std::string& extension, const Options& options, const Progress& progress) {
  std::string key = extension;
  for (const auto& [name, text] : options.all()) key.append(" --").append(name).append(" ").append(text);
  return once(key, [&] { return saved(extension, options, progress); });
}

}  // namespace sbrdf::internal
