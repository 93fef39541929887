#include "vehicle/mjcf.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "gustlab/errors.hpp"
#include "plant/mujoco.hpp"

namespace gustlab {

namespace {

using Rows3 = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
using Column3 = Eigen::Map<const Vector3>;

// MuJoCo says "…, line 5, column 3" or "line 5" somewhere in its message
[[noreturn]] void fail_as_mujoco_says(const std::string& path, std::string said) {
  std::string where = path;
  for (const char* position : {"line(?: number)?[ =]+(\\d+)", "column[ =]+(\\d+)"}) {
    std::smatch found;
    if (!std::regex_search(said, found, std::regex(position, std::regex::icase))) break;
    where += ":" + found[1].str();
  }
  for (char& c : said)
    if (c == '\n') c = ' ';
  throw ConfigError(fmt::format("{}: not a model that MuJoCo takes ({})", where, said));
}

[[noreturn]] void fail(const std::string& path, const std::string& problem) {
  throw ConfigError(fmt::format("{}: {}", path, problem));
}

// assets are read from the vehicle's folder and nowhere else
void check_assets(mjSpec& spec, const std::string& path) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::weakly_canonical(path).parent_path();
  const auto check = [&](const mjString* directory, const mjString* file) {
    const fs::path asset = fs::weakly_canonical(folder / mjs_getString(directory) / mjs_getString(file));
    if (const auto relative = asset.lexically_relative(folder); relative.empty() || *relative.begin() == "..")
      fail(path, fmt::format("asset \"{}\" is outside the vehicle's folder (a vehicle is one folder) move it there",
                             mjs_getString(file)));
  };
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_MESH); e; e = mjs_nextElement(&spec, e))
    check(spec.compiler.meshdir, mjs_asMesh(e)->file);
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_HFIELD); e; e = mjs_nextElement(&spec, e))
    check(spec.compiler.meshdir, mjs_asHField(e)->file);
  for (mjsElement* e = mjs_firstElement(&spec, mjOBJ_TEXTURE); e; e = mjs_nextElement(&spec, e))
    check(spec.compiler.texturedir, mjs_asTexture(e)->file);
}

std::string read_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  if (!file || text.fail()) fail(path, fmt::format("cannot read ({})", std::strerror(errno ? errno : EIO)));
  return text.str();
}

ModelPointer load(const std::string& path, const std::string& bytes) {
  install_mujoco_handlers();
  if (bytes.find("<include") != std::string::npos)
    fail(path, "<include> is not read (a vehicle's MJCF is one file) paste the other file into it");
  char error[1024] = "";
  const SpecPointer spec(mj_parseXML(path.c_str(), nullptr, error, sizeof error));
  if (!spec) fail_as_mujoco_says(path, error);
  check_assets(*spec, path);
  ModelPointer model(mj_compile(spec.get(), nullptr));
  if (!model) fail_as_mujoco_says(path, mjs_getError(spec.get()));
  return model;
}

const char* primitive_name(int type) {
  switch (type) {
    case mjGEOM_SPHERE: return "sphere";
    case mjGEOM_CAPSULE: return "capsule";
    case mjGEOM_ELLIPSOID: return "ellipsoid";
    case mjGEOM_CYLINDER: return "cylinder";
    case mjGEOM_BOX: return "box";
    default: return nullptr;
  }
}

}  // namespace

MjcfBody read_mjcf(const std::string& path) {
  MjcfBody body;
  body.bytes = read_bytes(path);
  const ModelPointer model = load(path, body.bytes);
  const mjModel& m = *model;
  if (m.njnt != 1 || m.jnt_type[0] != mjJNT_FREE)
    fail(path, fmt::format("a vehicle has exactly one free joint and no other joint (here: {}) weld moving parts", m.njnt));
  if (m.opt.gravity[0] != 0.0 || m.opt.gravity[1] != 0.0 || !(m.opt.gravity[2] < 0.0))
    fail(path, fmt::format("gravity must point along -z (here: {} {} {})", m.opt.gravity[0], m.opt.gravity[1],
                           m.opt.gravity[2]));
  const DataPointer data(mj_makeData(&m));
  mj_kinematics(&m, data.get());
  const mjData& d = *data;
  const auto root = static_cast<std::size_t>(m.jnt_bodyid[0]);
  const Matrix3 R_BW = Rows3(d.xmat + 9 * root).transpose();
  const Vector3 origin_W_m = Column3(d.xpos + 3 * root);
  const auto on_vehicle = [&](int i) { return m.body_rootid[i] == static_cast<int>(root); };
  const auto place = [&](const mjtNum* position) -> Vector3 { return R_BW * (Column3(position) - origin_W_m); };

  // mass and centre of mass of everything welded together, then the inertia about it (Steiner)
  body.gravity_mps2 = -m.opt.gravity[2];
  for (int i = 0; i < m.nbody; ++i) {
    if (!on_vehicle(i)) continue;
    body.mass_kg += m.body_mass[i];
    body.center_of_mass_B_m += m.body_mass[i] * place(d.xipos + 3 * i);
  }
  body.center_of_mass_B_m /= body.mass_kg;
  for (int i = 0; i < m.nbody; ++i) {
    if (!on_vehicle(i)) continue;
    const Matrix3 R = R_BW * Rows3(d.ximat + 9 * i);
    const Vector3 arm = place(d.xipos + 3 * i) - body.center_of_mass_B_m;
    body.inertia_B_kgm2 += R * Column3(m.body_inertia + 3 * i).asDiagonal() * R.transpose() +
                           m.body_mass[i] * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  }
  // rounding of the rotations above leaves specks off the diagonal
  body.inertia_B_kgm2 = (0.5 * (body.inertia_B_kgm2 + body.inertia_B_kgm2.transpose())).eval();
  const double speck = 1e-12 * body.inertia_B_kgm2.trace();
  body.inertia_B_kgm2 = body.inertia_B_kgm2.unaryExpr([speck](double x) { return std::abs(x) < speck ? 0.0 : x; });

  for (int i = 0; i < m.nsite; ++i)
    if (on_vehicle(m.site_bodyid[i]))
      body.sites.push_back({m.names + m.name_siteadr[i], place(d.site_xpos + 3 * i),
                            R_BW * Rows3(d.site_xmat + 9 * i).col(2)});
  for (int i = 0; i < m.ngeom; ++i) {
    if (!on_vehicle(m.geom_bodyid[i]) || (m.geom_contype[i] == 0 && m.geom_conaffinity[i] == 0)) continue;
    const char* type = primitive_name(m.geom_type[i]);
    if (type == nullptr)
      fail(path, fmt::format("geom {} \"{}\" cannot collide (only sphere, capsule, ellipsoid, cylinder and box do) give "
                             "it contype=\"0\" conaffinity=\"0\"", i, m.names + m.name_geomadr[i]));
    body.shapes.push_back({type, Column3(m.geom_size + 3 * i), place(d.geom_xpos + 3 * i),
                           Quaternion(Matrix3(R_BW * Rows3(d.geom_xmat + 9 * i)))});
  }
  return body;
}

}  // namespace gustlab
