// Three numbers in registers: the same as Eigen's vectors, to the bit where that is promised.
#include "util/three.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "gustlab/random.hpp"

namespace gustlab {
namespace three_test {

Vector3 random_vector(std::uint64_t counter) {
  const auto n = RandomStream(1, 0, "three_test").normal4(counter);
  return {n[0], 1e3 * n[1], 1e-3 * n[2]};
}
Quaternion random_attitude(std::uint64_t counter) {
  const auto n = RandomStream(1, 0, "three_test_attitude").normal4(counter);
  return Quaternion(n[0], n[1], n[2], n[3]).normalized();
}

TEST(Three, CountsAsEigenDoesToTheBit) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Vector3 a = random_vector(2 * i), b = random_vector(2 * i + 1);
    EXPECT_EQ(Vector3(Three(a) + b), a + b);
    EXPECT_EQ(Vector3(Three(a) - b), a - b);
    EXPECT_EQ(Vector3(0.7 * Three(a)), 0.7 * a);
    EXPECT_EQ(Vector3(Three(a) / 0.7), a / 0.7);
    EXPECT_EQ(Vector3(times(a, b)), a.cwiseProduct(b));
    EXPECT_EQ(Vector3(cross(a, b)), a.cross(b));
    EXPECT_EQ(dot(a, b), a.dot(b));
    EXPECT_EQ(length(a), a.norm());
  }
}

TEST(Three, IsTurnedByAMatrixAndBack) {
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Quaternion q = random_attitude(i);
    const Vector3 v = random_vector(i);
    Matrix3 R;
    rotation_of(q, R);
    EXPECT_EQ(R, q.toRotationMatrix());
    EXPECT_LT((Vector3(rotated(R, v)) - R * v).norm(), 1e-15 * v.norm() * 4.0);
    EXPECT_LT((Vector3(rotated_back(R, v)) - R.transpose() * v).norm(), 1e-15 * v.norm() * 4.0);
    EXPECT_LT((Vector3(rotated_back(R, rotated(R, v))) - v).norm(), 1e-14 * v.norm());
  }
}

}  // namespace three_test
}  // namespace gustlab
