#include "air.hpp"

#include <algorithm>
#include <cmath>

namespace reality {
namespace {

constexpr int kStations = 4;  // blade positions; exact for the harmonics that occur here

// what a rotor's blades see, averaged over one turn
struct BladeMeans {
  double square = 0;           // tangential speed squared
  double cross = 0;            // tangential speed times axial speed
  Vec3 pull_B = Vec3::Zero();  // tangential speed squared, along the blade's motion
};

BladeMeans sweep(const Vec3& axis_B, double spin, double tip_mps, const Vec3& air_B) {
  const Vec3 first = axis_B.unitOrthogonal(), second = axis_B.cross(first);
  BladeMeans mean;
  for (int k = 0; k < kStations; ++k) {
    const double cosine[] = {1, 0, -1, 0}, sine[] = {0, 1, 0, -1};
    const Vec3 blade = cosine[k] * first + sine[k] * second;
    const Vec3 ahead = spin * axis_B.cross(blade);
    const double meets_mps = tip_mps + air_B.dot(ahead);
    mean.square += meets_mps * meets_mps / kStations;
    mean.cross += meets_mps * air_B.dot(axis_B) / kStations;
    mean.pull_B += meets_mps * meets_mps / kStations * ahead;
  }
  return mean;
}

// a plane mirrors the rotor: twice the distance to it is the distance to the image
double image_gain(double strength, double radius_m, double distance_m) {
  const double image_m = 2 * std::max(distance_m, radius_m);
  return 1 + strength * std::pow(0.5 * radius_m / image_m, 2);
}

// share of the thrust left by a sinking rotor that recirculates its own wake
double vortex_factor(const Outside& o, double climb_mps) {
  if (o.vortex_loss == 0) return 1;
  const double off = (-climb_mps - o.vortex_speed_mps) / (0.4 * o.vortex_speed_mps);
  return 1 - o.vortex_loss * std::exp(-0.5 * off * off);
}

}  // namespace

Wrench rotors_in_air(const Truth& truth, const Motion& m, const Drive& drive) {
  const Nominal& nominal = truth.nominal;
  const Mat3 R = m.attitude.toRotationMatrix();
  const Vec3 air_B = R.transpose() * (m.velocity_W_mps - truth.wind_W_mps);
  const Vec3 axis_B = Vec3(truth.rotor_tilt_rad.x(), truth.rotor_tilt_rad.y(), 1).normalized();
  const double station_m = 0.7 * nominal.radius_m;  // where a blade's mean load acts
  const double at_hover_mps = station_m * nominal.hover_speed_radps();
  const double drag = truth.rotor_drag / (kRotors * at_hover_mps);
  const double inflow = truth.inflow / (kRotors * at_hover_mps);
  const double lift = 2 * truth.lift;
  const double flapping = truth.flapping / station_m;
  const double sag = truth.sag_exponent == 0
                         ? 1 - truth.sag_rate_1ps * std::max(0.0, drive.time_s)
                         : std::pow(drive.voltage_V / nominal.nominal_voltage_V, truth.sag_exponent);
  const double steep = truth.curvature / nominal.hover_thrust_N();
  const Surroundings& around = truth.surroundings;
  Wrench sum;
  for (int i = 0; i < kRotors; ++i) {
    const Vec3 hub_B = nominal.hub_B_m[i] - truth.com_B_m;
    const Vec3 hub_air_B = air_B + m.rate_B_radps.cross(hub_B);
    const double speed = drive.speed_radps[i], tip_mps = speed * station_m;
    const BladeMeans mean = sweep(axis_B, nominal.spin[i], tip_mps, hub_air_B);
    const double plain_N = nominal.thrust_coefficient * speed * speed;
    double scaled_N =
        truth.thrust_scale * truth.rotor_gain[i] * sag * plain_N * (1 - truth.curvature + steep * plain_N);
    if (i == truth.outside.dropout_rotor) scaled_N *= drive.rotor_factor;
    scaled_N *= vortex_factor(truth.outside, m.velocity_W_mps.z());
    double thrust_N = scaled_N - lift * tip_mps * tip_mps + lift * mean.square - inflow * mean.cross;
    const double hub_z_m = m.com_W_m.z() + R.row(2).dot(hub_B);
    if (around.ground_z_m) thrust_N *= image_gain(truth.ground, nominal.radius_m, hub_z_m - *around.ground_z_m);
    if (around.ceiling_z_m) thrust_N *= image_gain(truth.ceiling, nominal.radius_m, *around.ceiling_z_m - hub_z_m);
    const Vec3 force_B = thrust_N * axis_B - drag * mean.pull_B;
    sum.force_B_N += force_B;
    sum.torque_B_Nm += hub_B.cross(force_B) - nominal.spin[i] * truth.torque_ratio_m * scaled_N * axis_B +
                       flapping * mean.pull_B.cross(axis_B);
  }
  if (truth.outside.trim_Nm != 0) {
    const double phase = 2 * std::numbers::pi * drive.time_s / truth.outside.trim_period_s;
    sum.torque_B_Nm +=
        truth.outside.trim_Nm * (std::sin(phase) + 0.6 * std::sin(1.7 * phase + 1)) * truth.outside.trim_axis_B;
  }
  return sum;
}

Vec3 fuselage_force_W(const Truth& truth, const Motion& m, double thrust_N) {
  // dynamic pressure along the flow, split into its part along body z and the rest
  const Vec3 air_W = m.velocity_W_mps - truth.wind_W_mps;
  const Vec3 up_W = m.attitude * Vec3::UnitZ();
  const Vec3 axial_W = air_W.dot(up_W) * up_W;
  Vec3 force_W =
      -0.5 * kAirDensity_kgpm3 * air_W.norm() * (truth.area_xy_m2 * (air_W - axial_W) + truth.area_z_m2 * axial_W);
  if (truth.surroundings.wall && truth.wall != 0) {
    const Wall& wall = *truth.surroundings.wall;
    const double away_m = std::max((m.com_W_m.head<2>() - wall.point_W_m).dot(wall.normal_W), truth.nominal.radius_m);
    const double pull_N = truth.wall * thrust_N * std::pow(truth.nominal.radius_m / away_m, 2);
    force_W.head<2>() -= pull_N * wall.normal_W;
  }
  const Outside& o = truth.outside;
  const Vec3 to_jet_W = (m.com_W_m - o.jet_center_W_m) / o.jet_radius_m;
  force_W += std::exp(-0.5 * to_jet_W.head<2>().squaredNorm()) * o.jet_force_W_N;
  const double climb_mps = std::max(0.0, m.velocity_W_mps.z());
  force_W.z() -= o.climb_drag * climb_mps * climb_mps;
  force_W += o.cross_force * Vec3(-m.velocity_W_mps.y(), m.velocity_W_mps.x(), 0);
  if (o.tether_npm > 0) {
    const Vec3 line_W = o.tether_W_m - m.com_W_m;
    const double pull_m = std::max(0.0, line_W.norm() - o.tether_slack_m);
    force_W += o.tether_npm * pull_m * line_W.normalized();
  }
  return force_W;
}

}  // namespace reality
