// A program of your own on top of gustlab: hovers a vehicle with the PD law below and prints where it is after five seconds.
// usage: hover [VEHICLE]    a name under models/ or a path to a vehicle.toml
#include <cstdio>

#include "control/attitude.hpp"
#include "control/rotors.hpp"
#include "gustlab/errors.hpp"
#include "plant/plant.hpp"
#include "simulation/make_effects.hpp"
#include "vehicle/read_vehicle.hpp"

using namespace gustlab;

int main(int argc, char** argv) {
  try {
    const VehicleModel vehicle = read_vehicle(argc > 1 ? argv[1] : "crazyflie");
    const Mixer mixer(vehicle);
    Plant plant(vehicle, make_effects(vehicle.effects), {.step_s = 0.001});
    VehicleState start;
    start.position_W_m = {0.0, 0.0, 1.0};
    start.rotor_speed_radps.fill(vehicle.hover_speed_radps());
    plant.reset(start);

    const Vector3 target_W_m(0.5, 0.0, 1.5);
    for (int step = 0; step < 5000; ++step) {
      const VehicleState& s = plant.state();
      // an acceleration in the world, the thrust along it, and a torque that turns the vehicle there
      const Vector3 wanted_mps2 =
          4.0 * (target_W_m - s.position_W_m) - 4.0 * s.velocity_W_mps + Vector3(0.0, 0.0, vehicle.gravity_mps2);
      const Quaternion wanted_WB = Quaternion::FromTwoVectors(Vector3::UnitZ(), wanted_mps2);
      const Vector3 error_rad = attitude_error_B_rad(s.attitude_WB, wanted_WB, 1.0);
      const Vector3 torque_Nm = vehicle.inertia_B_kgm2 * (200.0 * error_rad - 25.0 * s.body_rate_B_radps);
      if (!plant.step(mixer.speeds(vehicle.mass_kg * wanted_mps2.norm(), torque_Nm))) return 1;
    }
    const Vector3 p = plant.state().position_W_m;
    std::printf("%s is at (%.3f, %.3f, %.3f) m after %.1f s\n", vehicle.name.c_str(), p.x(), p.y(), p.z(),
                plant.state().time_s);
  } catch (const UserError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return error.exit_code();
  }
}
