#pragma once

#include <array>

#include "codec/file/encoder.h"
#include "codec/frame/frame.h"
#include "codec/material/value_domain.h"
#include "codec/sampling/adaptive_sampling.h"
#include "converters/slicing/options.h"
#include "formats/core/named.h"

namespace sbrdf::internal {

// The choices of slicing by name. Options read these tables from left to right, metadata and reports from right to
// left, so what a report prints can be given as an option. "auto", where there is no choice yet, is the option's own.
//
//   value_of(kDomainNames, "log")                 -> DomainKind::kLog, or nothing for a name that is not there
//   name_of(kRefinementNames, slices.refinement)  -> "true" or "measured"

inline constexpr std::array kFrameNames = {Named{"elevation", FrameId::kElevation},
                                           Named{"half-difference", FrameId::kHalfDifference}};
inline constexpr std::array kDomainNames = {Named{"linear", DomainKind::kLinear}, Named{"log", DomainKind::kLog}};
inline constexpr std::array kRefinementNames = {Named{"true", Refinement::kBySource},
                                                Named{"measured", Refinement::kByMeasured}};
inline constexpr std::array kChunkNames = {Named{"auto", ChunkSize::kAuto}, Named{"whole", ChunkSize::kWhole},
                                           Named{"split", ChunkSize::kSplit}};
inline constexpr std::array kMetadataNames = {
    Named{"lean", MetadataDetail::kLean}, Named{"full", MetadataDetail::kFull}, Named{"none", MetadataDetail::kNone}};

}  // namespace sbrdf::internal
