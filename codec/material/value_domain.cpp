#include "codec/material/value_domain.h"

#include <algorithm>

namespace sbrdf::internal {

ValueDomain choose_log_domain(std::span<const float> values, std::size_t channel_count, int floor_halvings) {
  ValueDomain domain;
  domain.kind = DomainKind::kLog;
  domain.floor_halvings = floor_halvings;
  std::vector<float> positive;
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    positive.clear();
    for (std::size_t k = channel; k < values.size(); k += channel_count) {
      if (values[k] > 0) positive.push_back(values[k]);
    }
    float reference = 1;
    if (!positive.empty()) {
      const auto middle = positive.begin() + static_cast<std::ptrdiff_t>(positive.size() / 2);
      std::nth_element(positive.begin(), middle, positive.end());
      reference = *middle;
    }
    domain.reference.push_back(reference);
  }
  return domain;
}

}  // namespace sbrdf::internal
