// MuJoCo's handles and the walls around its traps; for plant/ only.
#pragma once

#include <mujoco/mujoco.h>

#include <memory>

namespace gustlab {

// MuJoCo's default handlers wait for a key and write MUJOCO_LOG.TXT where the program stands; ours do neither: an error
// is thrown as IoError, a warning is kept out of sight (the counters in mjData still tell).
void install_mujoco_handlers();

struct MujocoDeleter {
  void operator()(mjSpec* spec) const { mj_deleteSpec(spec); }
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using SpecPointer = std::unique_ptr<mjSpec, MujocoDeleter>;
using ModelPointer = std::unique_ptr<mjModel, MujocoDeleter>;
using DataPointer = std::unique_ptr<mjData, MujocoDeleter>;

}  // namespace gustlab
