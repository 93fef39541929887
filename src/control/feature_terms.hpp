// Named terms φ(x, u) of a flight's state: what sparse regression chooses from and what Adaptive SINDy evaluates in
// flight.
//
// A term is a product of at most four factors. A factor is a variable (`theta`), a power of one (`vx^2`) or a function
// of one (`sin theta`, `cos 2 psi`, `abs vx`); `1` is the constant. `T sin theta` and `T*sin(theta)` read the same, and
// `sin theta^2` is the square of the sine. The paper's library (arXiv 2603.08863, section II-A) is 1, theta, phi, T sin
// theta, T cos theta, T sin phi, T cos phi.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gustlab/types.hpp"

namespace gustlab {

// What a term may look at. Angles are ZYX Euler angles (yaw, then pitch, then roll) of the attitude body → world.
struct FeatureInput {
  Vector3 position_W_m = Vector3::Zero();
  Vector3 velocity_W_mps = Vector3::Zero();
  double roll_rad = 0.0;   // φ
  double pitch_rad = 0.0;  // θ
  double yaw_rad = 0.0;    // ψ
  double thrust_N = 0.0;   // T, sum over the rotors, along body z
  Vector3 body_rate_B_radps = Vector3::Zero();
};

// Sets the three angles of `input` from the rotation body → world; pitch within ±π/2, the others within ±π.
void set_angles(FeatureInput& input, const Matrix3& R_WB);

// A row of the registry of variables.
struct FeatureVariable {
  std::string_view name;
  std::string_view unit;
  std::string_view says;
  double (*value)(const FeatureInput&);
};
std::span<const FeatureVariable> feature_variables();

class FeatureTerm {
 public:
  static constexpr int max_factors = 4;
  static constexpr int max_power = 9;

  // Reads a term. Throws ConfigError, `problem (why); suggestion`, without a place.
  static FeatureTerm parse(std::string_view text);

  // Canonical text; parse(name()) gives the same term.
  const std::string& name() const { return name_; }
  // Allocates nothing. Finite for finite input.
  double value(const FeatureInput& input) const;

 private:
  enum class Function { identity, sine, cosine, absolute };
  struct Factor {
    const FeatureVariable* variable = nullptr;
    Function function = Function::identity;
    int multiple = 1;  // inside sine and cosine
    int power = 1;
    bool operator==(const Factor&) const = default;
  };
  class Reader;
  std::array<Factor, max_factors> factors_{};
  int factor_count_ = 0;
  std::string name_;
};

// Terms of which none may come twice. Throws ParameterError, of `terms`.
std::vector<FeatureTerm> parse_terms(std::span<const std::string> texts);

// out[i] = terms[i](input); both of one length. Allocates nothing.
void evaluate(std::span<const FeatureTerm> terms, const FeatureInput& input, std::span<double> out);

}  // namespace gustlab
