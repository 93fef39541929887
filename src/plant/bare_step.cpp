#include "plant/bare_step.hpp"

#include <fmt/format.h>

#include "gustlab/errors.hpp"
#include "plant/mujoco.hpp"

namespace gustlab {

namespace {

// a body of the Crazyflie's mass and inertia (models/crazyflie)
constexpr const char* minimal_xml = R"(<mujoco><option timestep="{}" integrator="Euler">
<flag autoreset="disable" contact="disable" constraint="disable"/></option>
<worldbody><body pos="0 0 1"><freejoint/><inertial pos="0 0 0" mass="0.0282" diaginertia="2.09e-5 2.1e-5 3.54e-5"/></body></worldbody>
</mujoco>)";

constexpr const char* stock_xml = R"(<mujoco><option timestep="{}" integrator="Euler"/>
<worldbody><geom type="plane" size="0 0 1"/>
<body pos="0 0 1"><freejoint/><inertial pos="0 0 0" mass="0.0282" diaginertia="2.09e-5 2.1e-5 3.54e-5"/>
<geom type="box" size="0.04 0.04 0.015"/>
<geom type="cylinder" size="0.023 0.002" pos="0.031 -0.031 0.021"/><geom type="cylinder" size="0.023 0.002" pos="-0.031 -0.031 0.021"/>
<geom type="cylinder" size="0.023 0.002" pos="-0.031 0.031 0.021"/><geom type="cylinder" size="0.023 0.002" pos="0.031 0.031 0.021"/>
<site name="imu"/><site name="m1" pos="0.031 -0.031 0.021"/><site name="m2" pos="-0.031 -0.031 0.021"/>
<site name="m3" pos="-0.031 0.031 0.021"/><site name="m4" pos="0.031 0.031 0.021"/></body></worldbody>
<actuator><motor site="m1" gear="0 0 1 0 0 -0.006"/><motor site="m2" gear="0 0 1 0 0 0.006"/>
<motor site="m3" gear="0 0 1 0 0 -0.006"/><motor site="m4" gear="0 0 1 0 0 0.006"/></actuator>
<sensor><gyro site="imu"/><accelerometer site="imu"/><framequat objtype="site" objname="imu"/></sensor>
</mujoco>)";

}  // namespace

struct BareStep::World {
  ModelPointer model;
  DataPointer data;
};

BareStep::BareStep(Model model, double step_s) : world_(std::make_unique<World>()) {
  install_mujoco_handlers();
  const std::string xml = fmt::format(fmt::runtime(model == Model::stock ? stock_xml : minimal_xml), step_s);
  char error[1024] = "";
  const SpecPointer spec(mj_parseXMLString(xml.c_str(), nullptr, error, sizeof error));
  if (spec) world_->model.reset(mj_compile(spec.get(), nullptr));
  if (!world_->model) throw IoError(fmt::format("MuJoCo cannot compile its own example: {}", error));
  world_->data.reset(mj_makeData(world_->model.get()));
  // the weight is carried, so that it stays where it is for ever
  const double weight_N = 0.0282 * 9.81;
  if (model == Model::stock) mju_fill(world_->data->ctrl, weight_N / 4.0, 4);
  else world_->data->qfrc_applied[2] = weight_N;
}

BareStep::~BareStep() = default;

void BareStep::step(int count) {
  for (int i = 0; i < count; ++i) mj_step(world_->model.get(), world_->data.get());
}

}  // namespace gustlab
