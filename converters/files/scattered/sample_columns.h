#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "converters/files/options.h"
#include "formats/core/directions.h"
#include "formats/core/named.h"
#include "formats/core/result.h"
#include "formats/table/number_table.h"

namespace sbrdf::internal {

// What the columns of a table of scattered samples are (specs/scattered.md).

enum class SampleAngles : std::uint8_t { kDegrees, kRadians };
inline constexpr std::array kSampleAnglesNames = {Named{"degrees", SampleAngles::kDegrees},
                                                  Named{"radians", SampleAngles::kRadians}};
inline constexpr auto kSampleAnglesChoices = names_of(kSampleAnglesNames);
enum class SampleQuantity : std::uint8_t {
  kReflectance,        ///< f_r
  kReflectanceCosine,  ///< f_r cos(theta_v)
};
inline constexpr std::array kSampleQuantityNames = {Named{"f_r", SampleQuantity::kReflectance},
                                                    Named{"f_r-cos", SampleQuantity::kReflectanceCosine}};
inline constexpr auto kSampleQuantityChoices = names_of(kSampleQuantityNames);

/// Of --scattered-columns: names between commas, among them theta_i, theta_v and phi_v, each once, and at least one of
/// a channel. kUsage otherwise.
[[nodiscard]] Status check_sample_columns(std::string_view text);

/// Samples of a BRDF at any directions.
struct Samples {
  std::vector<std::string> channels;
  std::vector<DirectionPair> pairs;  ///< above the horizon; phi in [0, 2 pi)
  std::vector<double> values;        ///< f_r [1/sr], channel fastest
  std::vector<std::uint64_t> lines;  ///< of the file, from 1
  SampleAngles angles = SampleAngles::kDegrees;
  std::uint64_t rows = 0;            ///< of the file
  std::uint64_t below_horizon = 0;   ///< rows that were left out: a theta beyond 90 degrees
  std::uint64_t at_horizon = 0;      ///< rows that were left out: f_r cos(theta_v) with a cosine of 0
  std::uint64_t negative_theta = 0;  ///< rows with a theta below 0, which is one at phi + 180 degrees
};

/// Options: scattered-angles, scattered-quantity, scattered-columns.
///
/// kUsage where the columns are not those of --scattered-columns, where the names in the file are those of some angles
/// but not of all that are needed, and where angles look like radians and nothing says whether they are. kInvalidFile,
/// with the line, for angles beyond 180 (theta) or 3600 degrees (phi), for values
/// above kTableLargest, and where no row is above the horizon or no value positive.
[[nodiscard]] Result<Samples> samples_of(const NumberTable& table, const Options& options);

}  // namespace sbrdf::internal
