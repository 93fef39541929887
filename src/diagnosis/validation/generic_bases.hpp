// Columns without a physical name: they ask whether anything is left, not what it is.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "diagnosis/estimation/session.hpp"

namespace gustlab::diagnosis {

// Smooth functions of the place in the flown volume: polynomials, closeness to the ground, bumps.
inline constexpr int near_ground = 7;
using PlaceFunctions = Eigen::Matrix<double, near_ground + 10, 1>;
class FlownVolume {
 public:
  explicit FlownVolume(const Session& session);
  PlaceFunctions functions(const Vector3& position_W_m) const;

 private:
  Vector3 middle_W_m_, half_m_;
  double lowest_m_;
};

// A family of columns, to be appended to the filter's own; it lives no longer than the session.
struct BasisFamily {
  std::string name;
  std::vector<int> channel;  // per column: force x y z (or along W), torque x y z
  int size = 0;
  // Sets the columns of one sample, which are zero.
  std::function<void(std::size_t flight, std::size_t sample, Eigen::Ref<SpatialAccelerations> columns)> set;
};
// force of position, force and torque of body velocity, of time, and torque of past commands
std::vector<BasisFamily> omnibus_bases(const Session& session);
// a dozen smooth functions of the state acting on one channel each: force x y z, torque x y z in the body
std::vector<BasisFamily> channel_bases(const Session& session);

// Gram matrix of [these columns of the catalogue, the family, z], whitened under the session's noise, over all flights.
Eigen::MatrixXd gram_with(const Session& session, const BasisFamily& family, const std::vector<int>& columns);
// Their sum when the columns from `first` are trims, which are small beforehand.
void keep_small(const std::vector<Trim>& trims, std::size_t first, Eigen::MatrixXd& gram);

// Δχ² of a family beyond the given columns (always free with it) and small values of the trims: all of it, and
// its terms on one channel alone.
struct FamilyDeltaChi2 {
  double all = 0.0;
  std::array<double, 6> channel{};
  std::array<int, 6> size{};  // terms on the channel
};
std::vector<FamilyDeltaChi2> delta_chi2_of_families(const Session& session, const std::vector<BasisFamily>& families,
                                                    const std::vector<int>& columns,
                                                    const std::vector<Trim>& trims = {});

}  // namespace gustlab::diagnosis
