#include "tools/console/progress_bar.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "formats/os/interrupt.h"
#include "tools/console/terminal.h"

namespace sbrdf::internal {
namespace {

constexpr double kFirstShown = 0.3;     // seconds: work that is done sooner shows no bar
constexpr double kBetweenShows = 0.05;  // seconds
constexpr int kWidestBar = 40;

int columns() {
  struct winsize size {};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string remaining(double seconds) {
  const auto whole = static_cast<long>(std::ceil(std::min(seconds, 1e6)));
  return whole >= 60 ? fmt::format("{} min {:02} s", whole / 60, whole % 60) : fmt::format("{} s", whole);
}

}  // namespace

struct ProgressBar::State {
  std::string label;
  bool on_terminal = isatty(STDERR_FILENO) == 1;
  bool drawn = false;
  double shown_at = kFirstShown - kBetweenShows;
  Stopwatch watch;

  void show(double fraction) {
    const double now = watch.seconds();
    if (!on_terminal || now < shown_at + kBetweenShows) return;
    shown_at = now;
    drawn = true;
    const std::string tail = fmt::format(" {:3.0f} %, {} left", 100 * fraction, remaining(now / fraction - now));
    const int room = columns() - static_cast<int>(label.size() + tail.size()) - 4;
    const int width = std::clamp(room, 0, kWidestBar);
    const int filled = static_cast<int>(fraction * width);
    const std::string line = fmt::format("\r\x1B[K{} [{:=<{}}{:<{}}]{}", label, "", filled, "", width - filled, tail);
    std::fwrite(line.data(), 1, line.size(), stderr);
    std::fflush(stderr);
  }
};

ProgressBar::ProgressBar(std::string label) : state_(std::make_unique<State>()) { state_->label = std::move(label); }

ProgressBar::~ProgressBar() { wipe(); }

void ProgressBar::wipe() {
  if (!std::exchange(state_->drawn, false)) return;
  std::fputs("\r\x1B[K", stderr);
  std::fflush(stderr);
}

Progress ProgressBar::progress() {
  return {[state = state_.get()](double fraction) {
    state->show(fraction);
    return !interrupted();
  }};
}

}  // namespace sbrdf::internal
