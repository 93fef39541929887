// hover: one point, one heading.
#include "trajectories/trajectories.hpp"

namespace gustlab {

namespace {

class Hover final : public Trajectory {
 public:
  void visit(ParameterVisitor& visitor) override {
    visitor.vector("position_m", position_W_m_, {.unit = "m", .help = "where to stay"});
    visitor.number("yaw_rad", yaw_rad_, {.unit = "rad", .help = "heading", .min = -pi, .max = pi});
    visitor.vector("start_offset_m", start_offset_W_m_,
                   {.unit = "m", .help = "where the vehicle starts, from that point"});
  }

  Reference at(double) const override {
    Reference reference;
    reference.position_W_m = position_W_m_;
    reference.yaw_rad = yaw_rad_;
    return reference;
  }
  Vector3 start_position_W_m() const override { return position_W_m_ + start_offset_W_m_; }

 private:
  Vector3 position_W_m_{0.0, 0.0, 1.0};
  double yaw_rad_ = 0.0;
  Vector3 start_offset_W_m_ = Vector3::Zero();
};

}  // namespace

std::unique_ptr<Trajectory> make_hover() { return std::make_unique<Hover>(); }

}  // namespace gustlab
