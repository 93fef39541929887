// Making effects and setting their parameters by name.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <initializer_list>
#include <map>
#include <string>

#include "gustlab/effect.hpp"
#include "support/vehicles.hpp"

namespace gustlab::test {

// nominal vehicles whose centre of mass is in no special place
inline VehicleModel lopsided(VehicleModel vehicle, double nominal_voltage_V) {
  vehicle.center_of_mass_B_m = Vector3(0.01, -0.02, 0.05) * vehicle.arm_m();
  vehicle.nominal_voltage_V = nominal_voltage_V;
  return vehicle;
}
inline VehicleModel small_quadrotor() { return lopsided(crazyflie(), 3.8); }
inline VehicleModel large_quadrotor() { return lopsided(iris(), 12.6); }

// One declared parameter that is a number; integers and flags are passed as what they are worth.
struct Declared {
  std::string name;
  double value;
  ParameterInfo info;
};

// Visits every scalar: `use` may change the value, which is written back.
class ScalarVisitor final : public ParameterVisitor {
 public:
  using Use = std::function<void(Declared&)>;
  explicit ScalarVisitor(Use use) : use_(std::move(use)) {}

  void number(std::string_view name, double& value, const ParameterInfo& info) override {
    value = pass(name, value, info);
  }
  void integer(std::string_view name, std::int64_t& value, const ParameterInfo& info) override {
    value = static_cast<std::int64_t>(pass(name, static_cast<double>(value), info));
  }
  void flag(std::string_view name, bool& value, const ParameterInfo& info) override {
    value = pass(name, value ? 1.0 : 0.0, info) != 0.0;
  }
  void vector(std::string_view name, Vector3& value, const ParameterInfo& info) override {
    for (int i = 0; i < 3; ++i) value[i] = pass(std::string(name) + "." + "xyz"[i], value[i], info);
  }
  void text(std::string_view, std::string&, const ParameterInfo&) override {}
  void numbers(std::string_view, std::vector<double>&, const ParameterInfo&) override {}
  void texts(std::string_view, std::vector<std::string>&, const ParameterInfo&) override {}

 private:
  double pass(std::string_view name, double value, const ParameterInfo& info) {
    Declared declared{std::string(name), value, info};
    use_(declared);
    return declared.value;
  }

  Use use_;
};

using Values = std::map<std::string, double>;

inline void set(Effect& effect, const Values& values) {
  std::size_t found = 0;
  ScalarVisitor visitor([&](Declared& parameter) {
    if (const auto it = values.find(parameter.name); it != values.end()) parameter.value = it->second, ++found;
  });
  effect.visit(visitor);
  EXPECT_EQ(found, values.size()) << "a parameter of the test does not exist";
}

inline std::vector<Declared> parameters_of(Effect& effect) {
  std::vector<Declared> result;
  ScalarVisitor visitor([&](Declared& parameter) { result.push_back(parameter); });
  effect.visit(visitor);
  return result;
}

inline NamedEffect make_effect(const EffectRow& row, const Values& values = {}) {
  NamedEffect named{&row, row.make()};
  set(*named.effect, values);
  return named;
}

inline NamedEffect make_effect(std::string_view name, const Values& values = {}) {
  const EffectRow* row = find_effect(name);
  if (row == nullptr) throw std::invalid_argument(std::string(name));
  return make_effect(*row, values);
}

struct Wanted {
  std::string_view name;
  Values values;
};

inline std::vector<NamedEffect> make_effect_list(const std::vector<Wanted>& wanted) {
  std::vector<NamedEffect> effects;
  for (const Wanted& w : wanted) effects.push_back(make_effect(w.name, w.values));
  return effects;
}

}  // namespace gustlab::test
