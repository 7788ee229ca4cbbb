#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "codec/atlas/bake.h"
#include "codec/atlas/part/reached_cells.h"
#include "converters/scene/scene.h"
#include "converters/scene/scene_reach.h"
#include "formats/core/text_lines.h"
#include "formats/os/files.h"
#include "tools/commands/atlas/atlas_command.h"
#include "tools/io/direction_rows.h"

namespace sbrdf::internal {
namespace {

Error at_line(const Error& error, std::uint64_t line) {
  return {error.code, fmt::format("line {}: {}", line, error.message), {}};
}

Result<std::vector<DirectionPair>> parse_pairs(std::string_view text) {
  LineWalker lines(text);
  const std::optional<TextLine> first = lines.next();
  if (!first) return invalid_file("empty: a header theta_i,phi_i,theta_v,phi_v is needed");
  const Result<DirectionHeader> header = parse_direction_header(first->text);
  if (!header) return at_line(header.error(), first->number);
  std::vector<DirectionPair> pairs;
  while (const std::optional<TextLine> line = lines.next()) {
    const Result<DirectionRow> row = parse_direction_row(line->text, header->names.size());
    if (!row) return at_line(row.error(), line->number);
    if (!row->below_horizon) pairs.push_back(row->pair);
  }
  if (pairs.empty()) return invalid_file("no pair of directions above the horizon");
  return pairs;
}

}  // namespace

Status check_needed(const AtlasCommand& command) {
  const int given =
      (command.theta_max_deg ? 1 : 0) + (command.directions.empty() ? 0 : 1) + (command.scene.empty() ? 0 : 1);
  if (given > 1) return usage_error("--theta-max, --directions and --used-by exclude each other");
  if (given > 0 && command.layout == AtlasLayoutName::kPaper) {
    return usage_error("--theta-max, --directions and --used-by are for --layout engine");
  }
  return ok_status();
}

Result<Needed> read_needed(const AtlasCommand& command) {
  Needed needed;
  needed.theta_max_deg = command.theta_max_deg;
  if (command.directions.empty() && command.scene.empty()) return needed;
  const Result<std::shared_ptr<const ByteSource>> file =
      open_file(command.scene.empty() ? command.directions : command.scene);
  if (!file) return file.error();
  if (!command.scene.empty()) {
    Result<Scene> scene = read_scene(**file);
    if (!scene) return scene.error();
    needed.scene = *std::move(scene);
    return needed;
  }
  const Result<std::vector<std::byte>> bytes = read_range(**file, 0, (*file)->size());
  if (!bytes) return bytes.error();
  Result<std::vector<DirectionPair>> pairs = parse_pairs({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  if (!pairs) return pairs.error();
  needed.pairs = *std::move(pairs);
  return needed;
}

Result<AtlasCells> needed_cells(const Needed& needed, const Lattice& lattice, const Progress& progress) {
  const AtlasLayout axes = atlas_axes(lattice);
  if (needed.scene) return reach_of_scene(*needed.scene, axes, progress);
  if (!needed.theta_max_deg && needed.pairs.empty()) return AtlasCells();
  ReachedCells reach(axes);
  if (needed.theta_max_deg) reach.add_up_to(*needed.theta_max_deg);
  for (const DirectionPair& pair : needed.pairs) reach.add(pair, 0);
  return reach.cells();
}

}  // namespace sbrdf::internal
