#pragma once

namespace sbrdf::internal {

/// With which distribution something is coded. Numbers stand in files: specs/sbrdf.md, sections 6 and 7.
///
/// Residuals of samples and crossings have kClasses contexts each for the base channel and for the others: by the
/// *activity*, how far off predictions were around there. Where much was missed, much will be missed again.
struct CodingContext {
  static constexpr unsigned kClasses = 16;
  static constexpr unsigned kCrossingBase = 0;
  static constexpr unsigned kCrossingOther = 16;
  static constexpr unsigned kSampleBase = 32;
  static constexpr unsigned kSampleOther = 48;
  static constexpr unsigned kGuideNode = 64;
  static constexpr unsigned kGuideSample = 65;
  static constexpr unsigned kResidualCount = 66;
  static constexpr unsigned kGroups = 4;  ///< of kClasses contexts each, those above in their order

  /// Whether a gap is halved: by depth, and within a depth by activity (4) and the gap before (2).
  static constexpr unsigned kFlagDepths = 6;
  static constexpr unsigned kFlagsPerDepth = 8;
  static constexpr unsigned kFlagCount = kFlagDepths * kFlagsPerDepth;
};

}  // namespace sbrdf::internal
