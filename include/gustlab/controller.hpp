// A controller turns what it may see and where it should be into rotor speeds.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "gustlab/parameters.hpp"
#include "gustlab/types.hpp"
#include "gustlab/vehicle.hpp"

namespace gustlab {

// What a controller knows of its vehicle: the nominal model, and the period of its update.
struct ControllerSetup {
  VehicleModel vehicle;
  double period_s = 0.002;
};

// One object per run, no statics. update() runs at the base rate; slower loops divide it.
class Controller : public Parameterized {
 public:
  // Base rate at which update() must be called for this vehicle, Hz.
  virtual double rate_hz(const VehicleModel& vehicle) const = 0;
  // Throws ParameterError, for example when a slower loop's rate does not divide the base rate.
  virtual void reset(const ControllerSetup& setup, const Observation& first) = 0;
  virtual RotorCommand update(const Observation& observation, const Reference& reference) = 0;
  // Whether update() reads the accelerometer, which costs the plant one more evaluation.
  virtual bool uses_accelerometer() const { return false; }
  // Named internal values for the log (for example the estimated force); the names are fixed after reset().
  virtual std::vector<std::string_view> telemetry_names() const { return {}; }
  virtual void telemetry(std::span<double>) const {}
};

struct ControllerRow {
  std::string_view name;
  std::string_view says;
  std::string_view source;
  std::unique_ptr<Controller> (*make)();
};

std::span<const ControllerRow> controller_registry();
const ControllerRow* find_controller(std::string_view name);

}  // namespace gustlab
