// One line that says how far long work is, as time goes by: what is done now, and how long it still takes or, where that is not known, how
// long it has taken. Whoever asks brings the seconds since the work began, and prints what is due.
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>

#include "util/time_left.hpp"

namespace gustlab {

class ProgressLine {
 public:
  // A terminal's line is written over; elsewhere every line stays, and they are few.
  explicit ProgressLine(bool terminal) : first_s_(terminal ? 2.0 : 30.0), between_s_(terminal ? 0.5 : 30.0) {}

  // What is done now, and the share of all that is through where it is known. The first share is what was through at the start.
  void report(std::string what, std::optional<double> share, double now_s) {
    what_ = std::move(what);
    if (share && share == share_) return;  // what was told goes on
    share_ = share;
    left_s_.reset();
    if (!share) return;
    if (!time_left_) time_left_.emplace(*share), began_s_ = now_s;
    left_s_ = time_left_->seconds(*share, now_s - began_s_);
    reported_s_ = now_s;
  }

  // The line as it is now.
  std::string text(double now_s) const {
    const double left_s = left_s_.value_or(0.0) - (now_s - reported_s_);
    return left_s > 0.0 ? fmt::format("{}, {} left", what_, duration(left_s))
                        : fmt::format("{}, {} so far", what_, duration(now_s));
  }

  // The line, when it is time for it; it counts as printed then.
  std::optional<std::string> due(double now_s) {
    if (what_.empty() || now_s < (printed_s_ ? *printed_s_ + between_s_ : first_s_)) return {};
    printed_s_ = now_s;
    return text(now_s);
  }

 private:
  static std::string duration(double seconds) {
    const auto whole = static_cast<long>(seconds + 0.5);
    return whole < 60 ? fmt::format("{} s", whole) : fmt::format("{} min {} s", whole / 60, whole % 60);
  }

  double first_s_, between_s_;
  std::string what_;
  std::optional<TimeLeft> time_left_;  // from the first share on
  std::optional<double> share_, left_s_, printed_s_;
  double began_s_ = 0.0, reported_s_ = 0.0;
};

}  // namespace gustlab
