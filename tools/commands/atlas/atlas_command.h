#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "codec/file/encoder.h"
#include "converters/files/atlas/make_atlas.h"
#include "converters/files/options.h"
#include "converters/scene/scene.h"
#include "converters/slicing/options.h"
#include "converters/source/brdf_source.h"
#include "converters/source/progress.h"
#include "formats/core/named.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

enum class AtlasLayoutName : std::uint8_t {
  kEngine,  ///< one texture and its shader
  kPaper,   ///< the paper's four textures
};
inline constexpr std::array kAtlasLayoutNames = {Named{"engine", AtlasLayoutName::kEngine},
                                                 Named{"paper", AtlasLayoutName::kPaper}};

struct AtlasCommand {
  std::string in;
  std::string prefix;
  AtlasLayoutName layout = AtlasLayoutName::kEngine;
  AtlasOptions options;
  std::optional<std::uint64_t> samples;  ///< open: kDefaultSampleCount, with the paper's layout 8,911
  std::optional<Placement> placement;    ///< with the paper's layout; open: 14/36
  std::optional<double> theta_max_deg;   ///< of directions that are needed; one of these three at most
  std::string directions;                ///< file of those that are needed
  std::string scene;                     ///< file of what needs them
  bool json = false;
  Options given;  ///< of reading
};

/// A path in front of ending, such as "_axial.exr".
[[nodiscard]] std::string path_of(const AtlasCommand& command, const std::string& ending);
/// Its name without folders.
[[nodiscard]] std::string file_name_of(const std::string& path);

/// Whether all of `paths`, the manifest last, may be written. What an atlas of this name consists of, with the files
/// `former` beside its manifest, is replaced, nothing else that is a BRDF. kUsage names the file.
[[nodiscard]] Status check_paths(const AtlasCommand& command, const std::vector<std::string>& paths,
                                 const std::vector<std::string>& former);

/// The names of the textures, and the shader, of the atlas that has this manifest already; none where it is none.
[[nodiscard]] std::vector<std::string> files_of_former(const std::string& manifest);
/// Of these the ones that bear the prefix and are not among `paths`, which replaced the others: they are removed, as no
/// manifest names them any more. The paths of those that were there.
std::vector<std::string> remove_left_over(const AtlasCommand& command, const std::vector<std::string>& former,
                                          const std::vector<std::string>& paths);

/// The slices that a source has, or that it is sampled into.
[[nodiscard]] Result<DecodedSliced> slices_of(const BrdfSource& source, const AtlasCommand& command,
                                              const Progress& progress);

/// kUsage where more than one says what is needed, or the layout leaves nothing out.
[[nodiscard]] Status check_needed(const AtlasCommand& command);
/// What an atlas is needed for, as files and options say; nothing: everything.
struct Needed {
  std::optional<double> theta_max_deg;
  std::vector<DirectionPair> pairs;
  std::optional<Scene> scene;
};
/// Errors are those of the file that the command names.
[[nodiscard]] Result<Needed> read_needed(const AtlasCommand& command);
/// The cells of an atlas of slices on this lattice that are needed.
[[nodiscard]] Result<AtlasCells> needed_cells(const Needed& needed, const Lattice& lattice, const Progress& progress);

/// All files, or none: each is complete before the first gets its name. Errors begin with the path.
[[nodiscard]] Status write_together(const std::vector<std::pair<std::string, std::span<const std::byte>>>& contents);

[[nodiscard]] nlohmann::ordered_json errors_json(const AtlasErrors& errors);
/// The members of a manifest of any layout that say what was made of what, and how near.
[[nodiscard]] nlohmann::ordered_json facts_json(const AtlasErrors& to_slices, const AtlasErrors& to_source,
                                                const AtlasCommand& command, const SourceTraits& traits);
/// "MRE 1.2 %, relative L1 0.8 %".
[[nodiscard]] std::string errors_text(const AtlasErrors& errors);

/// Writes and reports the paper's layout; the exit code.
[[nodiscard]] int run_paper(const AtlasCommand& command, const BrdfSource& source);
/// kUsage where options do not fit it. All files that it writes, the manifest last.
[[nodiscard]] Result<std::vector<std::string>> paper_paths(const AtlasCommand& command);

}  // namespace sbrdf::internal
