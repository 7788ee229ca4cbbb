#include "converters/baselines/schemes.h"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include "converters/json/members.h"
#include "formats/core/directions.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostRings = 512;

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

Ring read_ring(MemberReader& reader, const Json& json, const std::vector<Ring>& before) {
  reader.only(json, {"theta_deg", "count"});
  Ring ring;
  ring.theta_deg = reader.number(json, "theta_deg", 0, 90);
  ring.count = reader.whole(reader.member(json, "count"), "count", kMostSchemeDirections);
  if (before.empty() ? ring.theta_deg != 0 : ring.theta_deg <= before.back().theta_deg) {
    reader.refuse("theta_deg", before.empty() ? "is not 0 in the first ring" : "is not above that of the ring before");
  }
  if (ring.theta_deg >= 90) reader.refuse("theta_deg", "is not below 90");
  if (before.empty() ? ring.count != 1 : ring.count < 3) {
    reader.refuse("count", before.empty() ? "is not 1 in the first ring, the normal" : "is below 3");
  }
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
  for (const Json& ring : reader.list(*json, "rings", kMostRings)) {
    reader.enter(fmt::format("rings[{}]", scheme.rings.size()));
    scheme.rings.push_back(read_ring(reader, ring, scheme.rings));
  }
  reader.enter("");
  if (scheme.rings.size() < 2) reader.refuse("rings", "has fewer than two rings");
  if (reader.error()) return invalid_file("sampling scheme: " + *reader.error());
  if (scheme.direction_count() > kMostSchemeDirections) {
    return unsupported(fmt::format("sampling scheme: {} directions, {} are the most", scheme.direction_count(),
                                   kMostSchemeDirections));
  }
  return scheme;
}

std::vector<glm::dvec3> scheme_directions(const UniformScheme& scheme) {
  std::vector<glm::dvec3> directions;
  for (const Ring& ring : scheme.rings) {
    for (std::size_t k = 0; k < ring.count; ++k) {
      const double phi_deg = 360.0 * static_cast<double>(k) / static_cast<double>(ring.count);
      directions.push_back(vector_from_direction(direction_from_degrees(ring.theta_deg, phi_deg)));
    }
  }
  return directions;
}

}  // namespace sbrdf::internal
