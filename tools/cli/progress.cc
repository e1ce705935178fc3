// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/progress.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/util/text_format.h"

namespace drape {
namespace {

constexpr double kTerminalInterval = 0.1, kPlainInterval = 5.0;  // [s]
constexpr double kShownStep = 0.01;                              // of the work, on a terminal
constexpr double kLeastSeconds = 2.0, kLeastFraction = 0.05;     // before a time left is shown
// Work counts e times less after this share of the time so far, or after kLeastMemory [s].
constexpr double kMemory = 1.0, kLeastMemory = 20.0;
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

void TimeLeft::Update(double seconds, double fraction) {
  const double elapsed = seconds - seconds_, work = std::max(0.0, fraction - fraction_);
  const double memory = std::max(kLeastMemory, kMemory * seconds);
  const double kept = std::exp(-elapsed / memory);
  left_ = Estimate();
  if (left_) *left_ = std::max(0.0, *left_ - elapsed);
  recent_seconds_ = kept * recent_seconds_ + elapsed;
  recent_work_ = kept * recent_work_ + work;
  seconds_ = seconds;
  fraction_ = std::max(fraction_, fraction);
}

std::optional<double> TimeLeft::Estimate() const {
  if (seconds_ < kLeastSeconds || fraction_ < kLeastFraction || recent_work_ <= 0.0)
    return std::nullopt;
  return (1.0 - fraction_) * recent_seconds_ / recent_work_;
}

std::string ProgressText(const std::string& what, double fraction, std::optional<double> left,
                         const std::string& note) {
  std::string text = what + "  " + std::to_string(std::lround(100 * fraction)) + " %";
  if (!note.empty()) text += "  " + note;
  if (left && *left > 0 && fraction < 1) text += ", about " + DurationText(*left) + " left";
  return text;
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
  time_left_.Update(Seconds(now - start_), fraction);
  // The tasks of a batch end together, and the last of their reports is the one that matters.
  const bool advanced = is_terminal_ && on_screen_ && fraction >= shown_ + kShownStep;
  if (!advanced && Seconds(now - last_) < (is_terminal_ ? kTerminalInterval : kPlainInterval))
    return;
  last_ = now;
  shown_ = fraction;
  const std::string text = ProgressText(what_, fraction, time_left_.Seconds(), note);
  if (is_terminal_) std::fputs(kClearLine, out_);
  std::fprintf(out_, is_terminal_ ? "%s%s" : "%s%s\n", MakePrintable(unsaid_).c_str(),
               MakePrintableLine(text).c_str());
  unsaid_.clear();
  std::fflush(out_);
  on_screen_ = is_terminal_;
}

}  // namespace drape
