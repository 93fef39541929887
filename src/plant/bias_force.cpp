#include "plant/bias_force.hpp"

namespace gustlab {

namespace {

// turning and moving, or torque and force, at the centre of mass in world axes
struct Spatial {
  Three turn, move;
};

// inertia about the centre of mass, in world axes; `lever` is mass times the way from there to the body's own
struct SpatialInertia {
  double xx, yy, zz, xy, xz, yz;
  Three lever;
  double mass;
};

// the columns of three vectors with these weights
GUSTLAB_INLINE Three mixed(const Three& a, const Three& b, const Three& c, const Three& weight) {
  return (weight.x * a + weight.y * b) + weight.z * c;
}

GUSTLAB_INLINE SpatialInertia inertia_in_world(const FreeBody& body, const Matrix3& R, const Three& off) {
  const double m = body.mass_kg;
  const Vector3& I = body.inertia_kgm2;
  const auto product = [&](int row, int column) {
    return (R(row, 0) * (R(column, 0) * I[0]) + R(row, 1) * (R(column, 1) * I[1])) + R(row, 2) * (R(column, 2) * I[2]);
  };
  return {product(0, 0) + m * (off.y * off.y + off.z * off.z),
          product(1, 1) + m * (off.x * off.x + off.z * off.z),
          product(2, 2) + m * (off.x * off.x + off.y * off.y),
          product(0, 1) - m * off.x * off.y,
          product(0, 2) - m * off.x * off.z,
          product(1, 2) - m * off.y * off.z,
          m * off,
          m};
}

GUSTLAB_INLINE Spatial operator*(const SpatialInertia& i, const Spatial& v) {
  const auto& [t, s] = v;
  const Three& l = i.lever;
  return {{i.xx * t.x + i.xy * t.y + i.xz * t.z - l.z * s.y + l.y * s.z,
           i.xy * t.x + i.yy * t.y + i.yz * t.z + l.z * s.x - l.x * s.z,
           i.xz * t.x + i.yz * t.y + i.zz * t.z - l.y * s.x + l.x * s.y},
          {l.z * t.y - l.y * t.z + i.mass * s.x, l.x * t.z - l.z * t.x + i.mass * s.y,
           l.y * t.x - l.x * t.y + i.mass * s.z}};
}

// how a momentum changes that moves along
GUSTLAB_INLINE Spatial cross_momentum(const Spatial& v, const Spatial& h) {
  return {cross(v.turn, h.turn) + cross(v.move, h.move), cross(v.turn, h.move)};
}

// in the order of MuJoCo's product of six numbers
GUSTLAB_INLINE double along(const Three& axis, const Three& beside, const Spatial& f) {
  return ((axis.x * f.turn.x + axis.z * f.turn.z) + (axis.y * f.turn.y + beside.x * f.move.x)) +
         (beside.y * f.move.y + beside.z * f.move.z);
}

}  // namespace

BiasForce bias_force(const FreeBody& body, const Vector3& position_W_m, const Matrix3& R_WB,
                     const Vector3& velocity_W_mps, const Vector3& rate_B_radps) {
  const double m = body.mass_kg;
  const Three at = position_W_m, v = velocity_W_mps, w = rate_B_radps;
  const Three center = (1.0 / m) * (m * at);
  const SpatialInertia inertia = inertia_in_world(body, R_WB, at - center);

  // how the body moves at the centre of mass when it turns about its own axes, and how that changes
  const Three off = center - at;
  const Three x(R_WB(0, 0), R_WB(1, 0), R_WB(2, 0)), y(R_WB(0, 1), R_WB(1, 1), R_WB(2, 1)),
      z(R_WB(0, 2), R_WB(1, 2), R_WB(2, 2));
  const Three beside_x = cross(x, off), beside_y = cross(y, off), beside_z = cross(z, off);
  const Spatial velocity{mixed(x, y, z, w), v + mixed(beside_x, beside_y, beside_z, w)};
  const Three change = mixed(cross(v, x), cross(v, y), cross(v, z), w);
  const Three acceleration(change.x, change.y, body.gravity_mps2 + change.z);

  const Spatial turned = cross_momentum(velocity, inertia * velocity);
  const Spatial force{cross(inertia.lever, acceleration) + turned.turn, m * acceleration + turned.move};
  return {force.move, {along(x, beside_x, force), along(y, beside_y, force), along(z, beside_z, force)}};
}

}  // namespace gustlab
