#include "vehicle/mjcf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "gustlab/errors.hpp"
#include "plant/mjcf_files.hpp"
#include "plant/mujoco.hpp"

namespace gustlab {

namespace {

using Rows3 = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
using Column3 = Eigen::Map<const Vector3>;

// the number behind a word, as in "line 5", "line number 5", "column = 3"; empty without one
std::string number_behind(const std::string& said, std::string_view word) {
  for (std::size_t at = said.find(word); at != std::string::npos; at = said.find(word, at + 1)) {
    const std::size_t digit = said.find_first_not_of("number =", at + word.size());
    if (digit != std::string::npos && digit > at + word.size() && std::isdigit(static_cast<unsigned char>(said[digit])))
      return said.substr(digit, said.find_first_not_of("0123456789", digit) - digit);
  }
  return {};
}

// MuJoCo says "…, line 5, column 3" or "line 5" somewhere in its message
[[noreturn]] void fail_as_mujoco_says(const std::string& path, std::string said) {
  std::string where = path, lower = said;
  std::transform(said.begin(), said.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const char* word : {"line", "column"}) {
    const std::string number = number_behind(lower, word);
    if (number.empty()) break;
    where += ":" + number;
  }
  for (char& c : said)
    if (c == '\n') c = ' ';
  throw ConfigError(fmt::format("{}: not a model that MuJoCo takes ({})", where, said));
}

[[noreturn]] void fail(const std::string& path, const std::string& problem) {
  throw ConfigError(fmt::format("{}: {}", path, problem));
}

// MuJoCo finds every file in memory, below a folder that is on no disk: what was not given to it cannot be read
class MemoryFiles {
 public:
  explicit MemoryFiles(const MjcfFiles& files) {
    mj_defaultVFS(&vfs_);
    for (const auto& [name, bytes] : files.bytes)
      mj_addBufferVFS(&vfs_, path_of(name).c_str(), bytes.data(), static_cast<int>(bytes.size()));
  }
  ~MemoryFiles() { mj_deleteVFS(&vfs_); }
  MemoryFiles(const MemoryFiles&) = delete;
  MemoryFiles& operator=(const MemoryFiles&) = delete;
  static std::string path_of(const std::string& name) { return "/gustlab in memory/" + name; }
  const mjVFS* get() const { return &vfs_; }

 private:
  mjVFS vfs_;
};

ModelPointer load(const std::string& path, const MjcfFiles& files) {
  install_mujoco_handlers();
  const MemoryFiles memory(files);
  char error[1024] = "";
  const SpecPointer spec(mj_parseXML(MemoryFiles::path_of(files.main).c_str(), memory.get(), error, sizeof error));
  if (!spec) fail_as_mujoco_says(path, error);
  ModelPointer model(mj_compile(spec.get(), memory.get()));
  if (!model) fail_as_mujoco_says(path, mjs_getError(spec.get()));
  return model;
}

// the vehicle's part of a run's key: one file alone is its bytes, of several each has its name
std::string bytes_of(const MjcfFiles& files) {
  std::string all = files.bytes.at(files.main);
  for (const auto& [name, bytes] : files.bytes)
    if (name != files.main) all += fmt::format("{}{}{}{}{}", '\0', name, '\0', bytes.size(), '\0') + bytes;
  return all;
}

const char* primitive_name(int type) {
  switch (type) {
    case mjGEOM_SPHERE:
      return "sphere";
    case mjGEOM_CAPSULE:
      return "capsule";
    case mjGEOM_ELLIPSOID:
      return "ellipsoid";
    case mjGEOM_CYLINDER:
      return "cylinder";
    case mjGEOM_BOX:
      return "box";
    default:
      return nullptr;
  }
}

}  // namespace

MjcfBody read_mjcf(const std::string& path) {
  MjcfBody body;
  const MjcfFiles files = read_mjcf_files(path);
  body.bytes = bytes_of(files);
  const ModelPointer model = load(path, files);
  const mjModel& m = *model;
  if (m.njnt != 1 || m.jnt_type[0] != mjJNT_FREE)
    fail(path,
         fmt::format("a vehicle has exactly one free joint and no other joint (here: {}); weld moving parts", m.njnt));
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
      body.sites.push_back(
          {m.names + m.name_siteadr[i], place(d.site_xpos + 3 * i), R_BW * Rows3(d.site_xmat + 9 * i).col(2)});
  for (int i = 0; i < m.ngeom; ++i) {
    if (!on_vehicle(m.geom_bodyid[i]) || (m.geom_contype[i] == 0 && m.geom_conaffinity[i] == 0)) continue;
    const char* type = primitive_name(m.geom_type[i]);
    if (type == nullptr)
      fail(path,
           fmt::format("geom {} \"{}\" cannot collide (only sphere, capsule, ellipsoid, cylinder and box do); give "
                       "it contype=\"0\" conaffinity=\"0\"",
                       i, m.names + m.name_geomadr[i]));
    body.shapes.push_back({type, Column3(m.geom_size + 3 * i), place(d.geom_xpos + 3 * i),
                           Quaternion(Matrix3(R_BW * Rows3(d.geom_xmat + 9 * i)))});
  }
  return body;
}

}  // namespace gustlab
