// Where a vehicle and its simulation differ: by hand for the means of half seconds, and for a vehicle that is heavier than its file.
#include "diagnosis/validation/locate.hpp"
#include "diagnosis/result/diagnosis.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "gustlab/random.hpp"
#include "support/flight_data.hpp"
#include "support/vehicles.hpp"

namespace gustlab::diagnosis {
namespace locate_test {

using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;

constexpr double sample_s = 0.02, pace_radps = 2.0;

// noise of the sensors on a motion that is known
FlightData with_noise(FlightData flight, std::uint32_t replicate) {
  const RandomStream random(8, replicate, "locate_test");
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    Sample& s = flight.samples[k];
    s.channels &= ~has_velocity;
    const auto p = random.normal4(k, 0), q = random.normal4(k, 1), w = random.normal4(k, 2);
    for (std::size_t i = 0; i < 3; ++i) {
      s.position_W_m[static_cast<Eigen::Index>(i)] += 1e-3 * p[i];
      s.body_rate_B_radps[static_cast<Eigen::Index>(i)] += 0.05 * w[i];
    }
    s.attitude_WB = s.attitude_WB * Quaternion(1.0, 1e-3 * q[0], 1e-3 * q[1], 1e-3 * q[2]).normalized();
  }
  return flight;
}

// Wanders about with this share of the thrust that its file asks for, and leans against a force per kg along x that comes and goes, which
// moves it a little. Rotors never stand still.
FlightData wandering(const VehicleModel& vehicle, double thrust_share, double force_mps2, std::uint32_t replicate) {
  const RandomStream random(9, replicate, "locate_test");
  const auto x_m = [=](double t) {
    return 0.4 * std::sin(0.9 * t) + 0.3 * std::sin(1.37 * t + 1.0 + replicate) -
           0.2 * force_mps2 / (pace_radps * pace_radps) * std::sin(pace_radps * t);
  };
  const auto acceleration = [=](double t) { return (x_m(t + 1e-3) - 2.0 * x_m(t) + x_m(t - 1e-3)) / 1e-6; };
  const auto lean_rad = [=](double t) {
    return std::atan((acceleration(t) - force_mps2 * std::sin(pace_radps * t)) / vehicle.gravity_mps2);
  };
  return with_noise(test::flight_of(
                        vehicle, 16.0, sample_s,
                        [&](double t) {
                          Motion m;
                          m.position_W_m = {x_m(t), 0.0, 1.0};
                          m.velocity_W_mps.x() = (x_m(t + 1e-3) - x_m(t - 1e-3)) / 2e-3;
                          m.acceleration_W_mps2.x() = acceleration(t);
                          m.attitude_WB = Quaternion(Eigen::AngleAxisd(lean_rad(t), Vector3::UnitY()));
                          m.body_rate_B_radps.y() = (lean_rad(t + 1e-3) - lean_rad(t - 1e-3)) / 2e-3;
                          return m;
                        },
                        [&](double t) {
                          const auto n = random.normal4(static_cast<std::uint64_t>(std::lround(t / sample_s)));
                          const double speed =
                              vehicle.hover_speed_radps() * std::sqrt(thrust_share / std::cos(lean_rad(t)));
                          RotorArray speeds{};
                          for (std::size_t i = 0; i < 4; ++i) speeds[i] = speed * (1.0 + 3e-4 * n[i]);
                          return speeds;
                        }),
                    replicate);
}

// its positions have an error along y that lasts
FlightData waving(FlightData flight, double error_y_m) {
  for (Sample& s : flight.samples) s.position_W_m.y() += error_y_m * std::sin(5.0 * s.time_s);
  return flight;
}

VehicleModel vehicle() {
  VehicleModel model = test::crazyflie();
  model.effects.clear();
  return model;
}

// two flights of which nothing was chosen, so that before and after are the same, under the noise of calm air or their own
struct NothingChosen {
  explicit NothingChosen(double thrust_share, double force_mps2 = 0.0, double error_y_m = 0.0)
      : session({waving(wandering(vehicle(), thrust_share, force_mps2, 1), error_y_m),
                 waving(wandering(vehicle(), thrust_share, force_mps2, 2), error_y_m)},
                vehicle(), 1) {
    static const NoiseModel calm = noise_of_calm();
    session.noise = calm;
    session.linearise(session.value(), session.all_columns());
    session.learn_noise(force_mps2 > 0.0 ? 10 : 1, session.biases());
    if (force_mps2 == 0.0) session.noise = calm;
    selection.value = session.value();
    selection.noise_nominal = selection.noise_selected = session.noise;
    selection.smoothed_nominal = selection.smoothed_selected = session.smoothed;
    selection.grams = session.grams();
    selection.degrees_of_freedom = selection.grams.rows;
    selection.loss_nominal = selection.loss_selected = solve(selection.grams.total(), session.biases()).loss;
  }
  static NoiseModel noise_of_calm() {
    Session session({wandering(vehicle(), 1.0, 0.0, 3)}, vehicle(), 1);
    session.linearise(session.value(), session.biases());
    session.search_noise(session.biases());
    session.learn_noise(10, session.biases());
    return session.noise;
  }
  Session session;
  Selection selection;
};

TEST(Blocks, AreMeansOfHalfSeconds) {
  VehicleModel model = vehicle();
  const Quaternion tilt(Eigen::AngleAxisd(0.3, Vector3::UnitY())), left(Eigen::AngleAxisd(pi / 2.0, Vector3::UnitZ()));
  FlightData flight = test::flight_of(
      model, 2.0, 0.01,
      [&](double t) {
        Motion m;
        m.position_W_m = Vector3(2.0 * t, -1.0, 1.0 + t);
        m.velocity_W_mps = Vector3(2.0, 0.0, 1.0);
        // tilted in the first half second alone, then to the left
        m.attitude_WB = t < 0.495 ? tilt : left;
        return m;
      },
      [&](double t) { return test::all_at(model.hover_speed_radps() * (t < 0.485 ? std::sqrt(0.5) : 1.0)); });
  flight.start_s = -3.0;
  flight.measured_speed = flight.commands;  // known from the first sample
  const Session session({flight}, model, 1);
  Smoothed smoothed;
  for (std::size_t k = 0; k < flight.samples.size(); ++k) {
    Eigen::Matrix<double, 6, 1> d;
    d << 1.0, 2.0, 3.0, 4.0, 5.0, 0.01 * static_cast<double>(k);
    smoothed.disturbance.push_back(d);
  }
  const Blocks found = blocks(session, {smoothed});
  ASSERT_EQ(found.wrench.size(), 3u);  // the first half second has no past
  const auto value = [&](std::size_t b, const char* variable) {
    const auto at = std::find(found.variable.begin(), found.variable.end(), variable) - found.variable.begin();
    return found.value[b][at];
  };
  for (std::size_t b = 0; b < 3; ++b) {
    const double middle_s = 0.745 + 0.5 * static_cast<double>(b);
    EXPECT_LT((found.wrench[b].head<3>() - model.mass_kg * Vector3(2.0, -1.0, 3.0)).norm(), 1e-12);
    EXPECT_NEAR(found.wrench[b][5], model.inertia_B_kgm2(2, 2) * middle_s, 1e-15);
    EXPECT_NEAR(value(b, "left_speed_mps"), -2.0, 1e-12);
    EXPECT_NEAR(value(b, "airspeed_mps"), std::sqrt(5.0), 1e-12);
    EXPECT_NEAR(value(b, "height_m"), 1.0 + middle_s, 1e-9);
    EXPECT_NEAR(value(b, "time_s"), middle_s + 3.0, 1e-9);
    // what reacts to a disturbance is that of half a second before
    EXPECT_NEAR(value(b, "forward_tilt_rad"), b == 0 ? std::sin(0.3) : 0.0, 1e-9);
    EXPECT_NEAR(value(b, "thrust_ratio"), b == 0 ? 0.5 : 1.0, 0.02);
  }
}

TEST(Locate, AHeavierVehicleDiffersInItsVerticalForceAlone) {
  NothingChosen heavy(1.05);
  const std::vector<Mismatch> found = locate(heavy.session, heavy.selection, {});
  ASSERT_EQ(found.size(), 8u);
  for (std::size_t c = 0; c < 6; ++c) EXPECT_EQ(found[c].significant, c == 2) << found[c].channel;
  EXPECT_LT(found[2].p_value, 1e-6);
  EXPECT_NEAR(found[2].rms, 0.05 * vehicle().weight_N(), 0.01 * vehicle().weight_N());
  EXPECT_EQ(found[2].unit, "N");
}

TEST(Locate, AnAlarmMarksItsChannels) {
  NothingChosen calm(1.0);
  Remainder rest;
  for (const Mismatch& m : locate(calm.session, calm.selection, rest)) EXPECT_FALSE(m.significant) << m.channel;
  rest.alarms.push_back({"omnibus", "", 0.0, {"torque_y"}});
  for (const Mismatch& m : locate(calm.session, calm.selection, rest))
    EXPECT_EQ(m.significant, m.channel == "torque_y") << m.channel;
}

Remainder remainder_of(const NothingChosen& set) {
  Remainder result = lasting_push(set.session, set.selection, false);
  ask_rest(set.session, set.selection, result);
  return result;
}

TEST(RemainderOfFlights, IsQuietWhereNothingIsLeft) {
  const NothingChosen calm(1.0);
  const Remainder rest = remainder_of(calm);
  for (const Alarm& alarm : rest.alarms) ADD_FAILURE() << alarm.says << " " << alarm.size;
  EXPECT_FALSE(rest.gust_like || rest.names_gust);
  EXPECT_EQ(rest.omnibus_share, 0.0);
}

// an error of a position that lasts 0.2 s is no white noise: the alarm says of which sensor
TEST(RemainderOfFlights, SaysOfWhichSensorTheInnovationsAreCorrelated) {
  const NothingChosen waving(1.0, 0.0, 0.01);
  const Remainder rest = remainder_of(waving);
  std::vector<std::string> sensors;
  for (const Alarm& alarm : rest.alarms) {
    EXPECT_EQ(alarm.sensor.empty(), alarm.kind != "whiteness") << alarm.says;
    if (alarm.kind != "whiteness") continue;
    sensors.push_back(alarm.sensor);
    EXPECT_THAT(alarm.says, HasSubstr(alarm.sensor));
  }
  EXPECT_THAT(sensors, Contains("position y"));
  Diagnosis d;
  d.alarms = {{"whiteness", "", 0.0, {"force_y"}, "position y"}, {"omnibus", "", 0.0, {}}};
  EXPECT_EQ(to_json(d)["alarms"][0]["sensor"], "position y");
  EXPECT_FALSE(to_json(d)["alarms"][1].contains("sensor"));
}

// thrust that is a fifth short shows in the generic bases, in the channel of the vertical force, and is no gust
TEST(RemainderOfFlights, SaysInWhichChannelSomethingIsLeft) {
  const NothingChosen heavy(1.2);
  const Remainder rest = remainder_of(heavy);
  EXPECT_FALSE(rest.names_gust);
  EXPECT_EQ(rest.omnibus_share, 1.0);  // nothing was explained
  std::vector<std::string> channels;
  for (const Alarm& alarm : rest.alarms)
    if (alarm.kind == "omnibus") channels.insert(channels.end(), alarm.channels.begin(), alarm.channels.end());
  EXPECT_THAT(channels, Contains("force_z"));
  EXPECT_THAT(channels, Each("force_z"));
}

// a force that comes and goes three times in ten seconds
TEST(RemainderOfFlights, AForceOfOneFrequencyIsAGustOfThatLine) {
  constexpr double force_mps2 = 0.6;
  const NothingChosen blown(1.0, force_mps2);
  const Remainder rest = remainder_of(blown);
  EXPECT_NEAR(rest.gust.line_radps, pace_radps, 0.05);
  EXPECT_NEAR(rest.gust.line_mps2, force_mps2 / std::sqrt(2.0), 0.05);  // root mean square of both axes
  EXPECT_TRUE(rest.names_gust);
  EXPECT_FALSE(lasting_push(blown.session, blown.selection, true).gust_like) << "after a force was withdrawn";
}

}  // namespace locate_test
}  // namespace gustlab::diagnosis
