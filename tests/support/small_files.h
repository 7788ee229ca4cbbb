#pragma once

#include <cstddef>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codec/file/reader.h"
#include "converters/files/format_table.h"
#include "converters/models/kurt.h"
#include "formats/merl/merl.h"
#include "formats/sbrdf/bundle.h"
#include "tests/support/rgl_small_material.h"

namespace sbrdf::internal::small_files {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

inline constexpr std::string_view kKurtJson =
    R"({"name": "small", "k_d": [0.2, 0.3, 0.4],
        "lobes": [{"k_s": [0.1, 0.1, 0.1], "f_0": 0.5, "m_x": 0.3, "m_y": 0.3, "alpha": 0}]})";

/// Values that rise from 1.
inline Bytes merl(const MerlShape& shape = {2, 3, 4}) {
  MerlTable table{shape, std::vector<double>(kMerlChannelCount * merl_cell_count(shape))};
  std::iota(table.values.begin(), table.values.end(), 1.0);
  return emit_merl(table);
}

inline Bytes make_sliced() {
  const auto source = make_kurt_source(parse_kurt_json(kKurtJson).value());
  Options options;
  options.set("placement", "40/180").set("samples", "40");
  MemorySink sink;
  Report report;
  if (Status saved = save_source(*find_writer(".sbrdf").value(), *source, sink, options, report); !saved) {
    throw std::runtime_error(saved.error().message);
  }
  return std::move(sink).take();
}

/// The same each time.
inline Bytes sliced() {
  static const Bytes file = make_sliced();
  return file;
}

/// Materials named a and b.
inline Bytes bundle() {
  const Bytes file = sliced();
  const std::vector<BundleInput> inputs = {{"a", file}, {"b", file}};
  return emit_bundle(inputs).value();
}

/// Nodes of the small dense tables; that of an NPY file has to be told.
inline constexpr std::string_view kSmallGrid = "difference/0:45:45:90";

inline Bytes saved_as(std::string_view extension) {
  const auto source = make_kurt_source(parse_kurt_json(kKurtJson).value());
  MemorySink sink;
  Report report;
  const Options options = Options().set("grid", std::string(kSmallGrid));
  if (Status saved = save_source(*find_writer(extension).value(), *source, sink, options, report); !saved) {
    throw std::runtime_error(saved.error().message);
  }
  return std::move(sink).take();
}

inline constexpr std::string_view kScattered =
    "# angles in degrees\n0 0 10 0 0.3 0.2 0.1\n30 0 10 0 0.3 0.2 0.1\n30 0 30 180 0.5 0.3 0.2\n60 0 30 90 0.2 0.1 "
    "0.1\n";

/// A valid file of a row of the format table. A new row needs one here.
inline Bytes of(std::string_view format) {
  if (format == "merl") return merl();
  if (format == "sbrdf") return sliced();
  if (format == "sbrdfz") return bundle();
  if (format == "kurt") return bytes_of(kKurtJson);
  if (format == "npy" || format == "exr" || format == "csv") return saved_as("." + std::string(format));
  if (format == "scattered") return bytes_of(kScattered);
  if (format == "rgl") return rgl_testing::emit(rgl_testing::SmallMaterial().fields());
  throw std::runtime_error("no small file of the format " + std::string(format));
}

}  // namespace sbrdf::internal::small_files
