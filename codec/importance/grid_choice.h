#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "codec/importance/importance_table.h"

namespace sbrdf::internal {

/// What a direction weighs: the mean of the channels, those below zero and those that are not finite taken as 0. One
/// entry of `weights` for each pair; on the caller's thread.
void weigh(const VectorBrdf& brdf, std::span<const glm::vec3> w_i, std::span<const glm::vec3> w_v,
           std::span<double> weights);

/// The grid that suits a BRDF, chosen by what it says at some thousands of pairs: which symmetries it has, how far its
/// lobe is from round, and at which distances from the mirror direction most of its light lies.
[[nodiscard]] ImportanceGrid choose_importance_grid(const VectorBrdf& brdf);

}  // namespace sbrdf::internal
