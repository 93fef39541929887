#include "controllers/controllers.hpp"

namespace gustlab {

namespace {

constexpr ControllerRow rows[] = {
    {.name = "pid", .says = "cascaded PID on position and velocity, as the vehicle's firmware flies it",
     .source = "Crazyflie firmware, position_controller_pid; ArduPilot, AC_PosControl", .make = make_pid},
};

}  // namespace

std::span<const ControllerRow> controller_registry() { return rows; }

const ControllerRow* find_controller(std::string_view name) {
  for (const ControllerRow& row : rows)
    if (row.name == name) return &row;
  return nullptr;
}

}  // namespace gustlab
