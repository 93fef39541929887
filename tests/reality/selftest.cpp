// the reality against physics that is known in closed form
#include <filesystem>
#include <fstream>
#include <iterator>

#include "check.hpp"
#include "closed_forms.hpp"
#include "draw.hpp"
#include "limit.hpp"
#include "log.hpp"
#include "sha256.hpp"
#include "vehicle.hpp"

namespace reality {
namespace {

const PerRotor kStill{0, 0, 0, 0};

State fly_free(const Truth& truth, State x, const Drive& drive, double seconds, double step_s) {
  for (int i = 0; i < std::lround(seconds / step_s); ++i) x = advance(truth, x, drive, drive, drive, step_s);
  return x;
}

void check_free_fall() {
  const Truth t = as_nominal(nominal_vehicle(false, false));
  Motion m{{0, 0, 10}, {1, 2, 3}, {4, -3, 5}, rotation(Vec3(0.3, 0.1, -0.2))};
  const State start = state_of(t, m, kStill);
  const State x = fly_free(t, start, {}, 1.0, 1e-3);
  const Motion end = motion(t, x, kStill);
  EXPECT((end.com_W_m - Vec3(1, 2, 13 - 0.5 * kGravity_mps2)).norm() < 1e-9);
  EXPECT((end.velocity_W_mps - Vec3(1, 2, 3 - kGravity_mps2)).norm() < 1e-9);
  // momentum is a state, so it is exact; energy must follow
  const auto energy = [&](const Motion& a) { return a.rate_B_radps.dot(t.inertia_kgm2.cwiseProduct(a.rate_B_radps)); };
  EXPECT((x.segment<3>(10) - start.segment<3>(10)).norm() < 1e-18);
  EXPECT_NEAR(energy(end) / energy(m), 1, 1e-9);
}

void check_hover(bool large) {
  const Truth t = as_nominal(nominal_vehicle(large, false));
  const double hover = t.nominal.hover_speed_radps();
  Drive d;
  d.speed_radps = {hover, hover, hover, hover};
  const State x =
      fly_free(t, state_of(t, {{0, 0, 1}, Vec3::Zero(), Vec3::Zero(), Quat::Identity()}, d.speed_radps), d, 2, 1e-3);
  const Motion m = motion(t, x, d.speed_radps);
  EXPECT((m.com_W_m - Vec3(0, 0, 1)).norm() < 1e-9);
  EXPECT(m.rate_B_radps.norm() < 1e-9);
}

void check_rotor_chain() {
  Truth t = as_nominal(nominal_vehicle(false, false));
  t.lag_up_s = 0.04;
  t.lag_down_s = 0.06;
  t.delay_s = 0.013;
  const CommandTape tape{{0.0, 0.2}, {{2000, 1000, 1500, 1500}, {1500, 1500, 1500, 1500}}};
  RotorChain chain(t, {1500, 1500, 1500, 1500});
  EXPECT_NEAR(chain.at(0.0129, tape)[0], 1500, 1e-9);
  const PerRotor speed = chain.at(0.1, tape);
  EXPECT_NEAR(speed[0], 2000 - 500 * std::exp(-0.087 / 0.04), 1e-9);
  EXPECT_NEAR(speed[1], 1000 + 500 * std::exp(-0.087 / 0.06), 1e-9);
  t.max_speed_radps = 1800;
  RotorChain clipped(t, {1500, 1500, 1500, 1500});
  EXPECT_NEAR(clipped.at(0.2, tape)[0], 1800 - 300 * std::exp(-0.187 / 0.04), 1e-9);
}

void check_slung_load() {
  // without thrust: momentum of both falls with gravity, energy stays, the cable keeps its length
  Truth t = as_nominal(nominal_vehicle(false, false));
  t.load_kg = 0.006;
  t.load_length_m = 0.3;
  t.hook_damping = 0;
  const State start = [&] {
    State x = state_of(t, {{0, 0, 5}, Vec3::Zero(), Vec3::Zero(), Quat::Identity()}, kStill);
    x[16] = 1.5;
    return x;
  }();
  const State x = fly_free(t, start, {}, 0.8, 5e-4);
  const auto momentum = [&](const State& a) { return Vec3(a.segment<3>(3) + t.load_kg * a.segment<3>(16)); };
  const auto energy = [&](const State& a) {
    return a.segment<3>(3).squaredNorm() / (2 * t.mass_kg) + 0.5 * t.load_kg * a.segment<3>(16).squaredNorm() +
           kGravity_mps2 * (t.mass_kg * a[2] + t.load_kg * a[15]);
  };
  const Vec3 gained = momentum(x) - momentum(start);
  EXPECT((gained - Vec3(0, 0, -0.8 * kGravity_mps2 * (t.mass_kg + t.load_kg))).norm() < 1e-5);
  EXPECT_NEAR(energy(x), energy(start), 1e-5 * std::abs(energy(start)));
  EXPECT_NEAR((x.segment<3>(13) - x.segment<3>(0)).norm(), 0.3, 1e-9);
  EXPECT(std::abs(x[3]) > 1e-3);
}

void check_numbers() {
  Rng rng(1, 2, 3);
  double mean = 0, square = 0, fourth = 0;
  const int count = 200000;
  for (int i = 0; i < count; ++i) {
    const double x = rng.normal();
    mean += x / count;
    square += x * x / count;
    fourth += x * x * x * x / count;
  }
  EXPECT_NEAR(mean, 0, 0.01);
  EXPECT_NEAR(square, 1, 0.02);
  EXPECT_NEAR(fourth, 3, 0.1);
  Wander w(2.0, 0.15, rng);
  double variance = 0, lagged = 0, last = w.value();
  for (int i = 0; i < count; ++i) {
    w.advance(0.03, rng);
    variance += w.value() * w.value() / count;
    lagged += w.value() * last / count;
    last = w.value();
  }
  EXPECT_NEAR(variance, 4, 0.15);
  EXPECT_NEAR(lagged / variance, std::exp(-0.2), 0.01);
  EXPECT(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

struct Hover {
  Truth truth;
  Noise noise;
  Path path;
  explicit Hover(bool large) {
    truth = as_nominal(nominal_vehicle(large, false));
    noise = noise_level(large, 1);
    path.position_W_m = [](double t) { return Vec3(0.8 * std::sin(0.9 * t), 0.8 * std::sin(0.7 * t), 1); };
    path.yaw_rad = [](double t) { return 0.3 * t; };
    path.shake_radps2 = [](double) { return Vec3(0, 0, 0); };
    path.surge_mps2 = [](double) { return 0.0; };
  }
};

// without drag, nothing but the air pushes across the thrust
void check_air() {
  for (const AirKind kind : {AirKind::steady, AirKind::gusty, AirKind::outdoor}) {
    Hover h(false);
    set_air(h.noise, false, 4, kind);
    h.noise.accel_mps2 = h.noise.accel_bias_mps2 = 0;
    double square = 0, fourth = 0, step = 0, count = 0;
    for (std::uint64_t trial = 0; trial < 6; ++trial) {
      const Flight f = fly(h.truth, h.path, h.noise, 5, trial, 0);
      EXPECT(!f.lost);
      for (std::size_t k = 1; k < f.sample.size(); ++k) {
        const double x = f.sample[k].reading.specific_B_mps2.x(), before = f.sample[k - 1].reading.specific_B_mps2.x();
        square += x * x;
        fourth += std::pow(x, 4);
        step += std::pow(x - before, 2);
        ++count;
      }
    }
    EXPECT_NEAR(std::sqrt(square / count), 4 * 0.07, kind == AirKind::steady ? 0.02 : 0.06);
    EXPECT((fourth * count / (square * square) > 4) == (kind == AirKind::gusty));
    EXPECT((step / square < 0.08) == (kind == AirKind::outdoor));
  }
}

void check_readings() {
  Hover h(false);
  h.truth.pose_delay_s = 0.02;
  const Flight f = fly(h.truth, h.path, h.noise, 4, 5, 6);
  EXPECT(!f.lost && f.sample.size() == 2500);
  double position = 0, attitude = 0;
  Vec3 gyro = Vec3::Zero(), gyro_square = Vec3::Zero();
  for (std::size_t k = 2; k < f.sample.size(); ++k) {
    const Reading& r = f.sample[k].reading;
    const Motion& then = f.sample[k - 2].clean;
    position += (r.position_W_m - then.com_W_m).squaredNorm() / (3 * 2498.0);
    attitude += std::pow(r.attitude.angularDistance(then.attitude), 2) / (3 * 2498.0);
    const Vec3 off = r.gyro_B_radps - f.sample[k].clean.rate_B_radps;
    gyro += off / 2498.0;
    gyro_square += off.cwiseAbs2() / 2498.0;
  }
  EXPECT_NEAR(std::sqrt(position), h.noise.position_m, 0.05 * h.noise.position_m);
  EXPECT_NEAR(std::sqrt(attitude), h.noise.attitude_rad, 0.05 * h.noise.attitude_rad);
  EXPECT_NEAR(std::sqrt((gyro_square - gyro.cwiseAbs2()).mean()), h.noise.gyro_radps, 0.05 * h.noise.gyro_radps);
}

void check_information() {
  // a constant force against turbulence: its information is duration over the spectrum at zero
  Hover h(true);
  Scene scene;
  scene.noise = h.noise;
  scene.base = {h.truth};
  scene.flight.push_back(fly(h.truth, h.path, h.noise, 7, 8, 9));
  const Plan plan{"constant_force", {{{"z", 1.0}}}, {}};
  const Limit limit = detection_limit(plan, scene, {});
  const double spectrum = 2 * std::pow(h.noise.air_mps2, 2) * h.noise.air_time_s;
  const double natural_mps2 = 0.5 / h.truth.mass_kg;
  const double sigma = std::sqrt(spectrum / kFlight_s) / natural_mps2;
  EXPECT_NEAR(limit.five_sigma / (5 * sigma), 1, 0.03);
  EXPECT_NEAR(limit.materiality / limit.five_sigma, std::sqrt(0.0025 * measurements(scene) / 25), 1e-9);
}

// a load on a large vehicle that no pilot carries along any of its sixteen paths: another one is drawn
void check_redraw() {
  Request request;
  request.seed = 41;
  request.effect = "slung_load";
  request.factor = 10;
  request.large = true;
  const Trial trial = draw_trial(request, 10);
  EXPECT(trial.answer["redraws"] == 1 && trial.answer["effects"][0]["effect"] == "slung_load");
  EXPECT(std::none_of(trial.flight.begin(), trial.flight.end(), [](const Flight& f) { return f.lost; }));
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void check_trials() {
  Request request;
  request.seed = 77;
  request.effect = "rotor_loss";
  request.factor = 5;
  const Trial trial = draw_trial(request, 3), again = draw_trial(request, 3), other = draw_trial(request, 4);
  EXPECT(trial.answer == again.answer && trial.answer != other.answer);
  EXPECT(trial.flight.size() == kFitFlights + 1);
  EXPECT_NEAR(trial.answer["effects"][0]["strength_over_limit"].get<double>(), 5, 1e-9);
  const auto& horizon = trial.answer["oracle"]["attitude_rad"];
  EXPECT(horizon["after"][1].get<double>() < horizon["before"][1].get<double>());

  const auto folder =
      std::filesystem::temp_directory_path() / ("reality_selftest_" + sha256(trial.answer.dump()).substr(0, 12));
  std::filesystem::create_directories(folder);
  write_log(trial.flight[0], trial.surroundings, trial.columns, "../vehicles/x/vehicle.toml", folder / "fit_1.csv");
  write_log(again.flight[0], again.surroundings, again.columns, "../vehicles/x/vehicle.toml", folder / "again.csv");
  const std::string log = text_of(folder / "fit_1.csv"), sidecar = text_of(folder / "fit_1.meta.toml");
  EXPECT(log == text_of(folder / "again.csv"));
  EXPECT(log.starts_with("time_s,px,py,pz,") && std::count(log.begin(), log.end(), '\n') == 2501);
  // the recording says nothing of what is concealed
  for (const Effect& e : catalogue())
    if (e.name != "gust") EXPECT((log + sidecar).find(e.name) == std::string::npos);  // gustlab is the format's name
  EXPECT((log + sidecar).find(",tx") == std::string::npos);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace reality

int main() {
  using namespace reality;
  for (const bool large : {false, true}) {
    check_closed_forms(large);
    check_hover(large);
  }
  check_free_fall();
  check_rotor_chain();
  check_slung_load();
  check_numbers();
  check_air();
  check_readings();
  check_information();
  check_trials();
  check_redraw();
  std::cout << (failures ? "failed: " : "all good, failures: ") << failures << "\n";
  return failures ? 1 : 0;
}
