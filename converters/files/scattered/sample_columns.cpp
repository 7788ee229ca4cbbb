#include "converters/files/scattered/sample_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "converters/files/dense/dense_file.h"

namespace sbrdf::internal {
namespace {

enum class Role : std::uint8_t { kThetaI, kPhiI, kThetaV, kPhiV, kSkip, kChannel };
constexpr std::size_t kAngleCount = 4;
constexpr std::array<std::string_view, kAngleCount> kAngleNames = {"theta_i", "phi_i", "theta_v", "phi_v"};
constexpr std::string_view kSkipName = "skip";
/// As others call them, in lower case without '_', blanks and units.
constexpr std::array kKnownNames = {
    Named{"thetai", Role::kThetaI}, Named{"thetain", Role::kThetaI}, Named{"thetainc", Role::kThetaI},
    Named{"phii", Role::kPhiI},     Named{"phiin", Role::kPhiI},     Named{"phiinc", Role::kPhiI},
    Named{"thetav", Role::kThetaV}, Named{"thetao", Role::kThetaV},  Named{"thetaout", Role::kThetaV},
    Named{"thetar", Role::kThetaV}, Named{"thetas", Role::kThetaV},  Named{"phiv", Role::kPhiV},
    Named{"phio", Role::kPhiV},     Named{"phiout", Role::kPhiV},    Named{"phir", Role::kPhiV},
    Named{"phis", Role::kPhiV}};
/// Angles of this size are hardly degrees: more than pi/2 and a full turn, with room for rounding.
constexpr double kRadiansTheta = 1.58;
constexpr double kRadiansPhi = 6.3;
constexpr std::size_t kRadiansRows = 10;
constexpr double kLeastCosine = 1e-6;
constexpr double kHorizonTolerance = 1e-9;

struct Columns {
  std::vector<Role> roles;
  std::vector<std::string> channels;
  std::optional<SampleAngles> angles;  ///< that the names tell
};

std::vector<std::string> split_names(std::string_view text) {
  std::vector<std::string_view> fields;
  split_fields(text, Separator::kComma, fields);
  return {fields.begin(), fields.end()};
}

std::optional<std::size_t> angle_index(Role role) {
  return role < Role::kSkip ? std::optional(static_cast<std::size_t>(role)) : std::nullopt;
}

/// What every list of columns has to have; the message without the name of an option.
Result<Columns> check_columns(Columns columns, const std::vector<std::string>& names) {
  std::array<std::size_t, kAngleCount> times{};
  std::set<std::string> seen;
  for (std::size_t k = 0; k < names.size(); ++k) {
    if (const auto angle = angle_index(columns.roles[k])) ++times.at(*angle);
    if (columns.roles[k] != Role::kChannel) continue;
    if (names[k].empty()) return usage_error(fmt::format("column {} has no name", k + 1));
    if (!seen.insert(names[k]).second)
      return usage_error(fmt::format("two channels are named '{}'", field_text(names[k])));
    columns.channels.push_back(names[k]);
  }
  for (std::size_t angle = 0; angle < kAngleCount; ++angle) {
    const bool needed = kAngleNames.at(angle) != "phi_i";
    if (times.at(angle) > 1 || (needed && times.at(angle) == 0)) {
      return usage_error(
          fmt::format("{} stands {} among the columns", kAngleNames.at(angle), times.at(angle) == 0 ? "not" : "twice"));
    }
  }
  if (columns.channels.empty()) return usage_error("no column is that of a channel");
  if (columns.channels.size() > kMostTableChannels) return usage_error("more than 4096 channels");
  return columns;
}

Result<Columns> columns_of_option(std::string_view text) {
  const std::vector<std::string> names = split_names(text);
  Columns columns;
  for (const std::string& name : names) {
    const auto angle = std::find(kAngleNames.begin(), kAngleNames.end(), name);
    columns.roles.push_back(angle != kAngleNames.end() ? static_cast<Role>(angle - kAngleNames.begin())
                            : name == kSkipName        ? Role::kSkip
                                                       : Role::kChannel);
  }
  return check_columns(std::move(columns), names);
}

/// A name in lower case without what stands in brackets, quotes, '_' and blanks; and the unit that it tells.
struct PlainName {
  std::string text;
  std::optional<SampleAngles> angles;
};
PlainName plain_name(std::string_view name) {
  std::string lower;
  for (const char c : name) lower += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  PlainName plain;
  const std::size_t bracket = lower.find_first_of("([");
  for (const char c : lower.substr(0, bracket)) {
    if (c != '_' && c != ' ' && c != '"' && c != '\'' && c != '-') plain.text += c;
  }
  std::string unit = bracket == std::string::npos ? "" : lower.substr(bracket + 1);
  for (const std::string_view end : {"radians", "rad", "degrees", "deg"}) {
    if (!unit.empty() || !plain.text.ends_with(end)) continue;
    unit = end;
    plain.text.resize(plain.text.size() - end.size());
  }
  if (unit.starts_with("rad")) plain.angles = SampleAngles::kRadians;
  if (unit.starts_with("deg")) plain.angles = SampleAngles::kDegrees;
  return plain;
}

/// Columns by their names; all of them channels where no name is that of an angle.
Columns roles_by_name(const std::vector<std::string>& names) {
  Columns columns;
  for (const std::string& name : names) {
    const PlainName plain = plain_name(name);
    const Role role = value_of(kKnownNames, plain.text).value_or(Role::kChannel);
    columns.roles.push_back(role);
    if (role != Role::kChannel && plain.angles) columns.angles = plain.angles;
  }
  return columns;
}

bool names_angles(const Columns& columns) {
  return std::any_of(columns.roles.begin(), columns.roles.end(), [](Role role) { return role != Role::kChannel; });
}

/// The first four columns are the angles, the others channels.
Result<Columns> columns_in_order(std::size_t count, const std::vector<std::string>& names) {
  Columns columns;
  columns.roles = {Role::kThetaI, Role::kPhiI, Role::kThetaV, Role::kPhiV};
  std::vector<std::string> full(kAngleNames.begin(), kAngleNames.end());
  const std::vector<std::string> plain = default_channels(count - kAngleCount);
  for (std::size_t k = kAngleCount; k < count; ++k) {
    columns.roles.push_back(Role::kChannel);
    full.push_back(names.empty() ? plain[k - kAngleCount] : names[k]);
  }
  return check_columns(std::move(columns), full);
}

Result<Columns> columns_of(const NumberTable& table, const Options& options) {
  if (const auto text = options.text("scattered-columns")) {
    Result<Columns> columns = columns_of_option(*text);
    if (columns && columns->roles.size() != table.column_count) {
      return usage_error(
          fmt::format("--scattered-columns: {} names for {} columns", columns->roles.size(), table.column_count));
    }
    return columns;
  }
  for (const std::vector<std::string>& names : {table.names, table.comment_names}) {
    Columns columns = roles_by_name(names);
    if (!names_angles(columns)) continue;
    Result<Columns> checked = check_columns(std::move(columns), names);
    if (checked) return checked;
    return usage_error("the names of the columns: " + checked.error().message +
                       "; say what they are by --scattered-columns");
  }
  if (table.column_count <= kAngleCount) {
    return usage_error(fmt::format("{} columns, of which nothing says what they are; say it by --scattered-columns",
                                   table.column_count));
  }
  return columns_in_order(table.column_count, table.names);
}

using Angles = std::array<double, kAngleCount>;

class SampleReader {
 public:
  SampleReader(const NumberTable& table, const Columns& columns, const Options& options)
      : table_(table), columns_(columns), cosine_(options.text("scattered-quantity") == "f_r-cos") {
    samples_.channels = columns.channels;
    samples_.rows = table.row_count();
  }

  Result<Samples> read(const Options& options) {
    if (const auto text = options.text("scattered-angles")) {
      samples_.angles = value_of(kSampleAnglesNames, *text).value_or(SampleAngles::kDegrees);
    } else if (columns_.angles) {
      samples_.angles = *columns_.angles;
    } else if (look_like_radians()) {
      return usage_error("no angle is larger than 6.3: say by --scattered-angles whether they are radians or degrees");
    }
    for (std::size_t row = 0; row < table_.row_count(); ++row) {
      if (Status taken = take(row); !taken) return taken.error();
    }
    if (samples_.pairs.empty()) return invalid_file("no sample lies above the horizon");
    if (std::none_of(samples_.values.begin(), samples_.values.end(), [](double value) { return value > 0; })) {
      return invalid_file(
          fmt::format("none of {} samples has a positive value: this is no reflectance", samples_.pairs.size()));
    }
    return std::move(samples_);
  }

 private:
  [[nodiscard]] std::span<const double> row_of(std::size_t row) const {
    return std::span(table_.numbers).subspan(row * table_.column_count, table_.column_count);
  }

  [[nodiscard]] Angles angles_of(std::size_t row) const {
    Angles angles{};
    const std::span<const double> numbers = row_of(row);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (const auto angle = angle_index(columns_.roles[k])) angles.at(*angle) = numbers[k];
    }
    return angles;
  }

  [[nodiscard]] bool look_like_radians() const {
    if (table_.row_count() < kRadiansRows) return false;
    double theta = 0;
    double phi = 0;
    for (std::size_t row = 0; row < table_.row_count(); ++row) {
      const Angles at = angles_of(row);
      theta = std::max({theta, std::abs(at[0]), std::abs(at[2])});
      phi = std::max({phi, std::abs(at[1]), std::abs(at[3])});
    }
    return theta > 0 && theta <= kRadiansTheta && phi <= kRadiansPhi;
  }

  Status take(std::size_t row) {
    Angles at = angles_of(row);
    if (samples_.angles == SampleAngles::kRadians) {
      for (double& angle : at) angle = degrees_from_radians(angle);
    }
    bool negative = false;
    for (std::size_t k = 0; k < at.size(); k += 2) {
      if (std::abs(at.at(k)) > 180 || std::abs(at.at(k + 1)) > 3600) {
        return invalid_file(fmt::format("line {}: {} {:g}, {} {:g} degrees are no direction", table_.lines[row],
                                        kAngleNames.at(k), at.at(k), kAngleNames.at(k + 1), at.at(k + 1)));
      }
      if (at.at(k) >= 0) continue;
      negative = true;
      at.at(k) = -at.at(k);
      at.at(k + 1) += 180;
    }
    if (std::max(at[0], at[2]) > 90 + kHorizonTolerance) {
      ++samples_.below_horizon;
      return ok_status();
    }
    const DirectionPair pair = {direction_from_degrees(std::min(at[0], 90.0), at[1]),
                                direction_from_degrees(std::min(at[2], 90.0), at[3])};
    const double scale = cosine_ ? std::cos(pair.v.theta) : 1;
    if (scale < kLeastCosine) {
      ++samples_.at_horizon;
      return ok_status();
    }
    if (negative) ++samples_.negative_theta;
    const std::span<const double> numbers = row_of(row);
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      if (columns_.roles[k] != Role::kChannel) continue;
      if (!(std::abs(numbers[k] / scale) <= kTableLargest)) {
        return invalid_file(
            fmt::format("line {}: column {} is above {:g} as f_r", table_.lines[row], k + 1, kTableLargest));
      }
      samples_.values.push_back(numbers[k] / scale);
    }
    samples_.pairs.push_back(pair);
    samples_.lines.push_back(table_.lines[row]);
    return ok_status();
  }

  const NumberTable& table_;
  const Columns& columns_;
  bool cosine_;
  Samples samples_;
};

}  // namespace

Status check_sample_columns(std::string_view text) {
  const Result<Columns> columns = columns_of_option(text);
  return columns ? ok_status() : Status(columns.error());
}

Result<Samples> samples_of(const NumberTable& table, const Options& options) {
  const Result<Columns> columns = columns_of(table, options);
  if (!columns) return columns.error();
  return SampleReader(table, *columns, options).read(options);
}

}  // namespace sbrdf::internal
