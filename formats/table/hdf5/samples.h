#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/core/byte_sink.h"
#include "formats/core/result.h"
#include "formats/table/hdf5/file.h"

namespace sbrdf::internal {

// Uniform samples in HDF5 (specs/hdf5.md): the rings of a scheme, and one row of values for each pair of directions
// that reciprocity leaves. What the words in it mean is known to converters/baselines.

/// What files that are written here say that they hold.
inline constexpr const char* kHdf5UniformSamples = "uniform samples";

struct Hdf5Samples {
  std::string scheme;                  ///< its name
  std::vector<double> ring_theta_deg;  ///< [degrees]
  std::vector<double> ring_count;      ///< whole numbers
  std::vector<std::string> channels;
  std::vector<float> values;  ///< f_r [1/sr], pairs x channels
  std::string interpolation;  ///< "barycentric", "rbf"
  std::string kernel;         ///< of "rbf": "linear"
  std::string description;    ///< of the material, one line
  double theta_max_deg = 90;  ///< as far as it was measured
};

/// At most so many rings, and channels.
inline constexpr std::uint64_t kHdf5MostRings = 4096;

/// Of a file whose content is kHdf5UniformSamples. kInvalidFile where something is missing, or of another size or kind;
/// kUnsupported for sizes beyond the limits, and numbers that lie in other files.
[[nodiscard]] Result<Hdf5Samples> read_hdf5_samples(const Hdf5File& file);

/// kUnsupported for more numbers than can be read again. The same bytes each time. `deflate` as of Hdf5TableWriter.
[[nodiscard]] Status write_hdf5_samples(ByteSink& sink, const Hdf5Samples& samples, const std::string& report,
                                        unsigned deflate);

}  // namespace sbrdf::internal
