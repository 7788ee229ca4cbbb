#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "formats/core/result.h"

namespace sbrdf::internal {

// What there is to convert in a folder, by names alone as far as they tell. specs/convert.md gives the rules.

/// One of several equal parts of a folder's files, for as many runs at once: 1/3, 2/3, 3/3.
struct Shard {
  std::uint64_t number = 1;  ///< from 1 to count
  std::uint64_t count = 1;
};

/// Of "I/N", where N is a million at most. kUsage without the option's name.
[[nodiscard]] Result<Shard> parse_shard(std::string_view text);

/// What the name of a sidecar ends with, behind the whole name of the file that it belongs to.
inline constexpr std::string_view kSidecarSuffix = ".json";

struct FolderFile {
  std::string name;     ///< relative to the folder: "a.binary", "cloth/a.binary"
  std::string out;      ///< relative to the folder of the outputs
  std::string sidecar;  ///< the file that says how `name` is to be read, which a reader looks for itself; empty: none
};

struct SkippedFile {
  std::string name;  ///< as FolderFile::name
  std::string reason;
};

struct FolderContent {
  std::vector<FolderFile> files;     ///< rising by name
  std::vector<SkippedFile> skipped;  ///< likewise
};

struct FolderRules {
  std::string extension;             ///< of the outputs, with its dot
  bool recursive = false;            ///< subfolders, too
  std::vector<std::string> ignored;  ///< paths of what this run writes itself
};

/// The files of a folder. Skipped, each with its reason: names that begin with a dot; subfolders, unless recursive;
/// pipes and devices; sidecars, "x.npy.json" beside "x.npy"; and documents, such as README, LICENSE, .md, .png, as long
/// as their content is of no format. Everything else is to be converted, even where that must fail.
///
/// An output has the name of its file with another extension: a.binary becomes a.sbrdf. Where several would have the
/// same, each of these keeps its whole name: a.binary.sbrdf and a.bsdf.sbrdf.
///
/// kIo where the folder, or one in it, cannot be read; kUsage where it holds nothing to convert.
[[nodiscard]] Result<FolderContent> list_folder(const std::string& folder, const FolderRules& rules);

}  // namespace sbrdf::internal
