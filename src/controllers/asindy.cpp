// asindy: Adaptive SINDy, Algorithm 1 of arXiv 2603.08863: the residual force as a sparse combination of identified terms
// whose coefficients adapt in flight.
#include "control/feature_terms.hpp"
#include "control/residual.hpp"
#include "controllers/controllers.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

class AdaptiveSindy {
 public:
  void visit(ParameterVisitor& visitor) {
    visitor.texts("terms", term_names_, {.help = "active terms: the union over the three axes of what SINDy identified"});
    residual_.visit(visitor);
  }

  void reset(const OffboardSetup& setup) {
    if (term_names_.empty() || term_names_.size() > Adaptation::max_terms)
      throw ConfigError("controller asindy: terms must name 1 to " + std::to_string(Adaptation::max_terms) + " terms");
    terms_.clear();
    for (const std::string& name : term_names_) terms_.push_back(FeatureTerm::parse(name));
    phi_ = Adaptation::Row::Zero(static_cast<Eigen::Index>(terms_.size()));
    weight_N_ = setup.vehicle.weight_N();
    residual_.reset(setup, Adaptation::Parameters::Zero(phi_.cols(), 3));
  }

  Vector3 update(const OffboardInput& in) {
    FeatureInput features;
    features.position_W_m = in.seen.position_W_m;
    features.velocity_W_mps = in.seen.velocity_W_mps;
    set_angles(features, in.seen.attitude_WB.toRotationMatrix());
    // in units of the weight: terms with and without T are of one size, on every vehicle
    features.thrust_N = in.thrust_W_N.norm() / weight_N_;
    features.body_rate_B_radps = in.seen.body_rate_B_radps;
    evaluate(terms_, features, std::span<double>(phi_.data(), terms_.size()));
    return residual_.update(in, phi_);
  }

  std::vector<std::string_view> telemetry_names() const { return residual_.telemetry_names(); }
  void telemetry(std::span<double> out) const { residual_.telemetry(out); }

 private:
  std::vector<std::string> term_names_{"1", "T sin theta", "T sin phi"};
  ResidualAdaptation residual_;
  std::vector<FeatureTerm> terms_;
  Adaptation::Row phi_;
  double weight_N_ = 1.0;
};

}  // namespace

std::unique_ptr<Controller> make_asindy() { return std::make_unique<Offboard<AdaptiveSindy>>(); }

}  // namespace gustlab
