#include "tools/conversion/report_file.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <vector>

#include "converters/files/by_name.h"
#include "formats/os/files.h"
#include "tools/console/output.h"
#include "tools/io/outputs.h"

namespace sbrdf::internal {
namespace {

/// Whether something lies there that is neither empty nor an earlier report, which begins with what became of a file.
Result<bool> holds_something_else(const std::string& path) {
  if (!exists(path)) return false;
  const Result<std::unique_ptr<ByteSource>> file = map_file(path);
  if (!file) return file.error();
  constexpr std::size_t kBeginning = 64;
  const Result<std::vector<std::byte>> head = read_start(**file, kBeginning);
  if (!head) return head.error();
  const std::string_view text(reinterpret_cast<const char*>(head->data()), head->size());
  const std::string_view first = text.substr(std::min(text.find_first_not_of("[{ \n"), text.size()));
  return !text.empty() && !first.starts_with("\"result\":") && !first.starts_with(']');
}

}  // namespace

Status check_report_name(const std::string& path) {
  if (lower_extension(path) == ".json") return ok_status();
  return usage_error("the name of a report must end with .json");
}

Status check_report(const std::string& path, const std::vector<std::string>& read,
                    const std::vector<std::string>& written) {
  if (Status named = check_report_name(path); !named) return named;
  if (is_among(path, read)) return usage_error("is an input, which a report would replace; choose another name");
  if (is_among(path, written)) {
    return usage_error(
        "is a file that is written, or belongs to one, which the report would replace; choose another "
        "name");
  }
  const Result<bool> other = holds_something_else(path);
  if (!other) return other.error();
  if (!*other) return ok_status();
  return usage_error(
      "there is a file of another kind of that name, which a report would replace; choose another name or remove it");
}

Status write_report_file(const std::string& path, const nlohmann::ordered_json& report) {
  const std::string text = json_text(report);
  return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())), AfterSignal::kComplete);
}

}  // namespace sbrdf::internal
