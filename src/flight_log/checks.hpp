// Does the recorded attitude turn as the recorded body rate says?
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace gustlab {

// Columns of a log; NaN: no sample.
struct AttitudeColumns {
  const std::vector<double>& time_s;
  const std::vector<double>* q[4];  // w, x, y, z
  const std::vector<double>* w[3];
};

// Integrates the body rate over a fifth of a second and compares the turn with the attitude's. Of a log that is read in parts, each window
// lies within one.
class AttitudeCheck {
 public:
  // A part of the log. Its row from which on they turn differently, when this is the first part that shows it.
  std::optional<std::size_t> add(const AttitudeColumns& columns);
  // Whether they contradict each other in all parts together; too little may turn to tell.
  bool contradicts() const;
  // The convention under which they agree, or empty.
  std::string suggestion() const;

  struct Sums {  // over windows that turn
    double wrong = 0.0, all = 0.0;
    std::size_t windows = 0;
    double share() const { return all > 0.0 ? wrong / all : 0.0; }
    void add(const Sums& other);
  };

 private:
  static constexpr std::size_t conventions = 6;  // of which the first is the one that is right

  Sums as_read_;
  std::array<Sums, conventions> doubted_;  // of parts that contradict
  bool shown_ = false;
};

}  // namespace gustlab
