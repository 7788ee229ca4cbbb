#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "converters/files/format.h"
#include "converters/slicing/slicing.h"

namespace sbrdf::internal {

/// A file before it is written.
struct MadeFile {
  std::vector<std::byte> bytes;
  Report report;
  HeldBackError error;  ///< on directions that took no part in any choice
};

/// What people are told of the errors of a new file, on directions that took no part in any choice.
void remark_errors(const SliceReport& report, const std::vector<std::string>& channels, Report& told);

}  // namespace sbrdf::internal
