#pragma once

#include <CLI/CLI.hpp>

namespace sbrdf::internal {

// One file and one function per command. Each adds its command to the program; when the command runs, it leaves its
// exit code in `exit_code`: 0, or as in ErrorCode, or 128 + the number of a signal.

void add_convert(CLI::App& program, int& exit_code);
void add_info(CLI::App& program, int& exit_code);
void add_compare(CLI::App& program, int& exit_code);
void add_check(CLI::App& program, int& exit_code);
void add_eval(CLI::App& program, int& exit_code);
void add_formats(CLI::App& program, int& exit_code);
void add_schemes(CLI::App& program, int& exit_code);
void add_fit(CLI::App& program, int& exit_code);
void add_extract(CLI::App& program, int& exit_code);
void add_pack(CLI::App& program, int& exit_code);
void add_verify(CLI::App& program, int& exit_code);
void add_atlas(CLI::App& program, int& exit_code);
void add_audit(CLI::App& program, int& exit_code);
void add_codings(CLI::App& program, int& exit_code);
void add_stress(CLI::App& program, int& exit_code);
void add_bench(CLI::App& program, int& exit_code);
void add_reproduce(CLI::App& program, int& exit_code);

}  // namespace sbrdf::internal
