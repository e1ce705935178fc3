// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/progress.h"

#include <unistd.h>

#include <cmath>
#include <utility>

namespace drape {
namespace {

constexpr double kTerminalInterval = 0.1, kPlainInterval = 5.0;  // [s]
constexpr char kClearLine[] = "\r\033[K";

std::string DurationText(double seconds) {
  const auto whole = static_cast<long>(std::ceil(seconds));
  if (whole < 100) return std::to_string(whole) + " s";
  if (whole < 6000) return std::to_string((whole + 59) / 60) + " min";
  return std::to_string((whole + 3599) / 3600) + " h";
}

double Seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

std::string ProgressText(const std::string& what, double fraction, double seconds,
                         const std::string& note) {
  std::string text = what + "  " + std::to_string(std::lround(100 * fraction)) + " %";
  if (!note.empty()) text += "  " + note;
  if (fraction <= 0 || fraction >= 1) return text;
  return text + ", " + DurationText(seconds * (1 - fraction) / fraction) + " left";
}

Progress::Progress(std::string what) : Progress(std::move(what), stderr, isatty(STDERR_FILENO)) {}

Progress::Progress(std::string what, std::FILE* out, bool is_terminal)
    : what_(std::move(what)),
      out_(out),
      is_terminal_(is_terminal),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() {
  if (on_screen_) std::fputs(kClearLine, out_);
}

void Progress::Update(double fraction, const std::string& note) {
  const Clock::time_point now = Clock::now();
  if (Seconds(now - last_) < (is_terminal_ ? kTerminalInterval : kPlainInterval)) return;
  last_ = now;
  const std::string text = ProgressText(what_, fraction, Seconds(now - start_), note);
  if (is_terminal_) std::fputs(kClearLine, out_);
  std::fprintf(out_, is_terminal_ ? "%s%s" : "%s%s\n", unsaid_.c_str(), text.c_str());
  unsaid_.clear();
  std::fflush(out_);
  on_screen_ = is_terminal_;
}

}  // namespace drape
