#include "control/residual_model.hpp"

#include <fmt/format.h>

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
  terms_ = parse_terms(names_);
  const std::pair<const char*, const std::vector<double>&> axes[] = {{"fx", fx_}, {"fy", fy_}, {"fz", fz_}};
  for (const auto& [name, axis] : axes)
    if (axis.size() != names_.size())
      throw ParameterError(name, fmt::format("{} must have one number per term (there are {} terms and {} numbers)",
                                             name, names_.size(), axis.size()));
  coefficients_.resize(3, static_cast<Eigen::Index>(names_.size()));
  for (std::size_t i = 0; i < names_.size(); ++i)
    coefficients_.col(static_cast<Eigen::Index>(i)) << fx_[i], fy_[i], fz_[i];
}

Vector3 ResidualModel::force_W_N(const FeatureInput& input) const {
  Vector3 force = Vector3::Zero();
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    force += terms_[i].value(input) * coefficients_.col(static_cast<Eigen::Index>(i));
  }
  return force;
}

}  // namespace gustlab
