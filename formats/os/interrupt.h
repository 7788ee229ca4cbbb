#pragma once

namespace sbrdf::internal {

/// From here on SIGINT, SIGTERM and SIGHUP are remembered instead of ending the program, so that work can stop and
/// leave nothing half-written. A second signal does not wait: the file named by remove_on_abort is removed and the
/// program ends. Signals that were ignored when the program started stay ignored. Writing past a limit on file sizes
/// becomes an error of the write instead of a signal.
void catch_interrupts();

/// The end of catch_interrupts: from here on a signal ends the program as it does any other, and interrupted() does not
/// change any more.
void stop_catching_interrupts();

/// A signal came.
[[nodiscard]] bool interrupted();

/// Waits until `descriptor` can be read without waiting, its end included. False once interrupted() is true, also where
/// the signal comes while this waits or just before.
[[nodiscard]] bool wait_for_input(int descriptor);

/// The same for writing: a pipe whose reader rests takes nothing for as long as that lasts.
[[nodiscard]] bool wait_for_output(int descriptor);

/// 128 + the number of the signal: 130 for SIGINT. Only meaningful once interrupted() is true.
[[nodiscard]] int interrupt_exit_code();

/// The file to remove when a second signal ends the program; nullptr for none. `path` must stay valid until the next
/// call.
void remove_on_abort(const char* path);

}  // namespace sbrdf::internal
