#include "controllers/controllers.hpp"

namespace gustlab {

namespace {

constexpr ControllerRow rows[] = {
    {.name = "pid",
     .says = "cascaded PID on position and velocity, as the vehicle's firmware flies it",
     .source = "Crazyflie firmware, position_controller_pid; ArduPilot, AC_PosControl",
     .make = make_pid},
    {.name = "indi",
     .says = "incremental inversion of acceleration and attitude, from accelerometer and gyroscope",
     .source = "Crazyflie firmware, controller_indi; Smeur et al., CEP 73, 2018; Tal & Karaman, TCST 29(3), 2021",
     .make = make_indi},
    {.name = "daiml",
     .says = "adaptive combination of features that a network learned, invariant of the wind",
     .source = "O'Connell et al. (Neural-Fly), Science Robotics 7(66), 2022",
     .make = make_daiml},
    {.name = "asindy",
     .says = "adaptive combination of terms that SINDy identified",
     .source = "arXiv 2603.08863, Algorithm 1",
     .make = make_asindy},
    {.name = "geometric",
     .says = "the same tracking law without adaptation, with an integral",
     .source = "Lee, Leok, McClamroch, CDC 2010; Goodarzi et al., ECC 2013",
     .make = make_geometric},
    {.name = "l1",
     .says = "the same tracking law with an L1 adaptive estimate of the force",
     .source = "Hovakimyan & Cao, L1 Adaptive Control Theory, 2010; Wu et al., TCST 2025",
     .make = make_l1},
    {.name = "mpc",
     .says = "linear model predictive control with an estimate of the missing force",
     .source = "Kamel, Burri, Siegwart, IFAC 50(1), 2017; Richter, Jones, Morari, TAC 57(6), 2012",
     .make = make_mpc},
};

}  // namespace

std::span<const ControllerRow> controller_registry() { return rows; }

const ControllerRow* find_controller(std::string_view name) {
  for (const ControllerRow& row : rows)
    if (row.name == name) return &row;
  return nullptr;
}

}  // namespace gustlab
