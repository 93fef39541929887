#include "diagnosis/estimation/surrogates.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "diagnosis/result/decisions.hpp"
#include "gustlab/random.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr int draws = 199;       // p ≥ 0.005
constexpr int places = 60;       // moved signatures of one flight, each also mirrored
constexpr double nearest = 0.1;  // of a flight, to which a signature is not moved

// Σ over channels of (moved signature)ᵀ with: row i of a channel of n rows meets row (i + i₀) mod n of the signature; mirrored: row
// (−1 − i − i₀) mod n.
Eigen::MatrixXd moved_product(const std::vector<Signature>& channels, double share, bool mirrored,
                              Eigen::MatrixXd (*with)(const Signature&)) {
  Eigen::MatrixXd sum;
  for (const Signature& part : channels) {
    const Eigen::Index n = part.by.rows(), by = static_cast<Eigen::Index>(share * static_cast<double>(n));
    Eigen::MatrixXd other = with(part);
    if (mirrored) other = other.colwise().reverse().eval();
    const Eigen::Index first = mirrored ? by : n - by;  // rows of the other before the signature begins anew
    const Eigen::MatrixXd product = part.by.bottomRows(first).transpose() * other.topRows(first) +
                                    part.by.topRows(n - first).transpose() * other.bottomRows(n - first);
    if (sum.size() == 0) sum = product;
    else sum += product;
  }
  return sum;
}

}  // namespace

SurrogateTest surrogate_test(const SignatureSeries& parts, const Eigen::VectorXd& fitted) {
  SurrogateTest test;
  const Eigen::Index width = fitted.size();
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(width, width);
  for (const auto& flight : parts)
    for (const Signature& part : flight) information += part.by.transpose() * part.by;
  information.diagonal().array() += 1e-12 * (information.diagonal().maxCoeff() + 1e-300);
  const Eigen::LDLT<Eigen::MatrixXd> solver(information);
  const double delta_chi2 = fitted.dot(information * fitted);
  if (!(delta_chi2 > 0.0)) return test;

  // of every flight: its product with what is left, at places along it
  std::vector<Eigen::MatrixXd> products;
  double alike = 0.0, alikes = 0.0;
  for (const auto& flight : parts) {
    Eigen::MatrixXd& of_flight = products.emplace_back(width, 2 * places);
    for (int place = 0; place < 2 * places; ++place) {
      const double share = nearest + (1.0 - 2.0 * nearest) * (place / 2 + 0.5) / places;
      of_flight.col(place) =
          moved_product(flight, share, place % 2 == 1, [](const Signature& p) -> Eigen::MatrixXd { return p.left; });
      if (place % 20 != 0) continue;
      const auto itself = [](const Signature& p) { return p.by; };
      const Eigen::MatrixXd moved = moved_product(flight, share, false, itself),
                            whole = moved_product(flight, 0.0, false, itself);
      alike += std::pow(fitted.dot(moved * fitted) / (fitted.dot(whole * fitted) + 1e-300), 2), alikes += 1.0;
    }
  }
  test.movable = alikes > 0.0 && alike / alikes < decisions::most_alike;

  const RandomStream random(20261123, 0, "surrogates");
  int beyond = 0;
  double sum = 0.0;
  for (int draw = 0; draw < draws; ++draw) {
    Eigen::VectorXd product = Eigen::VectorXd::Zero(width);
    for (std::size_t f = 0; f < products.size(); ++f) {
      const double u = random.uniform4(static_cast<std::uint64_t>(draw), static_cast<std::uint32_t>(f))[0];
      product += products[f].col(std::min(2 * places - 1, static_cast<int>(u * 2 * places)));
    }
    const double chance = product.dot(solver.solve(product));
    sum += chance;
    beyond += chance >= delta_chi2 ? 1 : 0;
  }
  test.inflation = sum / draws / static_cast<double>(width);
  test.p_value = (1.0 + beyond) / (1.0 + draws);
  return test;
}

}  // namespace gustlab::diagnosis
