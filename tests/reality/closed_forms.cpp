#include "closed_forms.hpp"

#include "body.hpp"
#include "catalogue.hpp"
#include "check.hpp"
#include "flight.hpp"
#include "vehicle.hpp"

namespace reality {
namespace {

// a state in which everything moves, half a metre above ground, below a ceiling, beside a wall
struct Case {
  Truth plain;
  Motion m;
  Drive drive;
  Vec3 air_B;
  double hover_radps, hover_N, scale_N;

  explicit Case(bool large) {
    plain = as_nominal(nominal_vehicle(large, false));
    plain.surroundings = {0.0, 1.2, Wall{{-0.5, 0}, {1, 0}}};
    m.com_W_m = {0.1, -0.2, 0.5};
    m.velocity_W_mps = {1.1, -0.7, 0.4};
    m.rate_B_radps = {0.9, -1.3, 0.6};
    m.attitude = rotation(Vec3(0.2, -0.3, 1.1));
    hover_radps = plain.nominal.hover_speed_radps();
    hover_N = plain.nominal.hover_thrust_N();
    scale_N = 4 * hover_N;
    drive.speed_radps = {0.9 * hover_radps, 1.05 * hover_radps, 1.1 * hover_radps, 0.97 * hover_radps};
    drive.voltage_V = 0.93 * plain.nominal.nominal_voltage_V;
    drive.time_s = 7;
    air_B = m.attitude.conjugate() * m.velocity_W_mps;
  }
  Vec3 hub(int i) const { return plain.nominal.hub_B_m[i]; }
  Vec3 hub_air(int i) const { return air_B + m.rate_B_radps.cross(hub(i)); }
  double thrust(int i) const { return plain.nominal.thrust_coefficient * std::pow(drive.speed_radps[i], 2); }
  double spin(int i) const { return plain.nominal.spin[i]; }
  double ratio() const { return plain.nominal.torque_ratio_m; }
  double hub_height(int i) const { return m.com_W_m.z() + (m.attitude * hub(i)).z(); }

  // change of the wrench by an effect, against force and torque that the catalogue states
  void compare(const char* name, const Values& values, const Vec3& force_B, const Vec3& torque_B) const {
    Truth with = plain;
    plant(with, name, values);
    const Wrench a = wrench(with, m, drive), b = wrench(plain, m, drive);
    const double arm = hub(0).norm();
    const bool good =
        (a.force_B_N - b.force_B_N - force_B).norm() < 1e-12 * scale_N + 1e-9 * force_B.norm() &&
        (a.torque_B_Nm - b.torque_B_Nm - torque_B).norm() < 1e-12 * scale_N * arm + 1e-9 * torque_B.norm();
    EXPECT((force_B.norm() > 0 || torque_B.norm() > 0) && "the effect must act here");
    if (!good) std::cerr << name << ":\n";
    EXPECT(good);
  }
};

const Vec3 kUp = Vec3::UnitZ();

template <class F>
Vec3 total(F per_rotor) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < kRotors; ++i) sum += per_rotor(i);
  return sum;
}

void check_air(const Case& c, bool large) {
  const double k = large ? 0.5 : 0.015;
  const auto drag = [&](int i) {
    Vec3 flat = c.hub_air(i);
    flat.z() = 0;
    return Vec3(-k / (4 * c.hover_radps) * c.drive.speed_radps[i] * flat);
  };
  c.compare("rotor_drag", {{"at_hover", k}}, total(drag), total([&](int i) { return c.hub(i).cross(drag(i)); }));

  const double q = 0.5 * kAirDensity_kgpm3 * c.air_B.norm();
  c.compare("quadratic_drag", {{"area_xy", 0.02}, {"area_z", 0.03}}, -q * Vec3(0.02, 0.02, 0.03).cwiseProduct(c.air_B),
            Vec3::Zero());

  const auto along = [&](auto newton) {
    return std::pair{total([&](int i) { return Vec3(newton(i) * kUp); }),
                     total([&](int i) { return c.hub(i).cross(Vec3(newton(i) * kUp)); })};
  };
  const auto compare_thrusts = [&](const char* name, const Values& values, auto newton) {
    const auto [force, torque] = along(newton);
    c.compare(name, values, force, torque);
  };
  compare_thrusts("axial_inflow", {{"at_hover", k}},
                  [&](int i) { return -k / (4 * c.hover_radps) * c.drive.speed_radps[i] * c.hub_air(i).z(); });
  compare_thrusts("translational_lift", {{"coefficient", 2e-3}},
                  [&](int i) { return 2e-3 * c.hub_air(i).head<2>().squaredNorm(); });
  const double radius = c.plain.nominal.radius_m;
  compare_thrusts("ground_effect", {{"strength", 7}}, [&](int i) {
    return c.thrust(i) * 7 * std::pow(radius / (4 * std::max(radius, c.hub_height(i))), 2);
  });
  compare_thrusts("ceiling_effect", {{"strength", 7}}, [&](int i) {
    return c.thrust(i) * 7 * std::pow(radius / (4 * std::max(radius, 1.2 - c.hub_height(i))), 2);
  });

  // nose up when moving forward is a torque about -y
  const double f = large ? 1e-6 : 1e-7;
  c.compare("flapping_torque", {{"coefficient", f}}, Vec3::Zero(),
            total([&](int i) { return Vec3(f * c.drive.speed_radps[i] * c.hub_air(i).cross(kUp)); }));
  double thrust_sum = 0;
  for (int i = 0; i < kRotors; ++i) thrust_sum += c.thrust(i);
  c.compare("wall_effect", {{"strength", 0.04}},
            c.m.attitude.conjugate() * Vec3(-0.04 * thrust_sum * std::pow(radius / 0.6, 2), 0, 0), Vec3::Zero());
  const Vec3 push(0.3, -0.2, 0.1);
  c.compare("constant_force", {{"x", push.x()}, {"y", push.y()}, {"z", push.z()}}, c.m.attitude.conjugate() * push,
            Vec3::Zero());

  // wind is air that moves: the drag of the same vehicle at the difference of velocities
  Truth windy = c.plain, still = c.plain;
  windy.rotor_drag = still.rotor_drag = k;
  plant(windy, "steady_wind", {{"x", 0.8}, {"y", -0.5}, {"z", 0.1}});
  Motion slower = c.m;
  slower.velocity_W_mps -= Vec3(0.8, -0.5, 0.1);
  EXPECT((wrench(windy, c.m, c.drive).force_B_N - wrench(still, slower, c.drive).force_B_N).norm() < 1e-12 * c.scale_N);
}

void check_rotors(const Case& c) {
  // share of thrust and reaction torque that each rotor gains
  const auto compare_shares = [&](const char* name, const Values& values, auto share) {
    c.compare(name, values, total([&](int i) { return Vec3(share(i) * c.thrust(i) * kUp); }), total([&](int i) {
                return Vec3(share(i) * c.thrust(i) * (c.hub(i).cross(kUp) - c.spin(i) * c.ratio() * kUp));
              }));
  };
  compare_shares("thrust_scale", {{"delta", -0.07}}, [](int) { return -0.07; });
  compare_shares("rotor_loss", {{"rotor", 3}, {"loss", 0.1}}, [](int i) { return i == 2 ? -0.1 : 0.0; });
  compare_shares("thrust_curve", {{"curvature", 0.2}}, [&](int i) { return 0.2 * (c.thrust(i) / c.hover_N - 1); });
  compare_shares("battery_sag", {{"exponent", 1.5}}, [](int) { return std::pow(0.93, 1.5) - 1; });
  compare_shares("battery_sag", {{"rate", 0.004}}, [](int) { return -0.004 * 7; });
  c.compare("yaw_torque_ratio", {{"delta", 0.2}}, Vec3::Zero(),
            total([&](int i) { return Vec3(-0.2 * c.spin(i) * c.ratio() * c.thrust(i) * kUp); }));

  Truth tilted = c.plain;
  plant(tilted, "rotor_tilt", {{"x", 1e-5}, {"y", -2e-5}});
  const Vec3 n(1e-5, -2e-5, 1);
  const Wrench w = wrench(tilted, c.m, c.drive);
  const Vec3 force = total([&](int i) { return Vec3(c.thrust(i) * n); });
  const Vec3 torque = total([&](int i) { return Vec3(c.thrust(i) * (c.hub(i).cross(n) - c.spin(i) * c.ratio() * n)); });
  EXPECT((w.force_B_N - force).norm() < 1e-9 * c.scale_N);
  EXPECT((w.torque_B_Nm - torque).norm() < 1e-9 * c.scale_N);
}

void check_body(const Case& c) {
  Truth moved = c.plain;
  plant(moved, "center_of_mass", {{"x", 2e-3}, {"y", -1e-3}, {"z", 3e-3}});
  const Vec3 shift(2e-3, -1e-3, 3e-3);
  const Vec3 torque = wrench(moved, c.m, c.drive).torque_B_Nm - wrench(c.plain, c.m, c.drive).torque_B_Nm;
  EXPECT((torque + shift.cross(wrench(c.plain, c.m, c.drive).force_B_N)).norm() < 1e-12 * c.scale_N);

  Truth heavy = c.plain;
  plant(heavy, "mass", {{"delta", 0.1}});
  plant(heavy, "inertia", {{"delta_x", 0.1}, {"delta_y", -0.2}, {"delta_z", 0.3}});
  EXPECT_NEAR(heavy.mass_kg / c.plain.mass_kg, 1.1, 1e-12);
  EXPECT((heavy.inertia_kgm2.cwiseQuotient(c.plain.inertia_kgm2) - Vec3(1.1, 0.8, 1.3)).norm() < 1e-12);

  // reaction of spinning rotors: T_z -= sum s I dOmega/dt, T -= omega x sum s I Omega e3
  Truth spinning = c.plain;
  const double inertia = 1e-3 * c.plain.inertia_kgm2.z();
  plant(spinning, "rotor_inertia", {{"inertia", inertia}});
  const double step = 1e-4, ramp = 50;
  const auto drive_at = [&](double t) {
    Drive d = c.drive;
    for (int i = 0; i < kRotors; ++i) d.speed_radps[i] += c.spin(i) * ramp * t;
    return d;
  };
  const auto turn = [&](const Truth& t) {
    const State x = state_of(t, c.m, c.drive.speed_radps);
    const Drive end = drive_at(step);
    return Vec3((motion(t, advance(t, x, c.drive, drive_at(0.5 * step), end, step), end.speed_radps).rate_B_radps -
                 c.m.rate_B_radps) /
                step);
  };
  double momentum = 0;
  for (int i = 0; i < kRotors; ++i) momentum += c.spin(i) * inertia * c.drive.speed_radps[i];
  const Vec3 wanted = -(c.m.rate_B_radps.cross(Vec3(0, 0, momentum)) + Vec3(0, 0, 4 * inertia * ramp));
  const Vec3 got = (turn(spinning) - turn(c.plain)).cwiseProduct(c.plain.inertia_kgm2);
  EXPECT((got - wanted).norm() < 2e-3 * wanted.norm());
}

void check_sensors(const Case& c) {
  const Acceleration a{{0.4, -0.3, 9.9}, {3, -2, 5}};
  Truth t = c.plain;
  plant(t, "attitude_offset", {{"x", 0.02}, {"y", -0.01}});
  plant(t, "yaw_offset", {{"z", 0.03}});
  plant(t, "gyro_scale", {{"delta", 0.05}});
  plant(t, "imu_lever", {{"x", 0.01}, {"y", 0.02}, {"z", -0.03}});
  const Reading r = sense(t, c.m, a), plain = sense(c.plain, c.m, a);
  const Vec3 lever(0.01, 0.02, -0.03), &w = c.m.rate_B_radps;
  EXPECT((c.m.attitude.conjugate() * r.attitude).angularDistance(rotation(Vec3(0.02, -0.01, 0.03))) < 1e-7);
  EXPECT((r.gyro_B_radps - 1.05 * plain.gyro_B_radps).norm() < 1e-12);
  EXPECT((r.specific_B_mps2 - a.specific_B_mps2 - a.angular_B_radps2.cross(lever) - w.cross(w.cross(lever))).norm() <
         1e-12);
  Truth moved = c.plain;
  plant(moved, "center_of_mass", {{"x", 2e-3}});
  const Reading m = sense(moved, c.m, a);
  EXPECT((m.position_W_m - (c.m.com_W_m - c.m.attitude * Vec3(2e-3, 0, 0))).norm() < 1e-15);
  EXPECT((m.velocity_W_mps - (c.m.velocity_W_mps - c.m.attitude * w.cross(Vec3(2e-3, 0, 0)))).norm() < 1e-15);
}

}  // namespace

void check_closed_forms(bool large) {
  const Case c(large);
  check_air(c, large);
  check_rotors(c);
  check_body(c);
  check_sensors(c);
}

}  // namespace reality
