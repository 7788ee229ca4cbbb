#include "converters/baselines/schemes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "converters/json/members.h"
#include "formats/os/files.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostRings = 512;
constexpr std::size_t kLongestName = 200;                          // of a scheme [bytes]
constexpr std::uint64_t kLongestScheme = std::uint64_t{1} << 20U;  // of a file [bytes]

/// Rings at every `step_deg` below 80 degrees, and at 80; the counts are those beyond the normal.
struct TableRow {
  int step_deg;
  std::vector<std::size_t> counts;
};

const std::array<TableRow, 30>& table_1() {
  // clang-format off
  static const std::array<TableRow, 30> kTable = {{
    {28, {6, 10, 12}},
    {28, {6, 12, 18}},
    {28, {10, 12, 18}},
    {20, {6, 10, 12, 18}},
    {20, {6, 12, 18, 20}},
    {20, {10, 18, 20, 30}},
    {16, {6, 10, 12, 18, 20}},
    {16, {6, 12, 18, 20, 30}},
    {14, {6, 10, 12, 18, 20, 20}},
    {14, {6, 10, 12, 18, 20, 30}},
    {12, {4, 6, 10, 12, 18, 20, 30}},
    {12, {6, 10, 12, 12, 18, 20, 30}},
    {12, {6, 10, 12, 18, 20, 20, 30}},
    {12, {6, 10, 12, 18, 20, 30, 36}},
    {10, {4, 6, 10, 12, 18, 20, 30, 30}},
    {10, {4, 6, 10, 12, 18, 20, 30, 36}},
    {10, {6, 10, 12, 18, 20, 30, 30, 36}},
    {10, {6, 10, 12, 18, 20, 30, 36, 36}},
    {10, {6, 10, 12, 18, 20, 30, 36, 60}},
    {8, {4, 6, 10, 12, 18, 20, 20, 30, 30, 36}},
    {8, {4, 6, 10, 12, 18, 20, 30, 30, 36, 60}},
    {8, {6, 10, 12, 18, 20, 30, 30, 36, 36, 60}},
    {8, {6, 10, 12, 18, 20, 30, 36, 60, 60, 60}},
    {6, {4, 6, 6, 10, 10, 12, 12, 18, 18, 20, 20, 30, 30, 36}},
    {6, {4, 6, 6, 10, 12, 12, 18, 18, 20, 30, 30, 36, 36, 60}},
    {6, {6, 6, 10, 12, 12, 18, 18, 20, 20, 30, 30, 36, 36, 60}},
    {6, {6, 10, 12, 12, 18, 18, 20, 20, 30, 30, 36, 36, 60, 60}},
    {6, {4, 6, 10, 12, 18, 20, 30, 36, 60, 60, 60, 60, 60, 60}},
    {6, {6, 10, 12, 18, 20, 30, 36, 60, 60, 60, 60, 60, 60, 60}},
    {6, {60, 60, 60, 60, 60, 60, 60, 60, 60, 60, 60, 60, 60, 60}},
  }};
  // clang-format on
  return kTable;
}

UniformScheme scheme_of(const TableRow& row, std::string name) {
  UniformScheme scheme{std::move(name), {{0, 1}}};
  for (std::size_t k = 0; k < row.counts.size(); ++k) {
    const int theta = std::min(80, row.step_deg * static_cast<int>(k + 1));
    scheme.rings.push_back({static_cast<double>(theta), row.counts[k]});
  }
  return scheme;
}

/// What no ring may be, after those before it.
struct RingFault {
  const char* member;
  const char* what;
};
std::optional<RingFault> fault_of(const Ring& ring, std::span<const Ring> before) {
  if (before.empty()) {
    if (ring.theta_deg != 0) return RingFault{"theta_deg", "is not 0 in the first ring"};
    if (ring.count != 1) return RingFault{"count", "is not 1 in the first ring, the normal"};
    return std::nullopt;
  }
  if (!(ring.theta_deg > before.back().theta_deg)) {
    return RingFault{"theta_deg", "is not above that of the ring before"};
  }
  if (!(ring.theta_deg < 90)) return RingFault{"theta_deg", "is not below 90"};
  if (ring.count < 3) return RingFault{"count", "is below 3"};
  return std::nullopt;
}

Status check_size(const UniformScheme& scheme) {
  if (scheme.direction_count() <= kMostSchemeDirections) return ok_status();
  return unsupported(
      fmt::format("sampling scheme: {} directions, {} are the most", scheme.direction_count(), kMostSchemeDirections));
}

Ring read_ring(MemberReader& reader, const Json& json, const std::vector<Ring>& before) {
  reader.only(json, {"theta_deg", "count"});
  Ring ring;
  ring.theta_deg = reader.number(json, "theta_deg", 0, 90);
  ring.count = reader.whole(reader.member(json, "count"), "count", kMostSchemeDirections);
  if (const auto fault = fault_of(ring, before)) reader.refuse(fault->member, fault->what);
  return ring;
}

}  // namespace

std::uint64_t UniformScheme::direction_count() const {
  std::uint64_t count = 0;
  for (const Ring& ring : rings) count += ring.count;
  return count;
}

std::vector<UniformScheme> paper_schemes() {
  std::vector<UniformScheme> schemes;
  for (const TableRow& row : table_1()) schemes.push_back(scheme_of(row, std::to_string(schemes.size() + 1)));
  return schemes;
}

Result<UniformScheme> paper_scheme(std::string_view name) {
  for (UniformScheme& scheme : paper_schemes()) {
    if (scheme.name == name) return std::move(scheme);
  }
  return usage_error(
      fmt::format("there is no scheme '{}': they are 1 to {}, or a file NAME.json", name, table_1().size()));
}

Result<UniformScheme> parse_scheme(std::string_view text) {
  const Result<Json> json = parse_small_json(text);
  if (!json) return json.error();
  MemberReader reader;
  UniformScheme scheme;
  reader.only(*json, {"name", "rings"});
  scheme.name = reader.text(*json, "name");
  const bool printable = std::none_of(scheme.name.begin(), scheme.name.end(),
                                      [](char c) { return static_cast<unsigned char>(c) < 32 || c == 127; });
  if (scheme.name.empty() || scheme.name.size() > kLongestName || !printable) {
    reader.refuse("name", fmt::format("is not of 1 to {} bytes without control characters", kLongestName));
  }
  for (const Json& ring : reader.list(*json, "rings", kMostRings)) {
    reader.enter(fmt::format("rings[{}]", scheme.rings.size()));
    scheme.rings.push_back(read_ring(reader, ring, scheme.rings));
  }
  reader.enter("");
  if (scheme.rings.size() < 2) reader.refuse("rings", "has fewer than two rings");
  if (reader.error()) return invalid_file("sampling scheme: " + *reader.error());
  if (Status few = check_size(scheme); !few) return few.error();
  return scheme;
}

Status check_scheme(const UniformScheme& scheme) {
  if (scheme.rings.size() < 2) return invalid_file("sampling scheme: fewer than two rings");
  for (std::size_t k = 0; k < scheme.rings.size(); ++k) {
    const auto fault = fault_of(scheme.rings[k], std::span(scheme.rings).first(k));
    if (fault) return invalid_file(fmt::format("sampling scheme: rings[{}]: '{}' {}", k, fault->member, fault->what));
  }
  return check_size(scheme);
}

Result<UniformScheme> scheme_by_name(const std::string& name) {
  if (!name.ends_with(".json")) return paper_scheme(name);
  const Result<std::unique_ptr<ByteSource>> file = map_file(name);
  if (!file) return file.error();
  if ((*file)->size() > kLongestScheme) return unsupported("sampling scheme: longer than 1 MB");
  const Result<std::vector<std::byte>> bytes = read_range(**file, 0, (*file)->size());
  if (!bytes) return bytes.error();
  return parse_scheme({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
}

std::vector<Direction> scheme_angles(const UniformScheme& scheme) {
  std::vector<Direction> directions;
  for (const Ring& ring : scheme.rings) {
    for (std::size_t k = 0; k < ring.count; ++k) {
      const double phi_deg = 360.0 * static_cast<double>(k) / static_cast<double>(ring.count);
      directions.push_back(direction_from_degrees(ring.theta_deg, phi_deg));
    }
  }
  return directions;
}

std::vector<glm::dvec3> scheme_directions(const UniformScheme& scheme) {
  std::vector<glm::dvec3> vectors;
  for (const Direction& direction : scheme_angles(scheme)) vectors.push_back(vector_from_direction(direction));
  return vectors;
}

}  // namespace sbrdf::internal
