// Speed of sparse regression on a problem of the paper's size: 20,000 samples, its 7 terms, 3 targets, 2 constraints.
//
// scripts/compare_pysindy.py makes the same numbers by the same formulas, runs PySINDy on them, and compares both the
// time and the coefficients, which are counters here. Each time includes the pass over the samples.
#include <benchmark/benchmark.h>

#include <cmath>
#include <string>
#include <vector>

#include "identification/optimizer.hpp"
#include "identification/synthetic.hpp"

namespace {

using namespace gustlab;

constexpr Eigen::Index samples = 20000;

struct Problem {
  Eigen::MatrixXd theta, target;
  LinearConstraints constraints;
};

const Problem& problem() {
  static const Problem made = [] {
    Problem p;
    p.theta = feature_matrix(make_library("paper"), rocking_flight(samples));
    Eigen::MatrixXd truth = Eigen::MatrixXd::Zero(3, 7);
    truth(0, 0) = 0.5;
    truth(0, 3) = -0.4;
    truth(1, 5) = 0.35;
    truth(2, 0) = -0.8;
    truth(2, 4) = 0.03;
    p.target = p.theta * truth.transpose();
    for (Eigen::Index i = 0; i < samples; ++i) {
      for (Eigen::Index t = 0; t < 3; ++t) p.target(i, t) += 0.2 * spread(i, 11.0 + 2.0 * static_cast<double>(t));
    }
    // ξ(x, T sin θ) + ξ(y, T sin φ) = 0 and ξ(y, 1) = 0
    p.constraints.C = Eigen::MatrixXd::Zero(2, 21);
    p.constraints.C(0, 3) = p.constraints.C(0, 7 + 5) = 1.0;
    p.constraints.C(1, 7) = 1.0;
    p.constraints.d = Eigen::Vector2d::Zero();
    return p;
  }();
  return made;
}

// one pass over the samples, then a fit for each λ; the counters are of the last one, iterations of all
void run(benchmark::State& state, OptimizerOptions options, const std::vector<double>& lambdas) {
  const Problem& p = problem();
  options.constraints = p.constraints;
  Fit found;
  int iterations = 0;
  for (auto _ : state) {
    iterations = 0;
    const RegressionData data(p.theta, p.target);
    for (double lambda : lambdas) {
      options.lambda = lambda;
      found = sr3(data, options);
      iterations += found.iterations;
    }
  }
  for (Eigen::Index t = 0; t < 3; ++t) {
    for (Eigen::Index j = 0; j < 7; ++j) {
      state.counters["c" + std::to_string(t) + std::to_string(j)] = found.coefficients(t, j);
    }
  }
  state.counters["sr3_iterations"] = iterations;
}

// names and numbers as in scripts/compare_pysindy.py

// a ν so small that it takes thousands of iterations
void constrained_sr3_l0_small_nu(benchmark::State& state) {
  run(state, {.nu = 1e-3, .penalty = Regularizer::l0, .tolerance = 1e-5}, {0.1});
}
void constrained_sr3_l1_small_nu(benchmark::State& state) {
  run(state, {.nu = 1e-3, .penalty = Regularizer::l1, .tolerance = 1e-5}, {0.1});
}
// PySINDy's defaults, once and for a choice among 40 λ
void constrained_sr3_l0_default(benchmark::State& state) {
  run(state, {.tolerance = 1e-5, .max_iterations = 30}, {0.005});
}
void constrained_sr3_l0_40_lambdas(benchmark::State& state) {
  std::vector<double> lambdas;
  for (int k = 39; k >= 0; --k) lambdas.push_back(0.005 * std::pow(1.2, k));
  run(state, {.tolerance = 1e-5, .max_iterations = 30}, lambdas);
}
BENCHMARK(constrained_sr3_l0_small_nu)->Unit(benchmark::kMillisecond);
BENCHMARK(constrained_sr3_l1_small_nu)->Unit(benchmark::kMillisecond);
BENCHMARK(constrained_sr3_l0_default)->Unit(benchmark::kMillisecond);
BENCHMARK(constrained_sr3_l0_40_lambdas)->Unit(benchmark::kMillisecond);

}  // namespace
