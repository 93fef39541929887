#include "plant/mujoco.hpp"

#include <fmt/format.h>

#include <mutex>

#include "gustlab/errors.hpp"

namespace gustlab {

void install_mujoco_handlers() {
  static std::once_flag once;
  std::call_once(once, [] {
    mju_user_error = [](const char* message) { throw IoError(fmt::format("MuJoCo: {}", message)); };
    mju_user_warning = [](const char*) {};
  });
}

}  // namespace gustlab
