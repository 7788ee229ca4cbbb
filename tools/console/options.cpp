#include "tools/console/options.h"

#include <fmt/format.h>

namespace sbrdf::internal {
namespace {

// CLI11's own reading of numbers takes -1 for a large count and 010 for eight.
template <class Variable>
CLI::Option* add_number_to(CLI::App& app, const std::string& flag, Variable& value, Range range,
                           const std::string& unit, const std::string& help) {
  return app
      .add_option_function<std::string>(
          flag,
          [flag, &value, range](const std::string& text) {
            const Result<double> number = number_within(text, range);
            if (!number) throw CLI::ValidationError(flag, number.error().message);
            value = *number;
          },
          help)
      ->type_name(unit);
}

template <class Variable>
CLI::Option* add_count_to(CLI::App& app, const std::string& flag, Variable& value, CountRange range,
                          const std::string& help) {
  return app
      .add_option_function<std::string>(
          flag,
          [flag, &value, range](const std::string& text) {
            const Result<std::uint64_t> count = count_within(text, range);
            if (!count) throw CLI::ValidationError(flag, count.error().message);
            value = *count;
          },
          help)
      ->type_name("N");
}

}  // namespace

CLI::Option* add_number(CLI::App& app, const std::string& flag, double& value, Range range, const std::string& unit,
                        const std::string& help) {
  return add_number_to(app, flag, value, range, unit, help)->default_str(fmt::format("{:g}", value));
}

CLI::Option* add_number(CLI::App& app, const std::string& flag, std::optional<double>& value, Range range,
                        const std::string& unit, const std::string& help) {
  return add_number_to(app, flag, value, range, unit, help);
}

CLI::Option* add_count(CLI::App& app, const std::string& flag, std::uint64_t& value, CountRange range,
                       const std::string& help) {
  return add_count_to(app, flag, value, range, help)->default_str(std::to_string(value));
}

CLI::Option* add_count(CLI::App& app, const std::string& flag, std::optional<std::uint64_t>& value, CountRange range,
                       const std::string& help) {
  return add_count_to(app, flag, value, range, help);
}

CLI::Option* add_memory_limit(CLI::App& app, MemoryLimit& limit) {
  const auto take = [&limit](const std::string& text) {
    constexpr CountRange kMebibytes = {1, std::uint64_t{1} << 40U};
    const Result<std::uint64_t> mebibytes = count_within(text, kMebibytes);
    if (!mebibytes) throw CLI::ValidationError("--memory-limit", mebibytes.error().message);
    limit.bytes = *mebibytes << 20U;
  };
  return app
      .add_option_function<std::string>(
          "--memory-limit", take,
          "The most that reading a sliced file may take, in MiB; by default 64, and 1 for each KiB of the file")
      ->type_name("MIB");
}

}  // namespace sbrdf::internal
