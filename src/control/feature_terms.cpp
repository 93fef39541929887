#include "control/feature_terms.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "gustlab/errors.hpp"

namespace gustlab {
namespace {

// velocity seen in body axes, Rᵀ v with R = Rz(ψ) Ry(θ) Rx(φ)
Vector3 velocity_B_mps(const FeatureInput& in) {
  const double cy = std::cos(in.yaw_rad), sy = std::sin(in.yaw_rad);
  const double cp = std::cos(in.pitch_rad), sp = std::sin(in.pitch_rad);
  const double cr = std::cos(in.roll_rad), sr = std::sin(in.roll_rad);
  const Vector3& v = in.velocity_W_mps;
  const double forward = cy * v.x() + sy * v.y(), left = cy * v.y() - sy * v.x();
  const double x = cp * forward - sp * v.z(), up = sp * forward + cp * v.z();
  return {x, cr * left + sr * up, cr * up - sr * left};
}

constexpr FeatureVariable variables[] = {
    {"theta", "rad", "pitch angle (ZYX)", [](const FeatureInput& in) { return in.pitch_rad; }},
    {"phi", "rad", "roll angle (ZYX)", [](const FeatureInput& in) { return in.roll_rad; }},
    {"psi", "rad", "yaw angle (ZYX)", [](const FeatureInput& in) { return in.yaw_rad; }},
    {"T", "N", "total thrust", [](const FeatureInput& in) { return in.thrust_N; }},
    {"px", "m", "position, world x", [](const FeatureInput& in) { return in.position_W_m.x(); }},
    {"py", "m", "position, world y", [](const FeatureInput& in) { return in.position_W_m.y(); }},
    {"pz", "m", "position, world z", [](const FeatureInput& in) { return in.position_W_m.z(); }},
    {"vx", "m/s", "velocity, world x", [](const FeatureInput& in) { return in.velocity_W_mps.x(); }},
    {"vy", "m/s", "velocity, world y", [](const FeatureInput& in) { return in.velocity_W_mps.y(); }},
    {"vz", "m/s", "velocity, world z", [](const FeatureInput& in) { return in.velocity_W_mps.z(); }},
    {"vx_B", "m/s", "velocity, body x", [](const FeatureInput& in) { return velocity_B_mps(in).x(); }},
    {"vy_B", "m/s", "velocity, body y", [](const FeatureInput& in) { return velocity_B_mps(in).y(); }},
    {"vz_B", "m/s", "velocity, body z", [](const FeatureInput& in) { return velocity_B_mps(in).z(); }},
    {"speed", "m/s", "length of the velocity", [](const FeatureInput& in) { return in.velocity_W_mps.norm(); }},
    {"wx", "rad/s", "body rate, body x", [](const FeatureInput& in) { return in.body_rate_B_radps.x(); }},
    {"wy", "rad/s", "body rate, body y", [](const FeatureInput& in) { return in.body_rate_B_radps.y(); }},
    {"wz", "rad/s", "body rate, body z", [](const FeatureInput& in) { return in.body_rate_B_radps.z(); }},
};

std::string variable_names() {
  std::string names;
  for (const FeatureVariable& variable : variables) {
    names += names.empty() ? "" : ", ";
    names += variable.name;
  }
  return names;
}

}  // namespace

std::span<const FeatureVariable> feature_variables() { return variables; }

void set_angles(FeatureInput& input, const Matrix3& R_WB) {
  input.roll_rad = std::atan2(R_WB(2, 1), R_WB(2, 2));
  input.pitch_rad = std::asin(std::clamp(-R_WB(2, 0), -1.0, 1.0));
  input.yaw_rad = std::atan2(R_WB(1, 0), R_WB(0, 0));
}

// Reads a term from left to right.
class FeatureTerm::Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  FeatureTerm read() {
    FeatureTerm term;
    skip_space();
    if (trimmed() == "1") {
      term.name_ = "1";
      return term;
    }
    while (at_ < text_.size()) {
      if (term.factor_count_ == max_factors) fail("too many factors (at most 4)", "split it into several terms");
      term.factors_[static_cast<std::size_t>(term.factor_count_++)] = factor();
      skip_space();
      if (take('*') && at_ == text_.size()) fail("nothing follows *", "write a variable after it");
    }
    if (term.factor_count_ == 0) fail("empty term", "write for example T sin theta");
    for (int i = 0; i < term.factor_count_; ++i) term.name_ += (i ? " " : "") + text(term.factors_[std::size_t(i)]);
    return term;
  }

 private:
  static std::string text(const Factor& factor) {
    std::string out;
    if (factor.function == Function::sine) out = "sin ";
    if (factor.function == Function::cosine) out = "cos ";
    if (factor.function == Function::absolute) out = "abs ";
    if (factor.multiple != 1) out += std::to_string(factor.multiple) + " ";
    out += factor.variable->name;
    if (factor.power != 1) out += "^" + std::to_string(factor.power);
    return out;
  }

  Factor factor() {
    Factor out;
    std::string_view name = word();
    if (name == "sin") out.function = Function::sine;
    if (name == "cos") out.function = Function::cosine;
    if (name == "abs") out.function = Function::absolute;
    bool open = false;
    if (out.function != Function::identity) {
      open = take('(');
      if (out.function != Function::absolute && next_is_digit()) {
        out.multiple = number();
        take('*');
      }
      name = word();
    }
    const auto found = std::find_if(std::begin(variables), std::end(variables),
                                    [&](const FeatureVariable& variable) { return variable.name == name; });
    if (found == std::end(variables)) {
      fail(name.empty() ? "a variable is missing" : "unknown variable \"" + std::string(name) + "\"",
           "use one of " + variable_names() + ", and sin, cos, abs");
    }
    out.variable = found;
    if (open && !take(')')) fail("( is never closed", "write for example sin(theta)");
    if (take('^')) out.power = number();
    return out;
  }

  std::string_view word() {
    skip_space();
    const std::size_t start = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '_')) ++at_;
    return text_.substr(start, at_ - start);
  }
  bool next_is_digit() {
    skip_space();
    return at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_]));
  }
  int number() {
    skip_space();
    if (!next_is_digit() || text_[at_] == '0') fail("a whole number from 1 to 9 is missing", "write for example vx^2");
    const int digit = text_[at_++] - '0';
    if (at_ < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at_]))) {
      fail("number too large (powers and multiples go to 9)", "use a smaller one");
    }
    return digit;
  }
  bool take(char wanted) {
    skip_space();
    if (at_ == text_.size() || text_[at_] != wanted) return false;
    ++at_;
    skip_space();
    return true;
  }
  void skip_space() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  std::string_view trimmed() const {
    std::string_view out = text_;
    while (!out.empty() && std::isspace(static_cast<unsigned char>(out.front()))) out.remove_prefix(1);
    while (!out.empty() && std::isspace(static_cast<unsigned char>(out.back()))) out.remove_suffix(1);
    return out;
  }
  [[noreturn]] void fail(const std::string& problem, const std::string& suggestion) const {
    throw ConfigError("term \"" + std::string(text_) + "\": " + worded(problem, "", suggestion));
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

FeatureTerm FeatureTerm::parse(std::string_view text) { return Reader(text).read(); }

double FeatureTerm::value(const FeatureInput& input) const {
  double product = 1.0;
  for (int i = 0; i < factor_count_; ++i) {
    const Factor& factor = factors_[static_cast<std::size_t>(i)];
    double value = factor.variable->value(input);
    switch (factor.function) {
      case Function::identity:
        break;
      case Function::sine:
        value = std::sin(factor.multiple * value);
        break;
      case Function::cosine:
        value = std::cos(factor.multiple * value);
        break;
      case Function::absolute:
        value = std::abs(value);
        break;
    }
    for (int k = 0; k < factor.power; ++k) product *= value;
  }
  return product;
}

std::vector<FeatureTerm> parse_terms(std::span<const std::string> texts) {
  std::vector<FeatureTerm> terms;
  for (const std::string& text : texts) {
    try {
      terms.push_back(FeatureTerm::parse(text));
    } catch (const ConfigError& error) {
      throw ParameterError("terms", error.what());
    }
    const std::string& name = terms.back().name();
    if (std::any_of(terms.begin(), terms.end() - 1, [&](const FeatureTerm& before) { return before.name() == name; }))
      throw ParameterError(
          "terms", "term \"" + name + "\" is here twice (one coefficient cannot be told from the other); keep one");
  }
  return terms;
}

void evaluate(std::span<const FeatureTerm> terms, const FeatureInput& input, std::span<double> out) {
  for (std::size_t i = 0; i < terms.size(); ++i) out[i] = terms[i].value(input);
}

}  // namespace gustlab
