#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "formats/core/byte_source.h"
#include "formats/core/result.h"

namespace sbrdf::internal {

// Some libraries that read files fall over damaged ones and take the whole program with them. A program whose main()
// says so tries such a file in a process of its own first, which is the program once more:
//
//   if (is_trial(argc, argv)) {
//     end_trial(open_and_close(kTrialFile));  // the bytes are those of the file that is tried
//   }
//   allow_trials();
//
// Started again rather than forked: a copy of a process with threads may do next to nothing.

/// Path of the file that a trial is about, in its process.
inline constexpr const char* kTrialFile = "/proc/self/fd/0";

/// From here on try_apart() starts the program again. Called by main(), before there are threads; SIGCHLD has its
/// default meaning from here on.
void allow_trials();

/// How a trial went.
enum class TrialEnd : std::uint8_t {
  kSurvived,    ///< the process came to its end, whatever it thought of the file
  kFell,        ///< it was ended by a signal, or ended in a way of its own
  kEndless,     ///< it used kTrialSeconds without having read another piece of the file
  kImpossible,  ///< no process could be started, or trials are not allowed
};

/// Starts the program with `arguments` behind the word that is_trial() knows, and waits for it. Nothing that it prints
/// is seen. interrupted_error() after a signal.
[[nodiscard]] Result<TrialEnd> try_apart(const ByteSource& bytes, const std::vector<std::string>& arguments);

/// Whether this process is a trial; its arguments are those from argv[kTrialArguments] on. Sets its limits:
/// kTrialSeconds of all processors together, which begin anew at each piece_done(), and no image of it on the disk
/// where it falls.
[[nodiscard]] bool is_trial(int argc, char** argv);
inline constexpr int kTrialArguments = 2;
inline constexpr int kTrialSeconds = 4;

/// Says that it came to its end, without what else is done at the end of a program; or that the file could not be
/// tried.
[[noreturn]] void end_trial(bool tried);

}  // namespace sbrdf::internal
