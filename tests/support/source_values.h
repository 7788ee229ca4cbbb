#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "converters/files/format.h"
#include "converters/source/brdf_source.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {

/// Of one pair, in degrees.
inline std::vector<float> value(const BrdfSource& source, double theta_i, double phi_i, double theta_v, double phi_v) {
  const DirectionPair pair = {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
  std::vector<float> values(source.channel_count());
  source.evaluate(std::span(&pair, 1), values);
  return values;
}

inline bool is_measured(const BrdfSource& source, double theta_i, double phi_i, double theta_v, double phi_v) {
  const DirectionPair pair = {direction_from_degrees(theta_i, phi_i), direction_from_degrees(theta_v, phi_v)};
  std::uint8_t flag = 2;
  source.measured(std::span(&pair, 1), std::span(&flag, 1));
  return flag == 1;
}

inline bool has_remark(const Report& report, const std::string& key) {
  return std::any_of(report.remarks.begin(), report.remarks.end(), [&](const Remark& r) { return r.key == key; });
}

}  // namespace sbrdf::internal
