#include "tools/conversion/report_file.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/files/format_table.h"
#include "formats/os/files.h"
#include "tools/console/output.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

bool is_among(const std::string& path, const std::vector<std::string>& others) {
  return std::any_of(others.begin(), others.end(),
                     [&](const std::string& other) { return is_same_place(path, other); });
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

Status check_report(const std::string& path, const std::vector<std::string>& read,
                    const std::vector<std::string>& written) {
  if (lower_extension(path) != ".json") return usage_error("the name of a report must end with .json");
  if (is_among(path, read)) return usage_error("is an input, which a report would replace; choose another name");
  if (is_among(path, written)) {
    return usage_error(
        "is a file that is written, or belongs to one, which the report would replace; choose another "
        "name");
  }
  if (!is_brdf(path)) return ok_status();
  return usage_error("there is a BRDF of that name, which a report would replace; choose another name or remove it");
}

Status write_report_file(const std::string& path, const nlohmann::ordered_json& report) {
  const std::string text = json_text(report);
  return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())), AfterSignal::kComplete);
}

}  // namespace sbrdf::internal
