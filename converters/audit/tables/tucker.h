#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "converters/audit/tables/log_table.h"
#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

/// Tucker's decomposition of a table of logarithms: a small core, and for each of the four angles and the channel a few
/// curves along it. All numbers are half floats.
struct Tucker {
  std::array<std::size_t, 5> nodes{};  ///< of the angles, and channels
  std::array<std::size_t, 5> ranks{};
  std::vector<float> core;                    ///< in C order
  std::array<std::vector<float>, 5> factors;  ///< [node][rank]

  [[nodiscard]] std::size_t number_count() const;
};

/// Its own directions of each axis, found once, of which any number can be kept.
class TuckerFamily {
 public:
  explicit TuckerFamily(const LogTable& table);

  /// Leaves out, along each axis, directions with at most that share of the squares each (higher-order SVD). Smaller
  /// shares keep more.
  [[nodiscard]] Tucker keep(double share) const;

 private:
  std::array<std::size_t, 5> nodes_{};
  std::vector<double> tensor_;
  double squares_ = 0;
  std::array<std::vector<double>, 5> values_;   ///< eigenvalues of each axis, the largest first
  std::array<std::vector<double>, 5> vectors_;  ///< [node][number]
};

/// Evaluated as it is: logarithms from the core and the interpolated curves. `subject` says channels and traits.
[[nodiscard]] std::unique_ptr<BrdfSource> make_tucker_source(const AuditSubject& subject, const LogTable& like,
                                                             Tucker tucker);

}  // namespace sbrdf::internal
