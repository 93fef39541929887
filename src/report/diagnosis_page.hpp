// report.html: a diagnosis on one page that needs nothing but a browser. No script, no external resource, no date.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gustlab {

// What a page draws beside the numbers of diagnosis.json. Everything is optional; an empty part is left out.
struct DiagnosisFigures {
  // One held-out window. NaN breaks a line, for example where an open-loop prediction starts anew.
  struct Trace {
    std::string name, unit;  // "position x", "m"
    std::vector<double> time_s, measured, before, after;
  };
  struct Window {
    std::string file;
    double restart_s = 0.0;  // predictions start from the recorded state this often; 0: only once
    std::vector<Trace> traces;
    std::vector<Trace> motors;  // recorded inputs over the same stretch ("rotor 1"), means of 0.1 s in `measured`
    std::string motor_unit;     // of the inputs, as the axis says it
  };
  Window window;

  // Smoothed unexplained force or torque against the variable that it depends on most.
  struct Residual {
    std::string channel, unit;                                        // "force_x", "N"
    std::string variable;                                             // "airspeed_mps"
    std::vector<double> x, y;                                         // blocks of the fit flights, before
    std::vector<double> bin_x, before_mean, before_low, before_high;  // 95 % intervals of the bin means
    std::vector<double> after_mean, after_low, after_high;
    std::string left_out;  // "12 blocks with saturated commands"; empty: nothing
  };
  std::vector<Residual> residuals;

  // Denser than the `fit` block, when it was computed; otherwise the page draws that.
  struct Horizon {
    std::string quantity;  // "position_m"
    std::vector<double> horizon_s, hold, before, after, noise;
    std::vector<double> before_low, before_high, after_low, after_high;
  };
  std::vector<Horizon> horizons;
  double weight_N = 0.0;         // of the vehicle file; 0: not known
  std::string windows_left_out;  // "3 windows across gaps"; empty: nothing
};

// Numbers that JSON has as null are shown as "–". All text is escaped.
std::string diagnosis_page(const nlohmann::ordered_json& diagnosis, const DiagnosisFigures& figures);

}  // namespace gustlab
