#pragma once

#include <array>

#include "codec/file/encoder.h"
#include "codec/frame/frame.h"
#include "codec/material/value_domain.h"
#include "codec/sampling/adaptive_sampling.h"
#include "formats/core/named.h"

namespace sbrdf {

// The choices of slicing by name: in options, metadata and reports.

inline constexpr std::array kFrameNames = {Named{"elevation", FrameId::kElevation},
                                           Named{"half-difference", FrameId::kHalfDifference}};
inline constexpr std::array kDomainNames = {Named{"linear", DomainKind::kLinear}, Named{"log", DomainKind::kLog}};
inline constexpr std::array kRefinementNames = {Named{"true", Refinement::kBySource},
                                                Named{"measured", Refinement::kByMeasured}};
inline constexpr std::array kChunkNames = {Named{"auto", ChunkSize::kAuto}, Named{"whole", ChunkSize::kWhole},
                                           Named{"split", ChunkSize::kSplit}};

}  // namespace sbrdf
