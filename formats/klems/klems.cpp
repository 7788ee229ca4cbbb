#include "formats/klems/klems.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <utility>

#include "formats/core/numbers.h"

namespace sbrdf::internal {
namespace {

constexpr std::string_view kSeparators = " \t\r\n,";
constexpr std::string_view kBlank = " \t\r\n";
/// Of neighbouring bounds in a file [degrees].
constexpr double kBoundTolerance = 1e-4;
constexpr std::uint32_t kMostPhis = 3600;
constexpr std::size_t kMostRings = 1000;

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](char c) { return lower(c); });
  return result;
}

std::string_view trimmed(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  return text.substr(0, text.find_last_not_of(kBlank) + 1);
}

/// At most so much that a message stays one short line of plain letters.
std::string shown(std::string_view text) {
  std::string result(text.substr(0, 60));
  for (char& c : result) c = c >= ' ' && c <= '~' ? c : '?';
  return text.size() > 60 ? result + "..." : result;
}

std::string_view child_text(const pugi::xml_node& node, const char* name) { return trimmed(node.child_value(name)); }

Error error_at(const pugi::xml_node& node, std::string message) {
  const std::ptrdiff_t offset = node.offset_debug();
  return offset < 0 ? invalid_file(std::move(message))
                    : invalid_file(std::move(message), static_cast<std::uint64_t>(offset));
}

/// The rings that an AngleBasis lists; none where it only has a name.
Result<std::vector<KlemsRing>> parse_rings(const pugi::xml_node& basis) {
  std::vector<KlemsRing> rings;
  for (const pugi::xml_node& block : basis.children("AngleBasisBlock")) {
    if (rings.size() == kMostRings) return error_at(block, fmt::format("more than {} rings", kMostRings));
    const pugi::xml_node bounds = block.child("ThetaBounds");
    const std::optional<double> low = parse_number(child_text(bounds, "LowerTheta"));
    const std::optional<double> high = parse_number(child_text(bounds, "UpperTheta"));
    const std::optional<std::uint64_t> count = parse_count(child_text(block, "nPhis"));
    if (!low || !high) return error_at(block, "a ring of an AngleBasis without ThetaBounds");
    if (!count || *count == 0 || *count > kMostPhis) {
      return error_at(
          block, fmt::format("nPhis of a ring is '{}', not 1 to {}", shown(child_text(block, "nPhis")), kMostPhis));
    }
    const double expected = rings.empty() ? 0 : rings.back().upper_deg;
    if (std::abs(*low - expected) > kBoundTolerance || *high <= expected) {
      return error_at(block, fmt::format("a ring spans theta {:g} to {:g}, where it should go on from {:g}", *low,
                                         *high, expected));
    }
    rings.push_back({expected, *high, static_cast<std::uint32_t>(*count)});
  }
  if (rings.empty()) return rings;
  if (std::abs(rings.back().upper_deg - 90) > kBoundTolerance) {
    return error_at(basis,
                    fmt::format("the rings of an AngleBasis end at {:g}, not at 90 degrees", rings.back().upper_deg));
  }
  rings.back().upper_deg = 90;
  return rings;
}

/// One block of a file, as it names itself.
struct Block {
  pugi::xml_node node;
  std::string band;
  std::string direction;
};

std::string list_of(const std::vector<Block>& blocks) {
  std::string list;
  for (std::size_t k = 0; k < blocks.size() && k < 12; ++k) {
    list += fmt::format("{}{} {}", k == 0 ? "" : ", ", shown(blocks[k].band), shown(blocks[k].direction));
  }
  return blocks.empty() ? "nothing" : blocks.size() > 12 ? list + " and more" : list;
}

class Parser {
 public:
  Parser(const pugi::xml_node& layer, const KlemsChoice& choice) : layer_(layer), choice_(choice) {}

  Result<KlemsMatrix> run() {
    const pugi::xml_node definition = layer_.child("DataDefinition");
    const std::string order(child_text(definition, "IncidentDataStructure"));
    if (lower(order).starts_with("tensortree")) {
      return unsupported(
          fmt::format("a tensor tree ({}), not a matrix over Klems patches; only the latter are read", shown(order)));
    }
    rows_are_incident_ = lower(order) == "rows";
    if (!rows_are_incident_ && lower(order) != "columns") {
      return error_at(layer_, fmt::format("IncidentDataStructure is '{}', must be Columns or Rows", shown(order)));
    }
    if (Status bases = parse_bases(definition); !bases) return bases.error();
    const Result<Block> block = find_block();
    if (!block) return block.error();
    KlemsMatrix matrix;
    matrix.material = shown(child_text(layer_.child("Material"), "Name"));
    if (Status parsed = parse_block(*block, matrix); !parsed) return parsed.error();
    return matrix;
  }

 private:
  Status parse_bases(const pugi::xml_node& definition) {
    for (const pugi::xml_node& basis : definition.children("AngleBasis")) {
      Result<std::vector<KlemsRing>> rings = parse_rings(basis);
      if (!rings) return rings.error();
      const std::string name = lower(child_text(basis, "AngleBasisName"));
      const auto [known, added] = bases_.try_emplace(name, *rings);
      if (!added && known->second != *rings) return error_at(basis, "two AngleBasis of the same name differ");
    }
    return ok_status();
  }

  [[nodiscard]] Result<Block> find_block() const {
    const std::string band(name_of(kKlemsBandNames, choice_.band));
    const std::string direction = fmt::format("{} {}", choice_.transmission ? "transmission" : "reflection",
                                              name_of(kKlemsSideNames, choice_.side));
    std::vector<Block> all;
    std::optional<Block> found;
    bool transmits = false;
    for (const pugi::xml_node& wavelength : layer_.children("WavelengthData")) {
      const std::string name(child_text(wavelength, "Wavelength"));
      for (const pugi::xml_node& node : wavelength.children("WavelengthDataBlock")) {
        all.push_back({node, name, std::string(child_text(node, "WavelengthDataDirection"))});
        transmits = transmits || lower(all.back().direction).starts_with("transmission");
        if (lower(name) != band || lower(all.back().direction) != direction) continue;
        if (found) return error_at(node, fmt::format("two blocks of {} {}", band, direction));
        found = all.back();
      }
    }
    if (found) return *found;
    std::string message = fmt::format("no {} {} in the file, which holds {}", band, direction, list_of(all));
    if (!choice_.transmission && transmits) message += "; --klems-transmission reads a transmission";
    return unsupported(std::move(message));
  }

  Status parse_block(const Block& block, KlemsMatrix& matrix) {
    const std::string type = lower(child_text(block.node, "ScatteringDataType"));
    if (!type.empty() && type != "btdf" && type != "brdf" && type != "bsdf") {
      return unsupported(
          fmt::format("ScatteringDataType is '{}'; values per steradian (BTDF, BRDF) are read only", shown(type)));
    }
    const pugi::xml_node node = block.node.child("ScatteringData");
    Result<std::vector<double>> numbers = parse_numbers(node);
    if (!numbers) return numbers.error();
    const Result<KlemsBasis> rows = basis_of(block.node, "RowAngleBasis", numbers->size());
    if (!rows) return rows.error();
    const Result<KlemsBasis> columns = basis_of(block.node, "ColumnAngleBasis", numbers->size());
    if (!columns) return columns.error();
    const std::size_t row_count = rows->patch_count();
    const std::size_t column_count = columns->patch_count();
    if (numbers->size() != row_count * column_count) {
      return error_at(node, fmt::format("{} numbers in ScatteringData of {} {}, where {} x {} = {} are needed",
                                        numbers->size(), shown(block.band), shown(block.direction), row_count,
                                        column_count, row_count * column_count));
    }
    matrix.incident = rows_are_incident_ ? *rows : *columns;
    matrix.outgoing = rows_are_incident_ ? *columns : *rows;
    if (rows_are_incident_) {
      matrix.values = *std::move(numbers);
      return ok_status();
    }
    matrix.values.resize(numbers->size());
    for (std::size_t row = 0; row < row_count; ++row) {
      for (std::size_t column = 0; column < column_count; ++column) {
        matrix.values[column * row_count + row] = (*numbers)[row * column_count + column];
      }
    }
    return ok_status();
  }

  [[nodiscard]] Result<KlemsBasis> basis_of(const pugi::xml_node& block, const char* element,
                                            std::size_t number_count) const {
    const std::string name(child_text(block, element));
    if (name.empty()) return error_at(block, fmt::format("{} is missing from a block", element));
    if (const auto defined = bases_.find(lower(name)); defined != bases_.end() && !defined->second.empty()) {
      return KlemsBasis(defined->second);
    }
    std::vector<KlemsRing> rings =
        known_klems_rings(name, static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(number_count)))));
    if (rings.empty()) {
      return error_at(block, fmt::format("{} is '{}', which the file does not define and nobody knows ({} numbers)",
                                         element, shown(name), number_count));
    }
    return KlemsBasis(std::move(rings));
  }

  // Parted by blanks, line ends and commas; one comma at most between two.
  static Result<std::vector<double>> parse_numbers(const pugi::xml_node& node) {
    const std::string_view all = node.child_value();
    std::string_view rest = all;
    std::vector<double> numbers;
    while (true) {
      const std::size_t start = rest.find_first_not_of(kSeparators);
      const std::string_view between = rest.substr(0, std::min(start, rest.size()));
      if (std::count(between.begin(), between.end(), ',') > (numbers.empty() ? 0 : 1)) {
        return error_at(node, fmt::format("a number of ScatteringData is missing behind {}", numbers.size()));
      }
      if (start == std::string_view::npos) return numbers;
      rest.remove_prefix(start);
      const std::string_view word = rest.substr(0, rest.find_first_of(kSeparators));
      const std::optional<double> value = parse_number(word);
      if (!value || std::abs(*value) > 1e37) {
        return error_at(node, fmt::format("number {} of ScatteringData is '{}', which is no finite number up to 1e37",
                                          numbers.size() + 1, shown(word)));
      }
      numbers.push_back(*value);
      rest.remove_prefix(word.size());
    }
  }

  pugi::xml_node layer_;
  KlemsChoice choice_;
  bool rows_are_incident_ = false;
  std::map<std::string, std::vector<KlemsRing>> bases_;
};

/// The one layer that has values.
Result<pugi::xml_node> layer_of(const pugi::xml_document& document) {
  const pugi::xml_node root = document.child("WindowElement");
  if (!root) return invalid_file("no root element WindowElement");
  pugi::xml_node found;
  for (const pugi::xml_node& layer : root.child("Optical").children("Layer")) {
    if (!layer.child("WavelengthData")) continue;
    if (found) return unsupported("values of more than one Layer; files with one are read");
    found = layer;
  }
  if (!found) return error_at(root, "no Layer with WavelengthData within Optical");
  return found;
}

}  // namespace

Result<KlemsMatrix> parse_klems(std::span<const std::byte> bytes, const KlemsChoice& choice) {
  if (bytes.size() > kKlemsLargestFile) {
    return unsupported(fmt::format("XML of {} bytes; at most {} are read", bytes.size(), kKlemsLargestFile));
  }
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(bytes.data(), bytes.size());
  if (!parsed) {
    return invalid_file(fmt::format("not whole XML: {}", lower(parsed.description())),
                        static_cast<std::uint64_t>(std::max<std::ptrdiff_t>(parsed.offset, 0)));
  }
  const Result<pugi::xml_node> layer = layer_of(document);
  if (!layer) return layer.error();
  return Parser(*layer, choice).run();
}

namespace {

/// Where the declaration of a document's type ends that `text` begins with: at the first '>' that stands neither in
/// quotes nor in brackets.
std::size_t end_of_doctype(std::string_view text) {
  char quote = 0;
  bool inside = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '[' || c == ']') {
      inside = c == '[';
    } else if (c == '>' && !inside) {
      return at + 1;
    }
  }
  return std::string_view::npos;
}

/// Behind what stands at the beginning of `text` before the root element: a declaration, a comment, or a document's
/// type, of which pugixml reads nothing. 0 where none of these stands there, npos where its end is missing.
std::size_t end_of_prologue(std::string_view text) {
  if (text.starts_with("<!DOCTYPE")) return end_of_doctype(text);
  const std::string_view end = text.starts_with("<?") ? "?>" : text.starts_with("<!--") ? "-->" : "";
  if (end.empty()) return 0;
  const std::size_t closed = text.find(end);
  return closed == std::string_view::npos ? closed : closed + end.size();
}

}  // namespace

bool recognises_klems(std::span<const std::byte> head) {
  std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  while (true) {
    text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
    const std::size_t end = end_of_prologue(text);
    if (end == std::string_view::npos) return false;
    if (end == 0) break;
    text.remove_prefix(end);
  }
  constexpr std::string_view kRoot = "<WindowElement";
  if (!text.starts_with(kRoot)) return false;
  text.remove_prefix(kRoot.size());
  return !text.empty() && (text.front() == '>' || kBlank.find(text.front()) != std::string_view::npos);
}

}  // namespace sbrdf::internal
