#include "simulation/setting_units.hpp"

#include <algorithm>

#include "gustlab/controller.hpp"
#include "gustlab/effect.hpp"
#include "gustlab/trajectory.hpp"

namespace gustlab {

namespace {

class UnitOf final : public ParameterVisitor {
 public:
  explicit UnitOf(std::string_view wanted) : wanted_(wanted) {}
  void number(std::string_view name, double&, const ParameterInfo& info) override { look(name, info); }
  void integer(std::string_view name, std::int64_t&, const ParameterInfo& info) override { look(name, info); }
  void flag(std::string_view, bool&, const ParameterInfo&) override {}
  void text(std::string_view, std::string&, const ParameterInfo&) override {}
  void numbers(std::string_view name, std::vector<double>&, const ParameterInfo& info) override { look(name, info); }
  void texts(std::string_view, std::vector<std::string>&, const ParameterInfo&) override {}
  void vector(std::string_view name, Vector3&, const ParameterInfo& info) override { look(name, info); }

  std::string unit;

 private:
  void look(std::string_view name, const ParameterInfo& info) {
    if (name == wanted_) unit = info.unit;
  }
  std::string_view wanted_;
};

// what the table `kind.name` is read into; null when there is none
std::unique_ptr<Parameterized> target_of(const Experiment& experiment, std::string_view kind, std::string_view name) {
  const auto type_in = [&](const std::vector<Choice>& choices) {
    const auto choice = std::find_if(choices.begin(), choices.end(), [&](const Choice& c) { return c.name == name; });
    return choice == choices.end() ? std::string(name) : choice->spec.type;
  };
  const auto made = [](const auto* row) -> std::unique_ptr<Parameterized> {
    if (row == nullptr) return nullptr;
    return row->make();
  };
  if (kind == "effect") return made(find_effect(name));
  if (kind == "controller") return made(find_controller(type_in(experiment.controllers)));
  return kind == "trajectory" ? made(find_trajectory(type_in(experiment.trajectories))) : nullptr;
}

}  // namespace

std::string unit_of_setting(const Experiment& experiment, std::string_view key) {
  const std::size_t first = key.find('.'), last = key.rfind('.');
  UnitOf visitor(last == key.npos ? key : key.substr(last + 1));
  const std::unique_ptr<Parameterized> target =
      first == key.npos ? make_experiment_keys()
      : first < last    ? target_of(experiment, key.substr(0, first), key.substr(first + 1, last - first - 1))
                        : nullptr;
  if (target) target->visit(visitor);
  return visitor.unit;
}

}  // namespace gustlab
