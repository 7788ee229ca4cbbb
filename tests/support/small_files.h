#pragma once

#include <cstddef>
#include <cstring>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "codec/file/reader.h"
#include "converters/files/atlas/manifest.h"
#include "converters/files/format_table.h"
#include "converters/models/analytic.h"
#include "formats/core/byte_source.h"
#include "formats/merl/merl.h"
#include "formats/ngan/ngan.h"
#include "formats/sbrdf/bundle.h"
#include "formats/utia/utia.h"
#include "tests/support/rgl_small_material.h"

namespace sbrdf::internal::small_files {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
  return {bytes.begin(), bytes.end()};
}

inline std::shared_ptr<const ByteSource> source_of(Bytes bytes) {
  return std::make_shared<OwnedMemorySource>(std::move(bytes));
}

inline constexpr std::string_view kKurtJson =
    R"({"name": "small", "k_d": [0.2, 0.3, 0.4],
        "lobes": [{"k_s": [0.1, 0.1, 0.1], "f_0": 0.5, "m_x": 0.3, "m_y": 0.3, "alpha": 0}]})";

inline constexpr std::string_view kWardJson =
    R"({"model": "ward", "name": "small", "k_d": [0.2, 0.3, 0.4],
        "lobes": [{"k_s": [0.1, 0.1, 0.1], "alpha_x": 0.3, "alpha_y": 0.2}]})";

inline constexpr std::string_view kGgxJson =
    R"({"model": "ggx", "name": "small", "k_d": [0.2, 0.3, 0.4],
        "lobes": [{"k_s": [0.1, 0.1, 0.1], "f_0": 0.5, "alpha_x": 0.3, "alpha_y": 0.2}]})";

/// A manifest; its texture, "small.ktx2", is not there.
inline Bytes atlas() {
  Atlas made;
  AtlasLayout& layout = made.layout;
  layout.frame = FrameId::kHalfDifference;
  layout.symmetries.isotropic = true;
  layout.axes = {AtlasAxis{{0}, {}}, AtlasAxis{{0, 180}, {0, 1}}, AtlasAxis{{0, 90}, {0, 1}},
                 AtlasAxis{{0, 90}, {0, 1}}};
  if (!lay_out(layout, 1024)) throw std::runtime_error("the small atlas has no layout");
  made.scales.assign(layout.tables.size(), {AtlasScale{}});
  made.domain.log = false;
  made.domain.most = {1, 1, 1};
  return bytes_of(emit_manifest(made, {"small.ktx2", "small.glsl", TexelFormat::kRgba32f, 1}, {}));
}

/// Values that rise from 1.
inline Bytes merl(const MerlShape& shape = {2, 3, 4}) {
  MerlTable table{shape, std::vector<double>(kMerlChannelCount * merl_cell_count(shape))};
  std::iota(table.values.begin(), table.values.end(), 1.0);
  return emit_merl(table);
}

/// Anisotropic; values that rise from 1.
inline Bytes ngan() {
  const NganHeader header = {{2, 3, 4, 5}};
  std::vector<float> values(header.channels * ngan_bin_count(header));
  std::iota(values.begin(), values.end(), 1.0f);
  Bytes bytes(ngan_file_size(header));
  const auto head = emit_ngan_header(header);
  std::memcpy(bytes.data(), head.data(), head.size());
  std::memcpy(bytes.data() + head.size(), values.data(), bytes.size() - head.size());
  return bytes;
}

/// 2 MB, as its size is all that tells the format; values that rise from 1.
inline Bytes utia() {
  static const Bytes file = [] {
    std::vector<double> values(utia_file_size(kUtiaStandard) / sizeof(double));
    std::iota(values.begin(), values.end(), 1.0);
    const auto bytes = std::as_bytes(std::span(values));
    return Bytes(bytes.begin(), bytes.end());
  }();
  return file;
}

inline Bytes make_sliced() {
  const auto source = make_analytic_source(parse_analytic_json(kKurtJson).value());
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
  const auto source = make_analytic_source(parse_analytic_json(kKurtJson).value());
  MemorySink sink;
  Report report;
  const Options options = Options().set("grid", std::string(kSmallGrid));
  if (Status saved = save_source(*find_writer(extension).value(), *source, sink, options, report); !saved) {
    throw std::runtime_error(saved.error().message);
  }
  return std::move(sink).take();
}

/// f_r = 0.1 + 0.2 cos(radial / 2) + 0.05 cos(azimuth) of a monochrome file, at two rotations and incidences.
inline std::string zemax_text() {
  std::string text =
      "Source\tMeasured\r\nSymmetry\tAsymmetrical4D\r\nSpectralContent\tMonochrome\r\nScatterType\tBRDF\r\n"
      "SampleRotation\t2\r\n0\t180\r\nAngleOfIncidence\t2\r\n10\t60\r\n"
      "ScatterAzimuth\t5\r\n0\t90\t180\t270\t360\r\nScatterRadial\t4\r\n0\t20\t90\t180\r\n\r\n"
      "Monochrome\r\nDataBegin\r\n";
  for (int block = 0; block < 4; ++block) {
    text += "TIS\t0.5\r\n";
    for (const char* row : {"0.30\t0.29\t0.24\t0.10", "0.30\t0.28\t0.23\t0.10", "0.30\t0.27\t0.22\t0.10",
                            "0.30\t0.28\t0.23\t0.10", "0.30\t0.29\t0.24\t0.10"}) {
      text += std::string(row) + "\r\n";
    }
  }
  return text + "DataEnd\r\n";
}

/// Five patches: one to theta 30, four around it. Value of row r (outgoing) and column c (incident): 0.01 (5 r + c +
/// 1).
inline std::string klems_text() {
  std::string numbers;
  for (int k = 1; k <= 25; ++k)
    numbers += "0." + std::string(k < 10 ? "0" : "") + std::to_string(k) + (k % 5 ? ", " : "\n");
  const auto ring = [](const char* count, const char* lower, const char* upper) {
    return "<AngleBasisBlock><nPhis>" + std::string(count) + "</nPhis><ThetaBounds><LowerTheta>" + lower +
           "</LowerTheta><UpperTheta>" + upper + "</UpperTheta></ThetaBounds></AngleBasisBlock>\n";
  };
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<WindowElement "
         "xmlns=\"http://windows.lbl.gov\">\n<Optical><Layer>\n"
         "<Material><Name>small</Name></Material>\n"
         "<DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis>\n"
         "<AngleBasisName>Five</AngleBasisName>\n" +
         ring("1", "0", "30") + ring("4", "30", "90") +
         "</AngleBasis></DataDefinition>\n<WavelengthData><Wavelength unit=\"Integral\">Visible</Wavelength>\n"
         "<WavelengthDataBlock><WavelengthDataDirection>Reflection Front</WavelengthDataDirection>\n"
         "<ColumnAngleBasis>Five</ColumnAngleBasis><RowAngleBasis>Five</RowAngleBasis>\n"
         "<ScatteringDataType>BTDF</ScatteringDataType>\n<ScatteringData>\n" +
         numbers + "</ScatteringData>\n</WavelengthDataBlock></WavelengthData>\n</Layer></Optical>\n</WindowElement>\n";
}

inline constexpr std::string_view kScattered =
    "# angles in degrees\n0 0 10 0 0.3 0.2 0.1\n30 0 10 0 0.3 0.2 0.1\n30 0 30 180 0.5 0.3 0.2\n60 0 30 90 0.2 0.1 "
    "0.1\n";

/// A valid file of a row of the format table. A new row needs one here.
inline Bytes of(std::string_view format) {
  if (format == "merl") return merl();
  if (format == "ngan") return ngan();
  if (format == "utia") return utia();
  if (format == "sbrdf") return sliced();
  if (format == "sbrdfz") return bundle();
  if (format == "kurt") return bytes_of(kKurtJson);
  if (format == "ward") return bytes_of(kWardJson);
  if (format == "ggx") return bytes_of(kGgxJson);
  if (format == "zemax") return bytes_of(zemax_text());
  if (format == "klems") return bytes_of(klems_text());
  if (format == "hdf5") return saved_as(".h5");
  if (format == "npy" || format == "exr" || format == "csv") return saved_as("." + std::string(format));
  if (format == "atlas") return atlas();
  if (format == "scattered") return bytes_of(kScattered);
  if (format == "rgl") return rgl_testing::emit(rgl_testing::SmallMaterial().fields());
  throw std::runtime_error("no small file of the format " + std::string(format));
}

}  // namespace sbrdf::internal::small_files
