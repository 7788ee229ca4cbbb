#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "converters/files/by_name.h"
#include "converters/judge/plausibility.h"
#include "converters/source/findings_json.h"
#include "formats/os/interrupt.h"
#include "tools/commands/commands.h"
#include "tools/console/format_options.h"
#include "tools/console/options.h"
#include "tools/console/progress_bar.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

using Json = nlohmann::ordered_json;

struct CheckCommand {
  std::vector<std::string> files;
  AlbedoOptions albedo;
  std::optional<double> max_albedo;
  std::optional<double> max_reciprocity;
  std::optional<double> max_negative;
  std::optional<double> max_unmeasured;
  std::optional<std::uint64_t> max_spikes;
  Options given;  ///< of reading, for those of the files that have them
  bool json = false;
};

double degrees(double radians) { return degrees_from_radians(radians); }

std::string percent(double value) { return format_number(value) + " %"; }

Json pair_json(const DirectionPair& pair) {
  return {{"theta_i_deg", degrees(pair.i.theta)},
          {"phi_i_deg", degrees(pair.i.phi)},
          {"theta_v_deg", degrees(pair.v.theta)},
          {"phi_v_deg", degrees(pair.v.phi)}};
}

Json difference_json(const SelfDifference& difference, const SourceTraits& traits) {
  Json json = {{"percent", difference.percent}};
  if (difference.worst.reference == difference.worst.test) return json;
  json["worst_at"] = pair_json(difference.worst.pair);
  json["worst_at"]["channel"] = traits.channels[difference.worst.channel];
  json["worst_at"]["there"] = difference.worst.reference;
  json["worst_at"]["back"] = difference.worst.test;
  return json;
}

Json albedo_json(const Albedo& albedo, const SourceTraits& traits) {
  std::vector<double> total;
  for (std::size_t c = 0; c < albedo.measured.size(); ++c) total.push_back(albedo.total(c));
  return {{"theta_i_deg", degrees(albedo.i.theta)},
          {"phi_i_deg", degrees(albedo.i.phi)},
          {"albedo", total},
          {"from_beyond_theta_max", albedo.beyond},
          {"error", albedo.error},
          {"accuracy_reached", albedo.reached},
          {"light_beyond_theta_max", degrees(albedo.i.theta) > traits.theta_max_deg + 1e-9},
          {"evaluations", albedo.evaluations},
          {"unmeasured_evaluations", albedo.unmeasured}};
}

Json shares_json(const CheckReport& report, const SourceTraits& traits) {
  const Shares& shares = report.shares;
  const auto share = [](double plain, double solid) { return Json{{"percent", plain}, {"solid_percent", solid}}; };
  Json json = {{"of", report.shares_of_nodes ? "nodes" : "directions"},
               {"count", shares.count},
               {"negative", share(shares.negative_percent, shares.negative_solid_percent)},
               {"unmeasured", share(shares.unmeasured_percent, shares.unmeasured_solid_percent)},
               {"out_of_gamut", share(shares.gamut_percent, shares.gamut_solid_percent)},
               {"not_finite", shares.not_finite}};
  if (shares.worst_gamut) {
    Json& worst = json["out_of_gamut"]["worst_at"] = pair_json(shares.worst_gamut->pair);
    worst["channel"] = traits.channels[shares.worst_gamut->channel];
    worst["value"] = shares.worst_gamut->reference;
    worst["largest_channel"] = shares.worst_gamut->test;
  }
  return json;
}

Json spikes_json(const CheckReport& report, const SourceTraits& traits) {
  Json json = {{"searched", report.spikes_in}};
  if (!report.spikes) return json;
  json["nodes"] = report.spikes->nodes;
  json["count"] = report.spikes->count;
  json["too_noisy_nodes"] = report.spikes->too_noisy;
  json["worst"] = Json::array();
  for (const Spike& spike : report.spikes->worst) {
    json["worst"].push_back({{"node", spike.node},
                             {"place", spike.place},
                             {"channel", traits.channels[spike.channel]},
                             {"value", spike.value},
                             {"least_around", spike.least},
                             {"largest_around", spike.largest},
                             {"factor", std::exp(spike.excess)}});
  }
  return json;
}

Json exchange_json(const PairChecks& pairs, const SourceTraits& traits) {
  Json channels = Json::array();
  for (std::size_t c = 0; c < pairs.channels.size(); ++c) {
    channels.push_back({{"name", traits.channels[c]},
                        {"asymmetry", pairs.channels[c].asymmetry},
                        {"agreement", pairs.channels[c].agreement},
                        {"with_others", pairs.channels[c].with_others}});
  }
  return {{"factor", std::exp(pairs.exchange_log)},
          {"factor_without_cos_theta_v", std::exp(pairs.exchange_log_without_cos_v)},
          {"factor_without_cos_theta_i", std::exp(pairs.exchange_log_without_cos_i)},
          {"power_of_cosines", pairs.exchange_slope},
          {"channels", channels}};
}

Json report_json(const std::string& file, const CheckReport& report, const SourceTraits& traits, double seconds) {
  Json json = {{"file", file},
               {"format", traits.format},
               {"verdict", report.verdict()},
               {"suspicious", report.suspicious_count()},
               {"theta_max_deg", traits.theta_max_deg},
               {"channels", traits.channels}};
  json["remarks"] = Json::array();
  for (const CheckRemark& remark : report.remarks) {
    json["remarks"].push_back({{"topic", remark.topic}, {"suspicious", remark.suspicious}, {"text", remark.text}});
  }
  json["highest_albedo"] = report.highest_albedo;
  json["albedos"] = Json::array();
  for (const Albedo& albedo : report.albedos) json["albedos"].push_back(albedo_json(albedo, traits));
  json["reciprocity"] = difference_json(report.reciprocity, traits);
  json["reciprocity"]["by_construction"] = traits.reciprocal;
  json["isotropy"] = difference_json(report.pairs.isotropy, traits);
  json["mirror_x"] = difference_json(report.pairs.mirror_x, traits);
  json["mirror_y"] = difference_json(report.pairs.mirror_y, traits);
  json["exchange"] = exchange_json(report.pairs, traits);
  json["shares"] = shares_json(report, traits);
  json["spikes"] = spikes_json(report, traits);
  json["grazing"] = Json::array();
  for (const GrazingGrowth& growth : report.grazing) {
    json["grazing"].push_back({{"from_deg", growth.from_deg}, {"to_deg", growth.to_deg}, {"power", growth.power}});
  }
  json["findings"] = findings_json(traits.findings);
  json["seconds"] = seconds;
  return json;
}

double largest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }

void print_albedos(const CheckReport& report, const SourceTraits& traits) {
  Table table;
  std::vector<std::string> heads = {"albedo", traits.isotropic ? "" : "phi_i"};
  const bool each = traits.channels.size() <= kMostChannelColumns;
  if (each) {
    heads.insert(heads.end(), traits.channels.begin(), traits.channels.end());
  } else {
    heads.insert(heads.end(), {"least", "highest"});
  }
  const bool beyond = traits.theta_max_deg < 90;
  heads.emplace_back("+-");
  if (beyond) heads.push_back(fmt::format("of all from theta_v > {:g}", traits.theta_max_deg));
  heads.emplace_back("");
  table.add(heads);
  for (const Albedo& albedo : report.albedos) {
    std::vector<double> totals;
    double sum = 0;
    double made_up_sum = 0;
    for (std::size_t c = 0; c < albedo.measured.size(); ++c) {
      totals.push_back(albedo.total(c));
      sum += totals.back();
      made_up_sum += albedo.beyond[c];
    }
    std::vector<std::string> row = {fmt::format("theta_i {:g}", degrees(albedo.i.theta)),
                                    traits.isotropic ? "" : fmt::format("{:g}", degrees(albedo.i.phi))};
    if (!each) totals = {*std::min_element(totals.begin(), totals.end()), largest(totals)};
    for (const double total : totals) row.push_back(fmt::format("{:.4f}", total));
    row.push_back(fmt::format("{:.1g}", largest(albedo.error)));
    if (beyond) row.push_back(percent(100 * made_up_sum / sum));
    const bool made_up = degrees(albedo.i.theta) > traits.theta_max_deg + 1e-9;
    row.emplace_back(made_up                 ? "beyond theta_max, made up"
                     : albedo.unmeasured > 0 ? "in part not measured, made up there"
                     : albedo.reached        ? ""
                                             : "accuracy not reached");
    table.add(row);
  }
  table.print();
}

std::string isotropy_text(const CheckReport& report, const SourceTraits& traits) {
  return percent(report.pairs.isotropy.percent) + (traits.isotropic ? ", isotropic by construction" : "");
}

std::string spikes_text(const CheckReport& report) {
  if (!report.spikes) return report.spikes_in;
  std::string text = format_count(report.spikes->count) + " of " + format_count(report.spikes->nodes) + " nodes, in " +
                     report.spikes_in;
  if (report.spikes->too_noisy > 0) {
    text += "; " + format_count(report.spikes->too_noisy) + " lie where the data are too noisy to tell";
  }
  return text;
}

void print_figures(const CheckReport& report, const SourceTraits& traits) {
  Table table;
  table.add(
      {"reciprocity", percent(report.reciprocity.percent) + (traits.reciprocal ? ", reciprocal by construction" : "")});
  if (report.reciprocity.percent > 0) {
    table.add({"", "f = f(i,v), r = f(v,i); largest: " + place_text(report.reciprocity.worst, traits.channels)});
  }
  table.add({"isotropy", isotropy_text(report, traits)});
  table.add({"mirror in x", percent(report.pairs.mirror_x.percent)});
  if (!traits.isotropic) table.add({"mirror in y", percent(report.pairs.mirror_y.percent)});
  const Shares& shares = report.shares;
  const std::string of = " of " + format_count(shares.count) + (report.shares_of_nodes ? " nodes" : " directions");
  const auto share = [&](double plain, double solid) {
    return percent(plain) + of + ", " + percent(solid) + " by solid angle";
  };
  table.add({"negative", share(shares.negative_percent, shares.negative_solid_percent)});
  table.add({"out of gamut", share(shares.gamut_percent, shares.gamut_solid_percent)});
  table.add({"unmeasured", share(shares.unmeasured_percent, shares.unmeasured_solid_percent)});
  table.add({"spikes", spikes_text(report)});
  std::string grazing;
  for (const GrazingGrowth& growth : report.grazing) {
    grazing += fmt::format("{}{:.2f} from {:g}", grazing.empty() ? "1/cos theta_v to the power " : ", ", growth.power,
                           growth.from_deg);
  }
  table.add({"grazing", grazing + fmt::format(" to {:g} degrees", report.grazing.back().to_deg)});
  for (const Finding& finding : traits.findings) {
    table.add({"read", format_count(finding.count) + " of " + format_count(finding.total) + " " + finding.what});
  }
  table.print();
}

void print_report(const std::string& file, const CheckReport& report, const SourceTraits& traits, double seconds) {
  Table head;
  head.add({"checked", file});
  head.add({"what", traits.description});
  head.print();
  print("\n");
  print_albedos(report, traits);
  print("\n");
  print_figures(report, traits);
  print("\n");
  Table remarks;
  for (const bool suspicious : {true, false}) {
    for (const CheckRemark& remark : report.remarks) {
      if (remark.suspicious == suspicious) remarks.add({suspicious ? "suspicious" : "note", remark.topic, remark.text});
    }
  }
  remarks.print();
  Table verdict;
  verdict.add({"took", format_number(seconds) + " s"});
  verdict.add({"verdict", report.verdict()});
  verdict.print();
}

int check_limits(const CheckCommand& command, const std::string& file, const CheckReport& report) {
  std::string above;
  const auto add = [&](const std::string& what) { above += (above.empty() ? "" : "; ") + what; };
  const auto weigh = [&](const char* name, double value, const std::optional<double>& limit, const char* unit) {
    if (exceeds(value, limit)) {
      add(fmt::format("{} {}{} is above the limit of {:g}{}", name, format_number(value), unit, *limit, unit));
    }
  };
  weigh("the highest albedo", report.highest_albedo, command.max_albedo, "");
  weigh("the reciprocity difference", report.reciprocity.percent, command.max_reciprocity, " %");
  weigh("the negative share", report.shares.negative_percent, command.max_negative, " %");
  weigh("the unmeasured share", report.shares.unmeasured_percent, command.max_unmeasured, " %");
  if (command.max_spikes) {
    if (!report.spikes) {
      add("there are no spikes to hold against the limit: " + report.spikes_in);
    } else if (report.spikes->count > *command.max_spikes) {
      add(fmt::format("{} spikes are above the limit of {}", format_count(report.spikes->count), *command.max_spikes));
    }
  }
  return above.empty() ? 0 : report_error(file, difference_error(above));
}

Result<CheckReport> check_with_bar(const BrdfSource& source, const std::string& file, const AlbedoOptions& options) {
  ProgressBar bar("checking " + one_line(file, 40));
  return check_source(source, options, bar.progress());
}

int check_file(const CheckCommand& command, const std::string& file, bool first, Json& list) {
  const auto fail = [&](const Error& error) {
    list.push_back({{"file", file}, {"error", error.message}});
    return report_error(file, error);
  };
  const Result<OpenedSource> opened = open_source(file, command.given);
  if (!opened) return fail(opened.error());
  const Stopwatch watch;
  const Result<CheckReport> report = check_with_bar(*opened->source, file, command.albedo);
  if (!report) return fail(report.error());
  const SourceTraits traits = opened->source->reported_traits();
  if (command.json) {
    list.push_back(report_json(file, *report, traits, watch.seconds()));
  } else {
    if (!first) print("\n");
    print_report(file, *report, traits, watch.seconds());
  }
  return check_limits(command, file, *report);
}

int run_check(const CheckCommand& command) {
  if (Status used = check_reading_options(command.given, command.files); !used) {
    return report_error(command.files.front(), used.error());
  }
  int exit_code = 0;
  Json list = Json::array();
  for (const std::string& file : command.files) {
    if (interrupted()) return report_error("", interrupted_error());
    const int code = check_file(command, file, &file == &command.files.front(), list);
    if (interrupted()) return code;
    // A file that could not be judged is worse than one that was found wanting.
    constexpr int kAbove = static_cast<int>(ErrorCode::kDifference);
    if (exit_code == 0 || (exit_code == kAbove && code != 0)) exit_code = code;
  }
  if (command.json) print_json(list);
  return exit_code;
}

}  // namespace

void add_check(CLI::App& program, int& exit_code) {
  auto* app =
      program.add_subcommand("check", "Tells whether measured data can be right: albedo, reciprocity, outliers.");
  const auto command = std::make_shared<CheckCommand>();
  app->add_option("FILE", command->files, "Files, kurt:NAME or BUNDLE.sbrdfz:NAME")->required();
  add_number(*app, "--max-albedo", command->max_albedo, {0}, "X", "Exit code 5 where an albedo is above");
  add_number(*app, "--max-reciprocity", command->max_reciprocity, {0}, "PERCENT",
             "Exit code 5 where f(i,v) and f(v,i) differ by more");
  add_number(*app, "--max-negative", command->max_negative, {0, 100}, "PERCENT",
             "Exit code 5 where more has a negative channel");
  add_number(*app, "--max-unmeasured", command->max_unmeasured, {0, 100}, "PERCENT",
             "Exit code 5 where more was not measured");
  add_count(*app, "--max-spikes", command->max_spikes, {},
            "Exit code 5 where more nodes stand out from all around them");
  add_number(*app, "--accuracy", command->albedo.accuracy, {1e-7, 0.1}, "X", "Of albedos");
  app->add_flag("--json", command->json, "Print JSON: a list with an object for each file");
  add_reading_options(*app, command->given);
  app->footer(
      "The albedo is the integral of f_r cos theta_v over all v. Limits hold for light and view up to theta_max, as\n"
      "values beyond are made up; a negative or unmeasured share is of nodes, or of directions where there is no "
      "table.\n"
      "Without limits the exit code is 0 whatever is found. Of several files it is that of the first that could not "
      "be\n"
      "read, else 5 where one is above a limit. specs/check.md says how each figure comes about.\n\n"
      "Examples:\n"
      "  sbrdf check material.binary\n"
      "  sbrdf check materials/*.bsdf --max-albedo 1 --max-spikes 0");
  app->callback([command, &exit_code] { exit_code = run_check(*command); });
}

}  // namespace sbrdf::internal
