#include "tools/conversion/report_file.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "formats/os/files.h"
#include "tools/console/output.h"

namespace sbrdf::internal {
namespace {

bool is_input(const std::string& path, const std::string& input) {
  const std::optional<std::string> file = file_of(input);
  std::error_code failed;
  return file && std::filesystem::equivalent(path, *file, failed) && !failed;
}

// An earlier report begins like a damaged file of parameters, so only a row that is sure counts.
bool is_brdf(const std::string& path) {
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file || (*file)->size() == 0) return false;
  const Result<std::vector<std::byte>> head = read_start(**file, kHeadSize);
  return head && std::any_of(formats().begin(), formats().end(), [&](const Format& format) {
           return format.recognise(*head, (*file)->size()) == Match::kWhole;
         });
}

}  // namespace

Status check_report(const std::string& path, std::span<const std::string> inputs) {
  if (lower_extension(path) != ".json") return usage_error("the name of a report must end with .json");
  if (std::any_of(inputs.begin(), inputs.end(), [&](const std::string& input) { return is_input(path, input); })) {
    return usage_error("is an input, which a report would replace; choose another name");
  }
  if (!is_brdf(path)) return ok_status();
  return usage_error("there is a BRDF of that name, which a report would replace; choose another name or remove it");
}

Status write_report_file(const std::string& path, const nlohmann::ordered_json& report) {
  const std::string text = json_text(report);
  return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())), AfterSignal::kComplete);
}

}  // namespace sbrdf::internal
