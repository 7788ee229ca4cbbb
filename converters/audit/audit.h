#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "converters/audit/methods.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// What it takes to keep a material, one way and another, at equal error (specs/audit.md).

struct AuditSettings {
  std::vector<double> targets = {5, 2};  ///< relative L1 off the grid [%], falling
  std::vector<std::string> methods;      ///< names; empty: all
  std::uint64_t directions = 40'000;     ///< judged on off the grid, and as many on the grid of 2 degrees
};

/// One way to keep one material at one target.
struct AuditRow {
  std::string method;
  double target_percent = 0;
  bool reached = false;
  std::string setting;               ///< empty where nothing was found
  std::uint64_t bytes = 0;           ///< of all files
  std::uint64_t overhead = 0;        ///< of these, see Kept
  std::uint64_t resident_bytes = 0;  ///< by how much memory grows when it is opened and evaluated; two digits
  double grid_mre_percent = 0;       ///< on the grid of 2 degrees, no floor: the paper's
  double grid_rel_l1_percent = 0;
  double off_grid_mre_percent = 0;  ///< between its nodes, densely in highlights, floor a hundredth of the mean
  double off_grid_rel_l1_percent = 0;
  double largest = 0;  ///< difference off the grid [1/sr]
  double ratio = 0;    ///< of bytes to the smallest that reaches the target; 0 where it does not
  std::string note;    ///< why it is left out, or what went wrong

  [[nodiscard]] bool found() const { return !setting.empty(); }
};

/// Rows of a material that are known from before, and where new ones are noted as soon as they are there.
class AuditMemory {
 public:
  AuditMemory() = default;
  AuditMemory(const AuditMemory&) = delete;
  AuditMemory& operator=(const AuditMemory&) = delete;
  virtual ~AuditMemory() = default;

  /// Of that method and target; its ratio does not matter.
  [[nodiscard]] virtual std::optional<AuditRow> recall(std::string_view method, double target_percent) const = 0;
  virtual void note(const AuditRow& row) = 0;
};

/// Whether there are such methods. kUsage naming the first that is none, and what there is.
[[nodiscard]] Status check_methods(std::span<const std::string> names);

/// All methods that are wanted, at each target. `memory` may be nullptr. Errors of AuditSubject::make;
/// interrupted_error().
[[nodiscard]] Result<std::vector<AuditRow>> audit_material(const BrdfSource& source, const AuditSettings& settings,
                                                           AuditMemory* memory = nullptr,
                                                           const Progress& progress = {});

/// A way over several materials, at one target.
struct AuditTotal {
  std::string method;
  double target_percent = 0;
  std::uint64_t materials = 0;  ///< that it was tried on
  std::uint64_t reached = 0;    ///< of these
  std::uint64_t bytes = 0;      ///< of those that reach it
  double mean_bytes = 0;        ///< geometric mean of these; 0 where there are none
  double mean_ratio = 0;        ///< geometric mean of AuditRow::ratio over these; 0 likewise
};

/// In the order of the methods, for each target.
[[nodiscard]] std::vector<AuditTotal> total(std::span<const std::vector<AuditRow>> materials);

}  // namespace sbrdf::internal
