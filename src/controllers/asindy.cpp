// asindy: Adaptive SINDy, Algorithm 1 of arXiv 2603.08863: the residual force as a sparse combination of identified terms
// whose coefficients adapt in flight.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/toml.hpp"
#include "control/residual.hpp"
#include "control/residual_model.hpp"
#include "controllers/controllers.hpp"
#include "gustlab/errors.hpp"

namespace gustlab {

namespace {

struct IdentifiedModel final : Parameterized {
  ResidualModel model;
  void visit(ParameterVisitor& visitor) override { model.visit(visitor); }
};

// the model that `gustlab identify` wrote: the file's [[effect]] of type sindy_residual
ResidualModel read_model(const InputFile& file) {
  config::Table document = config::Table::parse(file.bytes, file.path);
  for (const EffectSpec& spec : config::read_effects(document)) {
    if (spec.type != "sindy_residual") continue;
    IdentifiedModel identified;
    config::read_parameters(spec, identified);
    config::at_place(spec, [&] { identified.model.prepare(); });
    return identified.model;
  }
  throw ConfigError(file.path +
                    ": no [[effect]] of type \"sindy_residual\" (a model lists the active terms); name a file that "
                    "`gustlab identify --out` wrote");
}

// the power of T in a term
double thrust_power(const FeatureTerm& term) {
  FeatureInput probe{{1.1, 1.2, 1.3}, {0.7, 0.8, 0.9}, 0.3, 0.4, 0.5, 1.0, {0.2, 0.25, 0.35}};
  const double one = term.value(probe);
  probe.thrust_N = 2.0;
  return std::round(std::log2(term.value(probe) / one));
}

const std::vector<std::string> default_terms{"1", "T sin theta", "T sin phi"};

class AdaptiveSindy {
 public:
  void visit(ParameterVisitor& visitor) {
    visitor.texts("terms", term_names_,
                  {.help = "active terms: the union over the three axes of what SINDy identified"});
    visitor.file("model", model_, {.help = "file that `gustlab identify --out` wrote: its terms instead"});
    visitor.flag(
        "start_at_model", start_at_model_,
        {.help = "coefficients start at the model's, in N of the vehicle it was identified on; otherwise at zero"});
    residual_.visit(visitor);
  }

  void reset(const OffboardSetup& setup) {
    weight_N_ = setup.vehicle.weight_N();
    ResidualModel model;
    if (model_.path.empty()) {
      terms_ = parse_terms(term_names_);
    } else {
      if (term_names_ != default_terms)
        throw ParameterError("terms", "\"terms\" stands beside \"model\" (the model brings its own terms); keep one");
      model = read_model(model_);
      terms_.assign(model.terms().begin(), model.terms().end());
    }
    if (terms_.empty() || terms_.size() > Adaptation::max_terms)
      throw ParameterError(
          model_.path.empty() ? "terms" : "model",
          fmt::format("{} has {} terms (1 to {} terms can adapt)", model_.path.empty() ? "\"terms\"" : model_.path,
                      terms_.size(), Adaptation::max_terms));
    phi_ = Adaptation::Row::Zero(static_cast<Eigen::Index>(terms_.size()));

    Adaptation::Parameters start = Adaptation::Parameters::Zero(phi_.cols(), 3);
    if (start_at_model_)
      // N per unit of the term with T in N → m/s² with T in weights
      for (Eigen::Index i = 0; i < model.coefficients().cols(); ++i)
        start.row(i) = model.coefficients().col(i).transpose() *
                       (std::pow(weight_N_, thrust_power(terms_[static_cast<std::size_t>(i)])) / setup.vehicle.mass_kg);
    residual_.reset(setup, start);
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
  std::vector<std::string> term_names_ = default_terms;
  InputFile model_;
  bool start_at_model_ = false;
  ResidualAdaptation residual_;
  std::vector<FeatureTerm> terms_;
  Adaptation::Row phi_;
  double weight_N_ = 1.0;
};

}  // namespace

std::unique_ptr<Controller> make_asindy() { return std::make_unique<Offboard<AdaptiveSindy>>(); }

}  // namespace gustlab
