// What delays remember: the last values of a fixed number of steps, mixed linearly between steps.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace gustlab {

template <std::size_t Size>
class Past {
 public:
  using Sample = std::array<double, Size>;

  Past(double lookback_s, double step_s)
      : step_s_(step_s), ring_(static_cast<std::size_t>(std::ceil(lookback_s / step_s)) + 2) {}

  void fill(const Sample& sample) { std::fill(ring_.begin(), ring_.end(), sample); }
  void push(const Sample& sample) { ring_[newest_ = (newest_ + 1) % ring_.size()] = sample; }

  // the value `age` before the newest; ages beyond the memory give its oldest
  Sample before(double age_s) const {
    const double steps = std::clamp(age_s / step_s_, 0.0, static_cast<double>(ring_.size() - 2));
    const auto whole = static_cast<std::size_t>(steps);
    const double part = steps - static_cast<double>(whole);
    Sample mixed = ring_[(newest_ + ring_.size() - whole) % ring_.size()];
    const Sample& early = ring_[(newest_ + 2 * ring_.size() - whole - 1) % ring_.size()];
    if (part > 0.0)
      for (std::size_t i = 0; i < Size; ++i) mixed[i] += part * (early[i] - mixed[i]);
    return mixed;
  }

  void save(std::vector<double>& out) const {
    out.push_back(static_cast<double>(newest_));
    for (const Sample& sample : ring_) out.insert(out.end(), sample.begin(), sample.end());
  }
  // returns where the next part of the snapshot begins
  const double* load(const double* in) {
    newest_ = static_cast<std::size_t>(*in++);
    for (Sample& sample : ring_) {
      std::copy_n(in, Size, sample.begin());
      in += Size;
    }
    return in;
  }

 private:
  double step_s_;
  std::vector<Sample> ring_;
  std::size_t newest_ = 0;
};

}  // namespace gustlab
