#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "converters/files/atlas/paper/make_paper.h"
#include "converters/files/atlas/paper/paper_manifest.h"
#include "formats/sbrdf/container.h"
#include "tools/commands/atlas/atlas_command.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMegabyte = 1U << 20U;  // as in the paper's Table 5

struct WrittenPaper {
  PaperFiles files;
  std::vector<std::string> paths;  ///< the manifest last
  std::uint64_t manifest_bytes = 0;

  [[nodiscard]] std::uint64_t file_bytes() const {
    std::uint64_t sum = 0;
    for (const std::uint64_t bytes : files.bytes) sum += bytes;
    return sum;
  }
};

Result<WrittenPaper> write_paper(const MadePaper& made, const AtlasCommand& command, const SourceTraits& traits) {
  Result<std::vector<std::string>> paths = paper_paths(command);
  if (!paths) return paths.error();
  WrittenPaper written;
  written.paths = *std::move(paths);
  written.files.texel = made.packed.front().format;
  std::array<std::vector<std::byte>, kPaperTextureCount> packed;
  std::vector<std::pair<std::string, std::span<const std::byte>>> contents;
  for (std::size_t k = 0; k < kPaperTextureCount; ++k) {
    Result<std::vector<std::byte>> bytes = pack_texture(made.packed[k], command.options);
    if (!bytes) return bytes.error();
    packed[k] = *std::move(bytes);
    written.files.names[k] = file_name_of(written.paths[k]);
    written.files.bytes[k] = packed[k].size();
    written.files.texels_crc32[k] = checksum(std::as_bytes(std::span(made.packed[k].bytes)));
    contents.emplace_back(written.paths[k], packed[k]);
  }
  const std::string manifest =
      emit_paper_manifest(made.textures, written.files, facts_json(made.errors, made.of_source, command, traits));
  written.manifest_bytes = manifest.size();
  contents.emplace_back(written.paths.back(), std::as_bytes(std::span(manifest)));
  if (Status put = write_together(contents); !put) return put.error();
  return written;
}

Result<MadePaper> make_with_bar(const BrdfSource& source, const AtlasCommand& command) {
  ProgressBar bar("atlas " + one_line(command.in, 40));
  StepwiseProgress steps(bar.progress());
  const Result<DecodedSliced> sliced = slices_of(source, command, steps.step(source.sliced() == nullptr ? 0.9 : 0));
  if (!sliced) return sliced.error();
  Result<MadePaper> made = make_paper(*sliced, source, command.options);
  if (made && !steps.finish()) return interrupted_error();
  return made;
}

void print_paper(const MadePaper& made, const WrittenPaper& written, double seconds) {
  Table table;
  for (std::size_t k = 0; k < kPaperTextureCount; ++k) {
    const PaperTexture& texture = made.textures.textures[k];
    table.add({k == 0 ? "wrote" : "",
               fmt::format("{}: {} x {} texels {}, {} bytes", written.paths[k], texture.width, texture.height,
                           name_of(kTexelFormatNames, written.files.texel), format_count(written.files.bytes[k]))});
  }
  table.add(
      {"", fmt::format("{}: the manifest, {} bytes", written.paths.back(), format_count(written.manifest_bytes))});
  table.add(
      {"texels", fmt::format("{}, {} bytes, {:.1f} MB (2^20 bytes)", format_count(made.textures.texel_count()),
                             format_count(made.texel_bytes()), static_cast<double>(made.texel_bytes()) / kMegabyte)});
  table.add({"to slices", fmt::format("{} on {} directions, dense around highlights", errors_text(made.errors),
                                      format_count(made.errors.directions))});
  table.add({"to source", errors_text(made.of_source) + " on the same"});
  table.add({"took", format_number(seconds) + " s"});
  table.print();
}

Json report(const MadePaper& made, const WrittenPaper& written, const AtlasCommand& command, double seconds) {
  Json textures;
  for (std::size_t k = 0; k < kPaperTextureCount; ++k) {
    const PaperTexture& texture = made.textures.textures[k];
    textures[std::string(kPaperTextureNames[k].name)] = {
        {"width", texture.width}, {"height", texture.height}, {"file_bytes", written.files.bytes[k]}};
  }
  return {{"in", command.in},
          {"layout", kPaperLayout},
          {"texel", name_of(kTexelFormatNames, written.files.texel)},
          {"container", name_of(kAtlasContainerNames, command.options.container)},
          {"textures", textures},
          {"texels", made.textures.texel_count()},
          {"bytes", made.texel_bytes()},
          {"file_bytes", written.file_bytes()},
          {"files", written.paths},
          {"mre_percent", made.of_source.mre_percent},
          {"rel_l1_percent", made.of_source.rel_l1_percent},
          {"errors", {{"to_slices", errors_json(made.errors)}, {"to_source", errors_json(made.of_source)}}},
          {"seconds", seconds}};
}

}  // namespace

Result<std::vector<std::string>> paper_paths(const AtlasCommand& command) {
  if (Status allowed = check_paper_options(command.options); !allowed) return allowed.error();
  const std::string extension(name_of(kAtlasContainerNames, command.options.container));
  std::vector<std::string> paths;
  for (const auto& texture : kPaperTextureNames) {
    paths.push_back(path_of(command, fmt::format("_{}.{}", texture.name, extension)));
  }
  paths.push_back(path_of(command, ".json"));
  return paths;
}

int run_paper(const AtlasCommand& command, const BrdfSource& source) {
  const Stopwatch watch;
  if (command.placement && source.sliced() != nullptr) {
    return report_error(command.in, usage_error("--placement: it has slices already, which are taken as they are"));
  }
  const Result<MadePaper> made = make_with_bar(source, command);
  if (!made) return report_error(command.in, made.error());
  const Result<WrittenPaper> written = write_paper(*made, command, source.traits());
  if (!written) return report_error("", written.error());
  if (command.json) {
    print_json(report(*made, *written, command, watch.seconds()));
  } else {
    print_paper(*made, *written, watch.seconds());
  }
  return 0;
}

}  // namespace sbrdf::internal
