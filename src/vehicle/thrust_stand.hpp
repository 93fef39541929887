// Constants of a rotor from measurements on a thrust stand.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "gustlab/vehicle.hpp"

namespace gustlab {

// A number with its standard deviation.
struct Estimate {
  double value = 0.0, deviation = 0.0;
};

struct ThrustStand {
  std::optional<Estimate> coefficient_Ns2;            // thrust = coefficient Ω²
  std::optional<Estimate> torque_ratio_m;             // torque = ratio × thrust
  std::string input;                                  // throttle | pwm; empty: none was measured
  std::optional<std::array<double, 3>> input_thrust;  // f = c0 + c1 u + c2 u² at the nominal voltage, N
  std::optional<Estimate> voltage_exponent;           // f goes with this power of the voltage
  std::optional<double> nominal_voltage_V;            // mean of the rows
  double thrust_misfit_N = 0.0;                       // rms of the best map's residual
  std::size_t rows = 0;
  std::vector<std::string> unknown;  // what was not measured, or not varied

  [[nodiscard]] double full_input() const { return input == "pwm" ? full_pwm : 1.0; }
};

// Columns: thrust_N | thrust_gf | thrust_kgf, and any of torque_Nm, speed_radps | speed_rpm, voltage_V, and throttle (0..1) |
// pwm (0..65535) | pulse_us (1000..2000, read as throttle). Throws DataError with file:line:col.
ThrustStand read_thrust_stand(const std::string& csv_path);

}  // namespace gustlab
