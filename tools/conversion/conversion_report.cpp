#include "tools/conversion/conversion_report.h"

#include <cmath>

#include "converters/files/format_table.h"
#include "converters/source/findings_json.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

bool is_flag(const std::string& name) {
  const Format* format = find_format_with(name);
  return format != nullptr && find_option(format->options, name, OptionUse::kBoth)->kind == OptionKind::kFlag;
}

Json options_json(const Options& given) {
  Json json = Json::object();
  for (const auto& [name, text] : given.all()) json[name] = is_flag(name) ? Json(true) : Json(text);
  return json;
}

Json in_json(const ConversionOrder& order, const Conversion& done) {
  const SourceTraits& traits = done.in.source->traits();
  Json json = {{"path", order.in}, {"format", traits.format}, {"description", traits.description}};
  json["bytes"] = done.in.bytes ? Json(*done.in.bytes) : Json();
  json["sha256"] = done.sha256.empty() ? Json() : Json(done.sha256);
  json["findings"] = findings_json(done.report.findings);
  return json;
}

Json out_json(const ConversionOrder& order, const Conversion& done) {
  Json json = {{"path", order.out}, {"format", order.format->name}, {"bytes", done.report.bytes}};
  for (std::size_t k = 1; k < done.written.size(); ++k) {
    json["with"].push_back({{"path", done.written[k].path}, {"bytes", done.written[k].bytes}});
  }
  return json;
}

}  // namespace

Json report_of(const ConversionOrder& order, const Conversion& done) {
  Json json = {{"result", "converted"}, {"version", SBRDF_VERSION}};
  json["in"] = in_json(order, done);
  json["out"] = out_json(order, done);
  json["options"] = options_json(order.given);
  json["remarks"] = remarks_json(done.report.remarks);
  json["seconds"] = done.seconds;
  return json;
}

Json report_of(const std::string& in, const Failure& failure) {
  Json error = {{"code", static_cast<int>(failure.error.code)}, {"message", failure.error.message}};
  if (failure.subject != in) error["file"] = failure.subject;
  if (failure.error.offset) error["offset"] = *failure.error.offset;
  return {{"result", "failed"}, {"in", {{"path", in}}}, {"error", error}};
}

Json report_of_skipped(const std::string& in, const std::string& reason) {
  return {{"result", "skipped"}, {"in", {{"path", in}}}, {"reason", reason}};
}

std::string main_figure(const Json& report) {
  for (const Json& remark : report.value("remarks", Json::array())) {
    const std::string key = remark.value("key", "");
    if (key == "copied") return "copied";
    if (!key.ends_with("mre_percent")) continue;
    // What is not finite is null where the report was read back.
    const bool known = remark["value"].is_number() && std::isfinite(remark["value"].get<double>());
    return known ? "MRE " + format_number(remark["value"].get<double>()) + " %" : "";
  }
  return "";
}

void print_report(const ConversionOrder& order, const Conversion& done) {
  const SourceTraits& traits = done.in.source->traits();
  Table table;
  table.add({"read", order.in + ": " + traits.description +
                         (done.in.bytes ? ", " + format_count(*done.in.bytes) + " bytes" : "")});
  for (const Finding& finding : done.report.findings) {
    table.add({"found", format_count(finding.count) + " of " + format_count(finding.total) + " " + finding.what});
  }
  table.add({"wrote", order.out + ": " + std::string(order.format->description) + ", " +
                          format_count(done.report.bytes) + " bytes"});
  for (const Remark& remark : done.report.remarks) table.add({"", remark.text});
  table.add({"took", format_number(done.seconds) + " s"});
  table.print();
}

}  // namespace sbrdf::internal
