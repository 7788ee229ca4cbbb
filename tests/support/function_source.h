#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "converters/source/brdf_source.h"

namespace sbrdf::internal {

struct FunctionTraits {
  bool isotropic = false;
  bool reciprocal = false;
  std::vector<std::string> channels = {"R", "G", "B"};
};

/// A source that a test writes down as a function of the pair and the channel.
class FunctionSource final : public BrdfSource {
 public:
  using Function = std::function<double(const DirectionPair& pair, std::size_t channel)>;

  explicit FunctionSource(Function function, FunctionTraits traits = {}) : function_(std::move(function)) {
    traits_.format = "test";
    traits_.description = "a function";
    traits_.channels = std::move(traits.channels);
    traits_.isotropic = traits.isotropic;
    traits_.reciprocal = traits.reciprocal;
    traits_.slice_theta_max_deg = 80;
  }

  [[nodiscard]] const SourceTraits& traits() const override { return traits_; }
  void evaluate(std::span<const DirectionPair> pairs, std::span<float> values) const override {
    const std::size_t channels = channel_count();
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] = static_cast<float>(function_(pairs[k / channels], k % channels));
    }
  }

 private:
  Function function_;
  SourceTraits traits_;
};

}  // namespace sbrdf::internal
