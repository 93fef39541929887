// How fast the closed loop is, as ratios that were measured in one run.
#pragma once

#include "simulation/experiment.hpp"

namespace gustlab {

// The loop that is measured: Crazyflie, circle, PID, gust and motor lag at 500 Hz, metrics, no log.
Experiment speed_experiment();

struct Speed {
  double minimal_step_ns;    // bare mj_step of a free body
  double stock_step_ns;      // bare mj_step with floor, geometry and actuators
  double loop_step_ns;       // ours, everything included
  double two_threads_factor; // flights per second on two threads over one; about 1 on a machine with one core
};
// The least of several rounds, in which the four take turns, so that what else the machine does hits all alike.
Speed measure_speed(int rounds);

}  // namespace gustlab
