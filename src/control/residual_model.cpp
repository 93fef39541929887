#include "control/residual_model.hpp"

#include "gustlab/errors.hpp"

namespace gustlab {

ResidualModel::ResidualModel(std::span<const FeatureTerm> terms, const Eigen::MatrixXd& coefficients) {
  for (std::size_t i = 0; i < terms.size(); ++i) {
    const Eigen::Vector3d column = coefficients.col(static_cast<Eigen::Index>(i));
    if (column.isZero(0.0)) continue;
    names_.push_back(terms[i].name());
    fx_.push_back(column.x());
    fy_.push_back(column.y());
    fz_.push_back(column.z());
  }
  prepare();
}

void ResidualModel::visit(ParameterVisitor& visitor) {
  visitor.texts("terms", names_, {.help = "terms of the model (`gustlab list terms`)"});
  visitor.numbers("fx", fx_, {.unit = "N", .help = "per unit of each term, toward world x", .natural = 0.0});
  visitor.numbers("fy", fy_, {.unit = "N", .help = "per unit of each term, toward world y", .natural = 0.0});
  visitor.numbers("fz", fz_, {.unit = "N", .help = "per unit of each term, toward world z", .natural = 0.0});
}

void ResidualModel::prepare() {
  for (const std::vector<double>* axis : {&fx_, &fy_, &fz_}) {
    if (axis->size() == names_.size()) continue;
    throw ConfigError("fx, fy and fz must each have one number per term (there are " +
                      std::to_string(names_.size()) + " terms and " + std::to_string(axis->size()) + " numbers)");
  }
  terms_.clear();
  coefficients_.resize(3, static_cast<Eigen::Index>(names_.size()));
  for (std::size_t i = 0; i < names_.size(); ++i) {
    terms_.push_back(FeatureTerm::parse(names_[i]));
    coefficients_.col(static_cast<Eigen::Index>(i)) << fx_[i], fy_[i], fz_[i];
  }
}

Vector3 ResidualModel::force_W_N(const FeatureInput& input) const {
  Vector3 force = Vector3::Zero();
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    force += terms_[i].value(input) * coefficients_.col(static_cast<Eigen::Index>(i));
  }
  return force;
}

}  // namespace gustlab
