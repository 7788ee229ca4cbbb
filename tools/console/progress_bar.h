#pragma once

#include <memory>
#include <string>

#include "converters/source/progress.h"

namespace sbrdf::internal {

/// A bar on standard error while some work runs; nothing where standard error is not a terminal. The destructor wipes
/// it off. Whether or not it is seen, its progress() asks the work to stop after an interrupt.
class ProgressBar {
 public:
  explicit ProgressBar(std::string label);
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  ~ProgressBar();

  /// Must not be used once the bar is gone.
  [[nodiscard]] Progress progress();

  /// Takes the bar away until there is progress again, so that a line can be printed in its place.
  void wipe();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sbrdf::internal
