// Parameters are declared once, by a visitor over the struct that holds them.
//
// One declaration serves reading TOML, `gustlab defaults`, range checks, the canonical text of a run key, the tables of
// the docs, and the diagnosis, which perturbs and fits the very same values.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gustlab/types.hpp"

namespace gustlab {

// What a vehicle's size is multiplied with to give a parameter's natural size and tolerance.
enum class Scale {
  one,                     // the number itself
  weight,                  // m g, N
  arm,                     // mean horizontal distance of the hubs from the centre of mass, m
  rotor_torque_per_speed,  // m g · arm / sum of hover speeds, N m/(rad/s)
  yaw_inertia,             // J_zz, kg m²
  weight_per_inflow,       // m g over the speed that rotors induce at hover (momentum theory), N s/m; 0: radius unknown
};

// When a number of an effect is a column of the diagnosis.
enum class Fitted {
  always,
  with_voltage,     // only where the logs tell the battery's voltage
  without_voltage,  // only where they do not
  unless_negative,  // negative: as the number before it, until logs tell the two apart
  never             // found by a scan beforehand, or left as it is
};

struct ParameterInfo {
  std::string_view unit = "-";
  std::string_view help = "";
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  // what the diagnosis needs: a typical size (0: the simulator's only, never fitted) and the strength below which it is
  // calibration, not missing physics
  double natural = 1.0;
  double tolerance = 0.0;
  Scale scale = Scale::one;
  // what is larger either way would be seen without any flight (0: the bounds above hold for a fit, too)
  double plausible = 0.0;
  std::optional<double> plausible_from = std::nullopt;  // if not from −plausible
  std::optional<Scale> plausible_scale = std::nullopt;  // if not the scale of the size
  // Beforehand the vehicle file is wrong by this much (standard deviation, × scale); 0: nothing is known of it.
  double known_to = 0.0;
  // the tolerance where the logged attitude is an estimate, which follows the sensor that it is compared with
  double estimate_tolerance = 0.0;
  Fitted fitted = Fitted::always;
};

// A file that a parameter names. Its bytes, not its place, are part of a run's key.
struct InputFile {
  std::string path;   // as written; once read, where it was found
  std::string bytes;  // empty: not named
};

class ParameterVisitor {
 public:
  virtual ~ParameterVisitor() = default;
  virtual void number(std::string_view name, double& value, const ParameterInfo& info) = 0;
  virtual void integer(std::string_view name, std::int64_t& value, const ParameterInfo& info) = 0;
  virtual void flag(std::string_view name, bool& value, const ParameterInfo& info) = 0;
  virtual void text(std::string_view name, std::string& value, const ParameterInfo& info) = 0;
  virtual void numbers(std::string_view name, std::vector<double>& value, const ParameterInfo& info) = 0;
  virtual void texts(std::string_view name, std::vector<std::string>& value, const ParameterInfo& info) = 0;
  // three numbers of one meaning, written as an array [x, y, z]
  virtual void vector(std::string_view name, Vector3& value, const ParameterInfo& info) = 0;
  // a visitor that does not know of files sees the path
  virtual void file(std::string_view name, InputFile& value, const ParameterInfo& info) {
    text(name, value.path, info);
  }
};

// Anything with declared parameters.
class Parameterized {
 public:
  virtual ~Parameterized() = default;
  virtual void visit(ParameterVisitor& visitor) = 0;
};

}  // namespace gustlab
