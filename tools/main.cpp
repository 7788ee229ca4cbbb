#include <CLI/CLI.hpp>
#include <cstddef>
#include <exception>
#include <new>
#include <span>
#include <string>

#include "converters/files/by_name.h"
#include "formats/core/result.h"
#include "formats/os/interrupt.h"
#include "formats/os/trial.h"
#include "tools/commands/commands.h"
#include "tools/console/terminal.h"
#include "tools/console/threads.h"

namespace {

std::string usage_message(const CLI::App& program, const CLI::ParseError& error, int argc, char** argv) {
  const auto chosen = program.get_subcommands();
  if (!chosen.empty()) return std::string(error.what()) + "; see 'sbrdf " + chosen.front()->get_name() + " --help'";
  // CLI11 says only that a command is missing.
  const bool misspelt = argc > 1 && *argv[1] != '-';
  return (misspelt ? "there is no command '" + std::string(argv[1]) + "'" : error.what()) + "; see 'sbrdf --help'";
}

int run_command(int argc, char** argv) {
  CLI::App program("Sliced representation of measured BRDFs: converts, evaluates and compares.", "sbrdf");
  program.set_version_flag("--version", "sbrdf " SBRDF_VERSION);
  program.require_subcommand(1);
  program.footer(
      "A BRDF is a file, recognised by its content, a material BUNDLE.sbrdfz:NAME (see 'sbrdf pack --help'), or\n"
      "kurt:NAME or kurt:FILE.json (see 'sbrdf formats').\n"
      "Exit codes: 0 ok, 1 usage, 2 reading or writing, 3 invalid file, 4 unsupported, 5 difference above a limit.\n\n"
      "Example:\n  sbrdf convert kurt:fabric112 fabric112.sbrdf --samples 8911");
  int exit_code = 0;
  sbrdf::internal::add_convert(program, exit_code);
  sbrdf::internal::add_info(program, exit_code);
  sbrdf::internal::add_compare(program, exit_code);
  sbrdf::internal::add_check(program, exit_code);
  sbrdf::internal::add_eval(program, exit_code);
  sbrdf::internal::add_formats(program, exit_code);
  sbrdf::internal::add_schemes(program, exit_code);
  sbrdf::internal::add_fit(program, exit_code);
  sbrdf::internal::add_extract(program, exit_code);
  sbrdf::internal::add_pack(program, exit_code);
  sbrdf::internal::add_verify(program, exit_code);
  sbrdf::internal::add_audit(program, exit_code);
  sbrdf::internal::add_codings(program, exit_code);
  sbrdf::internal::add_atlas(program, exit_code);
  sbrdf::internal::add_stress(program, exit_code);
  sbrdf::internal::add_bench(program, exit_code);
  sbrdf::internal::add_reproduce(program, exit_code);
  try {
    program.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    sbrdf::internal::print(program.help());
  } catch (const CLI::CallForVersion& version) {
    sbrdf::internal::print(std::string(version.what()) + "\n");
  } catch (const CLI::ParseError& error) {
    exit_code =
        sbrdf::internal::report_error("", sbrdf::internal::usage_error(usage_message(program, error, argc, argv)));
  }
  return exit_code;
}

int run(int argc, char** argv) {
  try {
    int exit_code = 0;
    sbrdf::internal::run_with_possible_threads([&] { exit_code = run_command(argc, argv); });
    return exit_code;
  } catch (const std::bad_alloc&) {
    return sbrdf::internal::report_no_memory();
  } catch (const std::exception& error) {
    return sbrdf::internal::report_error("", sbrdf::internal::io_error(error.what()));
  }
}

[[noreturn]] void try_file(int argc, char** argv) {
  bool tried = true;
  try {
    const std::span all(argv, static_cast<std::size_t>(argc));
    sbrdf::internal::run_with_possible_threads(
        [&] { tried = sbrdf::internal::open_in_trial(all.subspan(sbrdf::internal::kTrialArguments)); });
  } catch (const std::exception&) {
    // Want of memory, which the program itself will tell of.
  }
  sbrdf::internal::end_trial(tried);
}

}  // namespace

int main(int argc, char** argv) {
  if (sbrdf::internal::is_trial(argc, argv)) try_file(argc, argv);
  sbrdf::internal::allow_trials();
  sbrdf::internal::keep_standard_descriptors();
  sbrdf::internal::catch_interrupts();
  return sbrdf::internal::finish_output(run(argc, argv));
}
