#include "converters/files/format.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "converters/source/findings_json.h"

namespace sbrdf::internal {
namespace {

constexpr std::uint64_t kPiece = std::uint64_t{1} << 22U;

}  // namespace

nlohmann::ordered_json remarks_json(std::span<const Remark> remarks) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Remark& remark : remarks) {
    json.push_back({{"key", remark.key}, {"value", remark.value}, {"text", remark.text}});
  }
  return json;
}

std::string report_json(const Report& report) {
  nlohmann::ordered_json json;
  json["findings"] = findings_json(report.findings);
  json["remarks"] = remarks_json(report.remarks);
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string percent_text(double value) { return std::isinf(value) ? "infinite" : fmt::format("{:.3g} %", value); }

void remark_count(Report& report, const char* key, std::uint64_t count, const std::string& what) {
  if (count > 0) report.remarks.push_back({key, static_cast<double>(count), std::to_string(count) + " " + what});
}

void remark_reciprocity(Report& report, double difference_percent) {
  report.remarks.push_back(
      {"reciprocity_residual_percent", difference_percent,
       "reciprocity residual " + percent_text(difference_percent) + ": f(i,v) and f(v,i) were replaced by their mean"});
}

Status copy_bytes(const ByteSource& source, ByteSink& sink, const Progress& progress) {
  ProgressCounter counter(progress, source.size());
  std::vector<std::byte> read;
  for (std::uint64_t offset = 0; offset < source.size(); offset += kPiece) {
    const auto size = static_cast<std::size_t>(std::min(kPiece, source.size() - offset));
    std::span<const std::byte> piece;
    if (const auto view = source.view()) {
      piece = view->subspan(static_cast<std::size_t>(offset), size);
    } else {
      read.resize(size);
      if (Status status = source.read(offset, read); !status) return status;
      piece = read;
    }
    if (Status status = sink.write(offset, piece); !status) return status;
    if (!counter.advance(size)) return interrupted_error();
  }
  return ok_status();
}

}  // namespace sbrdf::internal
