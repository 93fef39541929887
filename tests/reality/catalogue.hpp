// the contract's effects: names, parameters, units and sizes of DIAGNOSIS.md, planted into a truth
#pragma once

#include <map>
#include <string>
#include <vector>

#include "truth.hpp"

namespace reality {

using Values = std::map<std::string, double>;

/// One parameter of an effect; pairs are {small vehicle, large vehicle}.
struct Parameter {
  std::string name;
  double natural[2];    // typical size
  double tolerance[2];  // below it a value is calibration, not physics; 0: none stated
};

enum class Need { nothing, drag, ground, ceiling, wall, voltage, accel };

struct Effect {
  std::string name;
  std::vector<Parameter> parameter;
  double most;  // largest strength in natural sizes that still flies
  bool both_signs;
  Need need = Need::nothing;
  bool whole_vehicle = true;  // false: one value per flight
};

/// Every effect whose strength scales parameters along a direction. rotor_loss, saturation, gust and slung_load bring
/// further numbers that are drawn, not scaled.
const std::vector<Effect>& catalogue();
const Effect& effect(const std::string& name);

/// Value that the nominal vehicle already has (total = nominal + strength x direction x natural).
double nominal_value(const Nominal& nominal, const std::string& effect, const std::string& parameter);

/// Gives the truth these total values; parameters that are not named keep theirs.
void plant(Truth& truth, const std::string& effect, const Values& values);

}  // namespace reality
