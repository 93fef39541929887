#include "parameter_table.hpp"

#include <cmath>

namespace gustlab {

namespace {

using nlohmann::ordered_json;

class Lister final : public ParameterVisitor {
 public:
  void number(std::string_view name, double& value, const ParameterInfo& info) override { add(name, value, info); }
  void integer(std::string_view name, std::int64_t& value, const ParameterInfo& info) override {
    add(name, value, info);
  }
  void flag(std::string_view name, bool& value, const ParameterInfo& info) override { add(name, value, info); }
  void text(std::string_view name, std::string& value, const ParameterInfo& info) override { add(name, value, info); }
  void numbers(std::string_view name, std::vector<double>& value, const ParameterInfo& info) override {
    add(name, value, info);
  }
  void texts(std::string_view name, std::vector<std::string>& value, const ParameterInfo& info) override {
    add(name, value, info);
  }
  void vector(std::string_view name, Vector3& value, const ParameterInfo& info) override {
    add(name, {value.x(), value.y(), value.z()}, info);
  }

  ordered_json rows = ordered_json::array();

 private:
  void add(std::string_view name, ordered_json value, const ParameterInfo& info) {
    ordered_json row{{"name", name}, {"unit", info.unit}, {"default", std::move(value)}, {"help", info.help}};
    if (std::isfinite(info.min)) row["min"] = info.min;
    if (std::isfinite(info.max)) row["max"] = info.max;
    rows.push_back(std::move(row));
  }
};

}  // namespace

ordered_json parameter_table(Parameterized& target) {
  Lister lister;
  target.visit(lister);
  return lister.rows;
}

}  // namespace gustlab
