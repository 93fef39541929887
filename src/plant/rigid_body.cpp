#include "plant/rigid_body.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <mutex>

#include "gustlab/errors.hpp"
#include "plant/bias_force.hpp"
#include "plant/mujoco.hpp"
#include "util/three.hpp"

namespace gustlab {

namespace {

// a free body; its inertia is written after compilation, so that MuJoCo neither refuses nor rounds it
std::string body_xml(const VehicleModel& vehicle, double step_s, bool with_ground) {
  std::string geoms, floor;
  const auto from_center_m = [&](const CollisionShape& shape) -> Vector3 {
    return shape.position_B_m - vehicle.center_of_mass_B_m;
  };
  if (with_ground) {
    for (const CollisionShape& shape : vehicle.shapes)
      geoms += fmt::format("<geom type='{}' size='{} {} {}' pos='{} {} {}' quat='{} {} {} {}' mass='0'/>", shape.type,
                           shape.size_m.x(), shape.size_m.y(), shape.size_m.z(), from_center_m(shape).x(),
                           from_center_m(shape).y(), from_center_m(shape).z(), shape.attitude_BG.w(),
                           shape.attitude_BG.x(), shape.attitude_BG.y(), shape.attitude_BG.z());
    floor = fmt::format("<geom type='plane' size='0 0 1' pos='0 0 {}'/>", *vehicle.environment.ground_z_m);
  }
  // MuJoCo's short cut for bodies with a diagonal inertia must not be taken by others
  const char* simple = vehicle.inertia_B_kgm2.isDiagonal(0.0) ? "auto" : "false";
  // what a free body has not got is not looked for either: a tenth of a step
  return fmt::format(
      "<mujoco><option timestep='{}' gravity='0 0 {}' integrator='Euler'><flag autoreset='disable' spring='disable'"
      " damper='disable' actuation='disable' sensor='disable' eulerdamp='disable' {}/></option>"
      "<worldbody>{}<body simple='{}'><freejoint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 "
      "1'/>{}</body></worldbody></mujoco>",
      step_s, -vehicle.gravity_mps2, with_ground ? "" : "contact='disable' constraint='disable'", floor, simple, geoms);
}

// A model of its own. Those of a sweep's runs differ in what is written after compilation alone, so that the compiled ones
// are kept: to compile takes as long as a second of flight.
ModelPointer compiled(const std::string& xml) {
  constexpr std::size_t most_kept = 64;
  static std::mutex mutex;
  static std::map<std::string, ModelPointer> kept;
  const std::lock_guard lock(mutex);
  if (kept.size() >= most_kept) kept.clear();
  ModelPointer& model = kept[xml];
  if (!model) {
    char error[1024] = "";
    const SpecPointer spec(mj_parseXMLString(xml.c_str(), nullptr, error, sizeof error));
    if (spec) model.reset(mj_compile(spec.get(), nullptr));
    if (!model) throw IoError(fmt::format("MuJoCo cannot compile the vehicle: {}", error));
  }
  return ModelPointer(mj_copyModel(nullptr, model.get()));
}

struct World {
  ModelPointer model;
  DataPointer data;

  World(const VehicleModel& vehicle, double step_s, bool with_ground)
      : model(compiled(body_xml(vehicle, step_s, with_ground))) {
    // a diagonal inertia keeps its axes and its bits
    const Matrix3& inertia = vehicle.inertia_B_kgm2;
    Vector3 principal = inertia.diagonal();
    Quaternion axes = Quaternion::Identity();
    if (!inertia.isDiagonal(0.0)) {
      const Eigen::SelfAdjointEigenSolver<Matrix3> solver(inertia);
      Matrix3 R = solver.eigenvectors();
      if (R.determinant() < 0.0) R.col(0) *= -1.0;
      principal = solver.eigenvalues();
      axes = Quaternion(R);
    }
    model->body_mass[1] = vehicle.mass_kg;
    mju_copy3(model->body_inertia + 3, principal.data());
    const double quaternion[4] = {axes.w(), axes.x(), axes.y(), axes.z()};
    mju_copy4(model->body_iquat + 4, quaternion);
    data.reset(mj_makeData(model.get()));
    mj_setConst(model.get(), data.get());
    mj_resetData(model.get(), data.get());
    // the mass matrix, which step_free_body() takes as it finds it
    if (!with_ground) mj_forward(model.get(), data.get());
  }
};

// as mj_checkPos and its like see it
bool is_sound(const mjtNum* values, int count) {
  bool sound = true;
  for (int i = 0; i < count; ++i) sound &= std::abs(values[i]) <= mjMAXVAL;
  return sound;
}

void resist(const mjModel* model, mjData* data) {
  mj_comPos(model, data);
  mj_makeM(model, data);
  mj_factorM(model, data);
  mj_comVel(model, data);
  mj_rne(model, data, 0, data->qfrc_bias);
}

// What mj_step does to a free body that nothing touches, by MuJoCo's own parts or to their bits. What such a body has not got is not
// looked for: constraints, actuators, passive forces, sensors. false: a number was not finite, or beyond any reason.
bool step_free_body(const mjModel* model, mjData* data) {
  bool sound = is_sound(data->qpos, 7) && is_sound(data->qvel, 6);
  mj_kinematics(model, data);
  resist(model, data);
  mj_fwdAcceleration(model, data);
  sound = sound && is_sound(data->qacc_smooth, 6);
  mju_copy(data->qacc_warmstart, data->qacc_smooth, 6);
  mju_addToScl(data->qvel, data->qacc_smooth, model->opt.timestep, 6);
  mj_integratePos(model, data->qpos, data->qvel, model->opt.timestep);
  return sound;
}

// The same of a body along the axes of its inertia. Its mass matrix is diagonal and the same in every attitude, and what resists without
// acceleration has a short form, so that MuJoCo's functions of a quaternion are all that is left of its passes over a tree of bodies.
bool step_simple_body(const mjModel* model, mjData* data) {
  mjtNum *q = data->qpos, *v = data->qvel, attitude[4], R[9];
  bool sound = is_sound(q, 7) && is_sound(v, 6);
  std::copy_n(q + 3, 4, attitude);
  mju_normalize4(attitude);
  mju_quat2Mat(R, attitude);
  Matrix3 R_WB;
  for (int i = 0; i < 3; ++i) R_WB(0, i) = R[i], R_WB(1, i) = R[3 + i], R_WB(2, i) = R[6 + i];
  const BiasForce bias = bias_force({model->body_mass[1], Vector3(model->body_inertia + 3), -model->opt.gravity[2]},
                                    Vector3(q), R_WB, Vector3(v), Vector3(v + 3));
  // no force is passive, and none comes from an actuator
  const auto at = [](const mjtNum* from) { return Three(from[0], from[1], from[2]); };
  const auto put = [](const Three& from, mjtNum* to) { to[0] = from.x, to[1] = from.y, to[2] = from.z; };
  const mjtNum *applied = data->qfrc_applied, *inverse = data->qLDiagInv;
  const Three none(0.0, 0.0, 0.0);
  const Three pushed = times(none - bias.force_W_N + at(applied) + none, at(inverse));
  const Three spun = times(none - bias.torque_B_Nm + at(applied + 3) + none, at(inverse + 3));
  put(pushed, data->qacc_warmstart);
  put(spun, data->qacc_warmstart + 3);
  sound = sound && is_sound(data->qacc_warmstart, 6);
  const mjtNum step_s = model->opt.timestep;
  const Three velocity = at(v) + step_s * pushed;
  put(velocity, v);
  put(at(v + 3) + step_s * spun, v + 3);
  put(at(q) + step_s * velocity, q);
  mju_quatIntegrate(q + 3, v + 3, step_s);
  return sound;
}

// mj_step; false as above
bool step_with_contacts(const mjModel* model, mjData* data) {
  mj_step(model, data);
  return data->warning[mjWARN_BADQPOS].number + data->warning[mjWARN_BADQVEL].number +
             data->warning[mjWARN_BADQACC].number ==
         0;
}

}  // namespace

struct RigidBody::Impl {
  Vector3 center_of_mass_B_m;
  bool centered;  // it is the body's origin
  World air;
  std::unique_ptr<World> ground;  // nullptr: no ground in this environment
  double ground_below_m = 0.0;    // the twin flies below this height of the centre of mass
  World* flying;

  Impl(const VehicleModel& vehicle, double step_s)
      : center_of_mass_B_m(vehicle.center_of_mass_B_m),
        centered(center_of_mass_B_m.isZero(0.0)),
        air(vehicle, step_s, false),
        flying(&air) {
    if (!vehicle.environment.ground_z_m || vehicle.shapes.empty()) return;
    ground = std::make_unique<World>(vehicle, step_s, true);
    double reach_m = 0.0;
    for (const CollisionShape& shape : vehicle.shapes)
      reach_m = std::max(reach_m, (shape.position_B_m - center_of_mass_B_m).norm() + shape.size_m.sum());
    ground_below_m = *vehicle.environment.ground_z_m + 1.1 * reach_m;
  }
};

RigidBody::RigidBody(const VehicleModel& vehicle, double step_s) {
  if (!(vehicle.mass_kg > 0.0) || !(vehicle.inertia_B_kgm2.diagonal().minCoeff() > 0.0))
    throw ConfigError(fmt::format("{}: mass {} kg or inertia is not positive (after body effects); use smaller changes",
                                  vehicle.source_path, vehicle.mass_kg));
  install_mujoco_handlers();
  impl_ = std::make_unique<Impl>(vehicle, step_s);
}

RigidBody::~RigidBody() = default;

void RigidBody::forget() {
  for (World* world : {&impl_->air, impl_->ground.get()}) {
    if (world == nullptr) continue;
    mju_zero(world->data->qacc_warmstart, 6);
    for (mjWarningStat& warning : world->data->warning) warning = {};
  }
}

void RigidBody::save(std::vector<double>& out) const {
  const mjData* data = impl_->flying->data.get();
  out.push_back(impl_->flying == impl_->ground.get() ? 1.0 : 0.0);
  out.insert(out.end(), data->qacc_warmstart, data->qacc_warmstart + 6);
}

const double* RigidBody::load(const double* in) {
  forget();
  impl_->flying = *in++ != 0.0 ? impl_->ground.get() : &impl_->air;
  mju_copy(impl_->flying->data->qacc_warmstart, in, 6);
  return in + 6;
}

bool RigidBody::step(const Flow& flow, const Wrench& wrench, VehicleState& state) {
  const Vector3& arm = impl_->center_of_mass_B_m;
  Vector3 position_W_m = state.position_W_m;
  if (!impl_->centered) position_W_m += flow.R_WB * arm;
  // the twin with the floor flies near the ground
  if (impl_->ground) {
    World* wanted = position_W_m.z() < impl_->ground_below_m ? impl_->ground.get() : &impl_->air;
    if (wanted != impl_->flying) mju_zero(wanted->data->qacc_warmstart, 6);
    impl_->flying = wanted;
  }

  mjData* data = impl_->flying->data.get();
  const Quaternion& q = state.attitude_WB;
  Eigen::Map<Vector3>(data->qpos) = position_W_m;
  Eigen::Map<Eigen::Vector4d>(data->qpos + 3) << q.w(), q.vec();
  Eigen::Map<Vector3>(data->qvel) = flow.velocity_W_mps;
  Eigen::Map<Vector3>(data->qvel + 3) = state.body_rate_B_radps;
  Eigen::Map<Vector3>(data->qfrc_applied) = Vector3(rotated(flow.R_WB, wrench.force_B_N));
  Eigen::Map<Vector3>(data->qfrc_applied + 3) = wrench.torque_B_Nm;
  const mjModel* model = impl_->flying->model.get();
  const bool sound = impl_->flying != &impl_->air ? step_with_contacts(model, data)
                     : model->body_simple[1] != 0 ? step_simple_body(model, data)
                                                  : step_free_body(model, data);

  state.attitude_WB = Quaternion(data->qpos[3], data->qpos[4], data->qpos[5], data->qpos[6]);
  state.body_rate_B_radps = Eigen::Map<const Vector3>(data->qvel + 3);
  state.position_W_m = Eigen::Map<const Vector3>(data->qpos);
  state.velocity_W_mps = Eigen::Map<const Vector3>(data->qvel);
  if (!impl_->centered) {
    const Matrix3 R_WB = state.attitude_WB.toRotationMatrix();
    state.position_W_m -= R_WB * arm;
    state.velocity_W_mps -= R_WB * state.body_rate_B_radps.cross(arm);
  }
  return sound &&
         std::isfinite(data->qpos[0] + data->qpos[1] + data->qpos[2] + data->qvel[3] + data->qvel[4] + data->qvel[5]);
}

int RigidBody::contacts() const { return impl_->flying == impl_->ground.get() ? impl_->flying->data->ncon : 0; }

}  // namespace gustlab
