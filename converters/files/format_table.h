#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "converters/files/format.h"

namespace sbrdf::internal {

// The one place that knows all formats. Converting a file, wherever its bytes are:
//
//   const auto source = open_source(bytes);                          // recognised by content
//   if (!source) return source.error();
//   const auto format = find_writer(".sbrdf");                       // a row that can be written
//   if (!format) return format.error();
//   Report report;                                                   // remarks, findings, bytes
//   return save_source(**format, **source, sink, Options().set("samples", "4096"), report);
//
// `bytes` is any ByteSource, such as OwnedMemorySource; `sink` any ByteSink, such as MemorySink or AtomicFile.

/// All rows. Nothing depends on their order but lists for people.
[[nodiscard]] std::span<const Format> formats();

/// The row that a file belongs to, by the beginning of its content and never by its extension. An error, worded for
/// people, where it is empty, text, or of a kind that is known to be no BRDF: a web page, an archive and the like.
[[nodiscard]] Result<const Format*> recognise(const ByteSource& bytes);

/// Opens a file of any readable format. The source keeps `bytes` for as long as it needs them. kUsage for an option
/// that the file's format does not have for reading, or a value that it may not have; otherwise as the format says.
[[nodiscard]] Result<std::unique_ptr<BrdfSource>> open_source(std::shared_ptr<const ByteSource> bytes,
                                                              const Options& options = {});

/// The writable format of an extension such as ".sbrdf", letter case ignored; kUsage listing the writable ones
/// otherwise.
[[nodiscard]] Result<const Format*> find_writer(std::string_view extension);

/// The first format that has an option, for reading or writing; nullptr where none has. All that have it mean the same.
[[nodiscard]] const Format* find_format_with(std::string_view option);

/// Whether files of a format are read with an option.
[[nodiscard]] bool reads_with(const Format& format, std::string_view option);

/// Whether a format can be written with these options; kUsage naming those that it does not have, that have a value
/// that may not be, or that contradict each other. For asking before long work: save_source asks again.
[[nodiscard]] Status check_save(const Format& format, const Options& options);

/// Writes a source as a file of a writable format, and everything there is to report. An error leaves the sink in any
/// state: write to one that can be dropped.
[[nodiscard]] Status save_source(const Format& format, const BrdfSource& source, ByteSink& sink, const Options& options,
                                 Report& report, const Progress& progress = {});

}  // namespace sbrdf::internal
