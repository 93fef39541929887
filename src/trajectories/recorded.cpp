// recorded: the reference columns of a flight log, joined by polynomials of degree 5 in time.
//
// Columns rpx, rpy, rpz and, where they are there, rvx…, rax…, ryaw (FORMATS.md §1); what is missing is estimated from the
// neighbours. Velocity and acceleration are continuous, jerk and snap jump at samples. Before the first sample and after
// the last the reference stands still.
#include <algorithm>
#include <cmath>

#include "flight_log/csv.hpp"
#include "gustlab/errors.hpp"
#include "trajectories/jet.hpp"
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

class Recorded final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.file("file", file_, {.help = "flight log (csv) with columns time_s, rpx, rpy, rpz"});
    visitor.vector("offset_m", offset_W_m_, {.unit = "m", .help = "added to every position"});
  }

  void prepare() override {
    knots_.clear();
    if (file_.bytes.empty()) {
      knots_.push_back({});
      return;
    }
    const CsvNumbers csv(file_.path, [](std::string_view) { return true; });
    const auto column = [&](const std::string& name) -> const std::vector<double>* {
      for (std::size_t i = 0; i < csv.names().size(); ++i)
        if (csv.names()[i] == name) return &csv.column(i);
      return nullptr;
    };
    const auto need = [&](const std::string& name) -> const std::vector<double>& {
      if (const auto* found = column(name)) return *found;
      throw DataError(file_.path + ":1:1: column " + name +
                      " is missing (a recorded trajectory is read from it); name a log with a reference");
    };
    const std::vector<double>& time_s = need("time_s");
    const std::vector<double>* yaw = column("ryaw");
    std::array<const std::vector<double>*, 3> position{&need("rpx"), &need("rpy"), &need("rpz")};
    std::array<const std::vector<double>*, 3> velocity{column("rvx"), column("rvy"), column("rvz")};
    std::array<const std::vector<double>*, 3> acceleration{column("rax"), column("ray"), column("raz")};
    for (std::size_t row = 0; row < csv.rows(); ++row) {
      Knot knot;
      knot.time_s = time_s[row] - time_s[0];
      for (int k = 0; k < 3; ++k) {
        const auto axis = static_cast<std::size_t>(k);
        knot.position_W_m[k] = (*position[axis])[row];
        knot.velocity_W_mps[k] = velocity[axis] ? (*velocity[axis])[row] : unknown;
        knot.acceleration_W_mps2[k] = acceleration[axis] ? (*acceleration[axis])[row] : unknown;
      }
      knot.yaw_rad = yaw ? (*yaw)[row] : 0.0;
      // rows without a reference are skipped
      if (knot.position_W_m.allFinite() && std::isfinite(knot.time_s) && std::isfinite(knot.yaw_rad)) {
        if (!knots_.empty() && !(knot.time_s > knots_.back().time_s))
          throw DataError(csv.where(row, 0) +
                          ": time does not rise (a trajectory is a function of time); repair the log");
        if (!knots_.empty())
          knot.yaw_rad = knots_.back().yaw_rad + std::remainder(knot.yaw_rad - knots_.back().yaw_rad, 2.0 * pi);
        knots_.push_back(knot);
      }
    }
    if (knots_.size() < 2)
      throw DataError(
          file_.path +
          ":1:1: fewer than two samples of a reference (columns rpx, rpy, rpz); name a log with a reference");
    fill(&Knot::position_W_m, &Knot::velocity_W_mps);
    fill(&Knot::velocity_W_mps, &Knot::acceleration_W_mps2);
  }

  Reference at(double time_s) const override {
    const bool inside = time_s >= knots_.front().time_s && time_s <= knots_.back().time_s && knots_.size() > 1;
    if (!inside) {
      const Knot& end = time_s < knots_.front().time_s ? knots_.front() : knots_.back();
      Reference reference;
      reference.position_W_m = end.position_W_m + offset_W_m_;
      reference.yaw_rad = end.yaw_rad;
      return reference;
    }
    const auto later = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, time_s,
                                        [](double t, const Knot& knot) { return t < knot.time_s; });
    const Knot &a = *(later - 1), &b = *later;
    const double length_s = b.time_s - a.time_s;
    const Jet x = (1.0 / length_s) * (Jet::time(time_s) - a.time_s);
    std::array<Jet, 3> position;
    for (int k = 0; k < 3; ++k) {
      // quintic in x with the ends' position, velocity and acceleration
      const double p0 = a.position_W_m[k] + offset_W_m_[k], d = b.position_W_m[k] - a.position_W_m[k];
      const double v0 = a.velocity_W_mps[k] * length_s, v1 = b.velocity_W_mps[k] * length_s;
      const double a0 = a.acceleration_W_mps2[k] * length_s * length_s,
                   a1 = b.acceleration_W_mps2[k] * length_s * length_s;
      const double c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1;
      const double c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1;
      const double c5 = 6.0 * d - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1;
      position[static_cast<std::size_t>(k)] = p0 + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5))));
    }
    Reference reference =
        reference_of(position[0], position[1], position[2], a.yaw_rad + x.value() * (b.yaw_rad - a.yaw_rad));
    reference.yaw_rate_radps = (b.yaw_rad - a.yaw_rad) / length_s;
    return reference;
  }

  double duration_s() const override { return knots_.back().time_s; }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  struct Knot {
    double time_s = 0.0;
    Vector3 position_W_m{0.0, 0.0, 1.0}, velocity_W_mps = Vector3::Zero(), acceleration_W_mps2 = Vector3::Zero();
    double yaw_rad = 0.0;
  };

  // unknown derivatives from the parabola through the neighbours; at the ends one-sided
  void fill(Vector3 Knot::*from, Vector3 Knot::*to) {
    const std::size_t last = knots_.size() - 1;
    std::vector<Vector3> slopes(knots_.size());
    for (std::size_t i = 0; i <= last; ++i) {
      const std::size_t before = i == 0 ? 0 : i - 1, after = i == last ? last : i + 1;
      const auto slope = [&](std::size_t a, std::size_t b) {
        return Vector3((knots_[b].*from - knots_[a].*from) / (knots_[b].time_s - knots_[a].time_s));
      };
      if (before == i || after == i) {
        slopes[i] = slope(before, after);
      } else {
        const double h0 = knots_[i].time_s - knots_[before].time_s, h1 = knots_[after].time_s - knots_[i].time_s;
        slopes[i] = (h1 * slope(before, i) + h0 * slope(i, after)) / (h0 + h1);
      }
    }
    for (std::size_t i = 0; i <= last; ++i)
      for (int k = 0; k < 3; ++k)
        if (!std::isfinite((knots_[i].*to)[k])) (knots_[i].*to)[k] = slopes[i][k];
  }

  InputFile file_;
  Vector3 offset_W_m_ = Vector3::Zero();
  std::vector<Knot> knots_{Knot{}};  // without a file: one point
};

}  // namespace

std::unique_ptr<Trajectory> make_recorded() { return std::make_unique<Recorded>(); }

}  // namespace gustlab
