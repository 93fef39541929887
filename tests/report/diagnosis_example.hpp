// A diagnosis as a page would get it, with made-up numbers.
#pragma once

#include <cmath>
#include <fstream>
#include <limits>
#include <string>

#include "report/diagnosis_page.hpp"

namespace gustlab {

inline nlohmann::ordered_json example_diagnosis() {
  return nlohmann::ordered_json::parse(std::ifstream("tests/report/diagnosis_example.json"));
}

inline DiagnosisFigures example_figures() {
  DiagnosisFigures figures;
  figures.window.file = "lemniscate.csv";
  figures.window.restart_s = 1.0;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const char* names[] = {"position x", "position y", "position z", "roll", "pitch", "yaw"};
  for (int n = 0; n < 6; ++n) {
    DiagnosisFigures::Trace trace{names[n], n < 3 ? "m" : "rad", {}, {}, {}, {}};
    for (int i = 0; i < 400; ++i) {
      const double t = 0.01 * i, since = std::fmod(t, 1.0), size = n >= 3 ? 0.3 : 1.0;
      trace.time_s.push_back(12.0 + t);
      const double y = size * std::sin(1.7 * t + n) + 0.01 * std::sin(40.0 * t + n);
      trace.measured.push_back(y);
      const bool start = i % 100 == 0;
      trace.before.push_back(start ? nan : y + 0.3 * size * since * since);
      trace.after.push_back(start ? nan : y + 0.04 * size * since * since);
    }
    figures.window.traces.push_back(trace);
  }
  figures.window.motor_unit = "rad/s";
  for (int i = 0; i < 4; ++i) {
    DiagnosisFigures::Trace motor{
        "rotor " + std::to_string(i + 1), "rad/s", figures.window.traces.front().time_s, {}, {}, {}};
    for (const double t : motor.time_s) motor.measured.push_back(2300.0 + 40.0 * i + 60.0 * std::sin(3.0 * t + i));
    figures.window.motors.push_back(motor);
  }
  figures.weight_N = 0.265;
  DiagnosisFigures::Residual residual{
      "force_x", "N", "airspeed_mps", {}, {}, {}, {}, {}, {}, {}, {}, {}, "12 blocks with saturated commands"};
  for (int i = 0; i < 150; ++i) {
    residual.x.push_back(1.5 * std::fmod(0.618 * i, 1.0));
    residual.y.push_back(-0.0147 * residual.x.back() + 0.003 * std::sin(7.1 * i));
  }
  for (int b = 0; b < 8; ++b) {
    residual.bin_x.push_back(0.1 + 0.18 * b);
    residual.before_mean.push_back(-0.0147 * residual.bin_x.back());
    residual.before_low.push_back(residual.before_mean.back() - 0.001);
    residual.before_high.push_back(residual.before_mean.back() + 0.001);
    residual.after_mean.push_back(0.0004 * std::cos(3.0 * b));
    residual.after_low.push_back(residual.after_mean.back() - 0.0008);
    residual.after_high.push_back(residual.after_mean.back() + 0.0008);
  }
  figures.residuals.push_back(residual);
  figures.windows_left_out = "3 windows across gaps";
  return figures;
}

}  // namespace gustlab
