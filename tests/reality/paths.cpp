#include "paths.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

namespace reality {
namespace {

constexpr double kMostPush_mps2 = 4.5;   // on the way to a waypoint
constexpr double kClimbPush_mps2 = 2.0;  // on the way to another height
constexpr double kTurn = 2 * std::numbers::pi;

// quintic from 0 to 1 with rest at both ends
double blend(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10 + s * (-15 + 6 * s));
}

// one inside [from, to], zero outside, with soft edges
double window(double t, double from_s, double to_s, double edge_s) {
  return blend((t - from_s) / edge_s) * blend((to_s - t) / edge_s);
}

// values that are reached one after the other and then held
class Stairs {
 public:
  void add(double start_s, double duration_s, double value) { step_.push_back({start_s, duration_s, value}); }
  explicit Stairs(double first) : first_(first) {}
  double operator()(double t) const {
    double value = first_;
    for (const auto& s : step_) value += (s.value - value) * blend((t - s.start_s) / s.duration_s);
    return value;
  }

 private:
  struct Step {
    double start_s, duration_s, value;
  };
  double first_;
  std::vector<Step> step_;
};

// an angle whose rate follows stairs; tabulated integral
class Sweep {
 public:
  Sweep(const Stairs& rate, double start_rad) {
    double angle = start_rad;
    for (double t = -kPreroll_s - 1; t < kFlight_s + 1; t += kStep) {
      angle_.push_back(angle);
      angle += kStep * rate(t + 0.5 * kStep);
    }
  }
  double operator()(double t) const {
    const double x = std::clamp((t + kPreroll_s + 1) / kStep, 1.0, static_cast<double>(angle_.size()) - 3.001);
    const auto i = static_cast<std::size_t>(x);
    const double f = x - static_cast<double>(i);
    const double slope_a = 0.5 * (angle_[i + 1] - angle_[i - 1]), slope_b = 0.5 * (angle_[i + 2] - angle_[i]);
    const double d = angle_[i + 1] - angle_[i];
    return angle_[i] + f * (slope_a + f * (3 * d - 2 * slope_a - slope_b + f * (slope_a + slope_b - 2 * d)));
  }

 private:
  static constexpr double kStep = 0.01;
  std::vector<double> angle_;
};

struct Scale {
  double span_m, speed_mps, height_m, radius_m;
  double clearance;  // widens the distances to ground, ceiling and wall of a vehicle that holds them badly
};

// roll, pitch and yaw multisines of 1-8 Hz in a few windows
std::function<Vec3(double)> draw_shake(bool large, double gentleness, Rng& rng, int windows) {
  struct Tone {
    double radps, phase, size;
  };
  std::array<std::vector<Tone>, 3> tones;
  for (int axis = 0; axis < 3; ++axis)
    for (const double hz : {1.1, 1.7, 2.6, 3.7, 5.2, 7.3}) {
      const double swing_rad = (large ? 0.02 : 0.025) * gentleness * rng.uniform(0.7, 1.3);
      const double radps = kTurn * hz * rng.uniform(0.93, 1.07);
      const double limit = axis == 2 ? (large ? 0.25 : 2.5) : (large ? 3.0 : 12.0);
      tones[axis].push_back({radps, rng.uniform(0, kTurn), std::min(swing_rad * radps * radps, limit)});
    }
  std::vector<std::pair<double, double>> spans;
  for (int i = 0; i < windows; ++i) {
    const double slot_s = kFlight_s / windows, start_s = i * slot_s + rng.uniform(0.1, 0.3) * slot_s;
    spans.push_back({start_s, start_s + rng.uniform(0.35, 0.6) * slot_s});
  }
  return [tones, spans](double t) {
    double gate = 0;
    for (const auto& [from_s, to_s] : spans) gate += window(t, from_s, to_s, 0.3);
    Vec3 shake = Vec3::Zero();
    if (gate == 0) return shake;
    for (int axis = 0; axis < 3; ++axis)
      for (const Tone& tone : tones[axis]) shake[axis] += gate * tone.size * std::sin(tone.radps * t + tone.phase);
    return shake;
  };
}

std::function<double(double)> draw_surge(double gentleness, Rng& rng) {
  const double start_s = rng.uniform(2, 14), length_s = rng.uniform(4, 7);
  const double size = rng.uniform(1.5, 2.5) * gentleness, first_hz = rng.uniform(0.6, 0.9);
  const double growth_hzps = rng.uniform(0.15, 0.3);
  return [=](double t) {
    const double x = t - start_s;
    return size * window(t, start_s, start_s + length_s, 0.4) *
           std::sin(kTurn * (first_hz + 0.5 * growth_hzps * x) * x);
  };
}

// the quickest pleasant climb over this height
double climb_s(double height_m) { return std::max(0.9, std::sqrt(5.8 * std::abs(height_m) / kClimbPush_mps2)); }

void shuffle(std::vector<double>& values, Rng& rng) {
  for (std::size_t i = values.size(); i > 1; --i)
    std::swap(values[i - 1], values[static_cast<std::size_t>(rng.below(static_cast<int>(i)))]);
}

// heights of a staircase between two times: first near the ground, then under the ceiling, where these are known
Stairs draw_heights(const Scale& scale, const Surroundings& around, double from_s, double to_s, double hold_s,
                    Rng& rng) {
  std::vector<double> low, high, heights;
  const double unit_m = scale.clearance * scale.radius_m;
  if (around.ground_z_m)
    for (const double r : {2.6, 3.2, 4.2, 6.0}) low.push_back(*around.ground_z_m + r * unit_m);
  if (around.ceiling_z_m)
    for (const double r : {2.8, 3.4, 4.4, 6.0}) high.push_back(*around.ceiling_z_m - r * unit_m);
  for (int i = 0; low.empty() && high.empty() && i < 8; ++i) heights.push_back(scale.height_m * rng.uniform(0.7, 1.3));
  shuffle(low, rng);
  shuffle(high, rng);
  // with both, half the time each
  const std::size_t share = low.empty() || high.empty() ? 4 : 2;
  for (std::size_t i = 0; i < 8; ++i) {
    auto& from = low.empty() || (!high.empty() && i >= share * 2) ? high : low;
    if (!from.empty()) heights.push_back(from[i % from.size()]);
  }
  Stairs stairs(scale.height_m);
  double t = from_s, last_m = scale.height_m;
  for (const double height_m : heights) {
    const double takes_s = climb_s(height_m - last_m);
    if (t + takes_s + hold_s + climb_s(scale.height_m - height_m) > to_s) break;
    stairs.add(t, takes_s, height_m);
    t += takes_s + hold_s;
    last_m = height_m;
  }
  stairs.add(t, climb_s(scale.height_m - last_m), scale.height_m);
  return stairs;
}

Path circle(const Scale& s, const Surroundings& around, double gentleness, bool large, Rng& rng) {
  const double radius_m = s.span_m * rng.uniform(0.65, 0.95), side = rng.sign();
  const double fast = s.speed_mps / radius_m;
  Stairs rate(side * 0.25 * fast);
  rate.add(1, 4, side * 0.6 * fast);
  rate.add(6, 4, side * fast);
  rate.add(10.5, 3, -side * 0.4 * fast);
  rate.add(15, 3, -side * 0.85 * fast);
  rate.add(20, 3, -side * 0.3 * fast);
  const Sweep angle(rate, rng.uniform(0, kTurn));
  Stairs spin(rng.uniform(-0.3, 0.3));
  const double turn = rng.sign();
  spin.add(2, 2, turn * rng.uniform(0.5, 0.9));
  spin.add(12, 3, -turn * rng.uniform(0.5, 1.0));
  const Sweep yaw(spin, rng.uniform(-3, 3));
  const double bob_m = 0.15 * s.height_m, bob_hz = rng.uniform(0.12, 0.25);
  const Stairs heights = draw_heights(s, around, 15.5, 25, 0.9, rng);
  Path path;
  path.position_W_m = [=](double t) {
    const double calm = heights(t) - s.height_m;
    return Vec3(radius_m * std::cos(angle(t)), radius_m * std::sin(angle(t)),
                s.height_m + calm + bob_m * window(t, -9, 15, 2) * std::sin(kTurn * bob_hz * t));
  };
  path.yaw_rad = [yaw](double t) { return yaw(t); };
  path.shake_radps2 = draw_shake(large, gentleness, rng, 3);
  path.surge_mps2 = [](double) { return 0.0; };
  return path;
}

Path staircase(const Scale& s, const Surroundings& around, double gentleness, bool large, Rng& rng) {
  const bool low = around.ground_z_m || around.ceiling_z_m;
  const double size_m = s.span_m * rng.uniform(0.5, 0.8), start = rng.uniform(0, kTurn);
  const double rate = (low ? 0.3 : 0.45) * s.speed_mps / size_m * rng.sign();
  const Stairs heights = draw_heights(s, around, 1.0, 25, low ? 1.2 : 2.2, rng);
  Stairs yaw(rng.uniform(-2, 2));
  double heading = yaw(0);
  for (double t = 1.5; t < 23; t += rng.uniform(2.2, 3.2))
    yaw.add(t, large ? 1.7 : 0.8, heading += rng.either(0.6, 1.4));
  const double wave_m = 0.06 * s.height_m, wave_hz = rng.uniform(0.5, 0.8);
  Path path;
  path.position_W_m = [=](double t) {
    const double a = rate * t + start;
    return Vec3(size_m * std::sin(a), 0.6 * size_m * std::sin(2 * a),
                heights(t) + (low ? 0.0 : wave_m * std::sin(kTurn * wave_hz * t)));
  };
  path.yaw_rad = [yaw](double t) { return yaw(t); };
  path.shake_radps2 = draw_shake(large, 0.8 * gentleness, rng, low ? 1 : 2);
  path.surge_mps2 = low ? [](double) { return 0.0; } : draw_surge(gentleness, rng);
  return path;
}

// to and fro along the wall, at a few distances
Path along_wall(const Scale& s, const Wall& wall, double gentleness, bool large, Rng& rng) {
  std::vector<double> far_m;
  for (const double r : {1.0, 1.3, 1.8, 2.6, 1.0, 1.3, 1.8, 4.0})
    far_m.push_back((large ? 3.6 : 6.5) * r * s.clearance * s.radius_m);
  shuffle(far_m, rng);
  Stairs distance(0.5 * s.span_m);
  double t = 0.5;
  for (const double d : far_m) {
    distance.add(t, 1.6, d);
    t += 3.0;
  }
  const double swing_m = 0.35 * s.span_m, hz = rng.uniform(0.1, 0.16), start = rng.uniform(0, kTurn);
  const Eigen::Vector2d foot = wall.point_W_m, inward = wall.normal_W, along(-inward.y(), inward.x());
  const double turn = rng.either(0.25, 0.5), heading = rng.uniform(-3, 3), rise_m = 0.15 * s.height_m;
  Path path;
  path.position_W_m = [=](double a) {
    const Eigen::Vector2d spot = foot + distance(a) * inward + swing_m * std::sin(kTurn * hz * a + start) * along;
    return Vec3(spot.x(), spot.y(), s.height_m + rise_m * std::sin(1.7 * kTurn * hz * a));
  };
  path.yaw_rad = [=](double a) { return heading + turn * a; };
  path.shake_radps2 = draw_shake(large, 0.6 * gentleness, rng, 1);
  path.surge_mps2 = [](double) { return 0.0; };
  return path;
}

Path waypoints(const Scale& s, const Surroundings& around, double gentleness, bool large, Rng& rng) {
  Stairs x(rng.uniform(-0.5, 0.5) * s.span_m), y(rng.uniform(-0.5, 0.5) * s.span_m), z(s.height_m);
  double last_x = x(0), last_y = y(0), last_z = s.height_m, t = -1;
  while (t < 23.5) {
    double to_x = rng.uniform(-1, 1) * s.span_m, to_y = rng.uniform(-1, 1) * s.span_m;
    double to_z = s.height_m * rng.uniform(0.6, 1.5);
    if (around.ceiling_z_m) to_z = std::min(to_z, 0.6 * *around.ceiling_z_m + 0.4 * s.height_m);
    double slow = rng.uniform(0.55, 1.0);
    if (around.wall && rng.chance(0.6)) {
      // along the wall at a few radii
      const Eigen::Vector2d& n = around.wall->normal_W;
      const double away_m = (large ? 1 : 1.5) * rng.uniform(3.5, 7.0) * s.clearance * s.radius_m;
      const Eigen::Vector2d spot =
          around.wall->point_W_m + away_m * n + rng.uniform(-0.6, 0.6) * s.span_m * Eigen::Vector2d(-n.y(), n.x());
      to_x = spot.x();
      to_y = spot.y();
      slow = 0.45;
    }
    if (around.wall) {
      // never behind the wall
      const Eigen::Vector2d& n = around.wall->normal_W;
      const double away_m = (Eigen::Vector2d(to_x, to_y) - around.wall->point_W_m).dot(n);
      const double lack_m = std::max(0.0, (large ? 3.5 : 5.2) * s.clearance * s.radius_m - away_m);
      to_x += lack_m * n.x();
      to_y += lack_m * n.y();
    }
    const double far_m = Vec3(to_x - last_x, to_y - last_y, 1.5 * (to_z - last_z)).norm();
    const double takes_s =
        std::max({1.2, 1.9 * far_m / (slow * s.speed_mps), std::sqrt(5.8 * far_m / kMostPush_mps2) / gentleness});
    x.add(t, takes_s, to_x);
    y.add(t, takes_s, to_y);
    z.add(t, takes_s, to_z);
    last_x = to_x, last_y = to_y, last_z = to_z;
    t += takes_s + rng.uniform(0.0, 0.5);
  }
  Stairs yaw(rng.uniform(-2, 2));
  double heading = yaw(0);
  for (double a = 0.5; a < 23; a += rng.uniform(2.0, 2.8))
    yaw.add(a, large ? 1.7 : 0.8, heading += rng.either(0.5, 1.5));
  Path path;
  path.position_W_m = [=](double a) { return Vec3(x(a), y(a), z(a)); };
  path.yaw_rad = [yaw](double a) { return yaw(a); };
  path.shake_radps2 = draw_shake(large, gentleness, rng, 2);
  path.surge_mps2 = draw_surge(gentleness, rng);
  return path;
}

Path other(const Scale& s, const Surroundings& around, double gentleness, bool large, Rng& rng) {
  const double size_m = s.span_m * rng.uniform(0.6, 0.85), round = rng.sign();
  const double petals = rng.chance(0.5) ? 1.5 : 0.5, calm = around.ground_z_m || around.ceiling_z_m ? 0.65 : 1;
  const double rate = calm * (petals > 1 ? 0.5 : 0.8) * s.speed_mps / size_m * round;
  const double start = rng.uniform(0, kTurn), squeeze = rng.uniform(0.6, 1.0);
  Stairs pace(0.5 * rate);
  pace.add(2, 4, rate);
  pace.add(10, 3, -0.6 * rate);
  pace.add(17, 3, -rate);
  const Sweep angle(pace, start);
  const Stairs heights = draw_heights(s, around, 3.5, 23, 2.0, rng);
  const double near_m = (large ? 4.5 : 7.0) * s.clearance * s.radius_m;
  const double yaw_size = rng.uniform(0.8, 2.0), yaw_hz = rng.uniform(0.1, 0.2), yaw_start = rng.uniform(-2, 2);
  Path path;
  path.position_W_m = [=](double t) {
    const double a = angle(t), r = size_m * (0.75 + 0.25 * std::cos(2 * petals * a));
    Vec3 p(r * std::cos(a), squeeze * r * std::sin(a), heights(t));
    if (around.wall) {
      const Eigen::Vector2d spot = around.wall->point_W_m + near_m * around.wall->normal_W;
      const Vec3 beside(spot.x(), spot.y(), p.z());
      p += window(t, 10, 18, 3.0) * (beside - p);
    }
    return p;
  };
  path.yaw_rad = [=](double t) { return yaw_start + yaw_size * std::sin(kTurn * yaw_hz * t); };
  path.shake_radps2 = draw_shake(large, 0.7 * gentleness, rng, 1);
  path.surge_mps2 = [](double) { return 0.0; };
  return path;
}

}  // namespace

Path draw_path(Figure figure, const Nominal& nominal, const Surroundings& around, double gentleness, Rng& rng) {
  const bool large = nominal.large;
  Scale s;
  s.radius_m = nominal.radius_m;
  s.clearance = std::pow(gentleness, -1.5);
  s.span_m = large ? 6.5 : 1.4;
  s.speed_mps = (large ? 6.0 : 2.4) * gentleness * rng.uniform(0.85, 1.1);
  s.height_m = large ? 3.0 : 1.0;
  if (around.ground_z_m) s.height_m = *around.ground_z_m + (large ? 1.4 : 0.7);
  if (around.ceiling_z_m && !around.ground_z_m) s.height_m = *around.ceiling_z_m - (large ? 1.4 : 0.7);
  switch (figure) {
    case Figure::circle:
      return circle(s, around, gentleness, large, rng);
    case Figure::staircase:
      if (around.wall && !around.ground_z_m && !around.ceiling_z_m)
        return along_wall(s, *around.wall, gentleness, large, rng);
      return staircase(s, around, gentleness, large, rng);
    case Figure::waypoints:
      return waypoints(s, around, gentleness, large, rng);
    case Figure::holdout:
      break;
  }
  return other(s, around, gentleness, large, rng);
}

}  // namespace reality
