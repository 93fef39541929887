// How long work still takes. Whoever asks brings the time that went by.
#pragma once

#include <optional>

namespace gustlab {

class TimeLeft {
 public:
  // The share of the work that was done before this program began.
  explicit TimeLeft(double first_share) : first_share_(first_share) {}
  // Seconds, if the rest goes as what was done here did; nothing where that does not tell.
  std::optional<double> seconds(double share, double elapsed_s) const {
    if (share <= first_share_ || share >= 1.0) return {};
    return elapsed_s * (1.0 - share) / (share - first_share_);
  }

 private:
  double first_share_;
};

}  // namespace gustlab
