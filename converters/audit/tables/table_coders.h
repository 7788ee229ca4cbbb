#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "converters/audit/tables/log_table.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

/// A compressor of others, as it is used on a table of logarithms: lossy ones as they are, lossless ones on logarithms
/// in whole steps. Settings go from the coarsest to the finest.
struct TableCoder {
  std::string_view name;
  std::string_view bound;  ///< see AuditMethod
  std::size_t setting_count = 0;
  std::string (*setting_text)(std::size_t setting);
  /// What decode makes of encode's bytes; nullptr: no faster way is known.
  Planes (*approximate)(const LogTable& table, std::size_t setting) = nullptr;
  std::vector<std::byte> (*encode)(const LogTable& table, std::size_t setting);
  /// kInvalidFile where the compressor refuses. `like` says how many numbers there are.
  Result<Planes> (*decode)(std::span<const std::byte> bytes, const LogTable& like);
};

[[nodiscard]] std::span<const TableCoder> table_coders();

/// What a file would need beside the compressor's streams: nodes of four axes, the floor [bytes].
inline constexpr std::size_t kTableHeadBytes = 24;

}  // namespace sbrdf::internal
