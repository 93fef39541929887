#include "diagnosis/estimation/noise_model.hpp"

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>

namespace gustlab::diagnosis {

bool NoiseModel::possible() const {
  const auto quick = [](double t) { return t <= slowest_disturbance_s; };
  return std::all_of(time_s.begin(), time_s.end(), quick) &&
         std::all_of(lasting_time_s.begin(), lasting_time_s.end(), quick) &&
         std::equal(white.begin(), white.end(), least_white.begin(), std::greater_equal<>());
}

double NoiseModel::rms(std::size_t group) const {
  if (errors_last() && group < 2)
    return std::sqrt((variance[group] * time_s[group] + 0.5 * white[group]) / calm_memory_s);
  return std::sqrt(variance[group] + white[group] / (2.0 * white_mean_s(group)));
}

namespace {

// Of slow parts with one law, over all flights: expected squares, and products of one sample and the next.
struct Memory {
  double second = 0.0, earlier = 0.0, later = 0.0, lagged = 0.0, count = 0.0, pairs = 0.0;

  // The likeliest variance of a stationary first-order process, given how it is correlated from one sample to the next.
  double variance(double correlation) const {
    const double a = correlation, steps = later - 2.0 * a * lagged + a * a * earlier;
    return std::max((second - later + steps / (1.0 - a * a)) / count, 1e-12);
  }

  // The likeliest correlation in a range: where −2 log likelihood, count log variance + pairs log(1 − a²), is least.
  double correlation(double least, double most) const {
    const double starts = count - pairs, of_starts = second - later;
    const auto slope = [&](double a) {
      const double curvature = earlier - of_starts;
      return count * (a * curvature - lagged) * (1.0 - a * a) +
             a * starts * (second - 2.0 * a * lagged + a * a * curvature);
    };
    if (slope(least) >= 0.0) return least;
    if (slope(most) <= 0.0) return most;
    std::uintmax_t iterations = 100;
    const auto [below, above] =
        boost::math::tools::toms748_solve(slope, least, most, boost::math::tools::eps_tolerance<double>(), iterations);
    return 0.5 * (below + above);
  }
};

template <class Belongs>
std::optional<Memory> memory(const std::vector<Smoothed>& flights, const Belongs& belongs) {
  Memory sum;
  for (const Smoothed& f : flights)
    for (std::size_t j = 0; j < f.second.size(); ++j)
      if (belongs(j)) {
        sum.second += f.second[j], sum.earlier += f.earlier[j], sum.later += f.later[j];
        sum.lagged += f.lagged[j], sum.count += f.count[j], sum.pairs += f.pairs[j];
      }
  if (sum.count == 0.0) return std::nullopt;
  return sum;
}

}  // namespace

NoiseModel update(const NoiseModel& noise, const std::vector<Smoothed>& flights, double sample_s) {
  NoiseModel next = noise;
  // the likeliest law of a slow part
  const auto learn = [&](const Memory& slow, double least_s, double& variance, double& time_s) {
    const auto decay = [&](double t) { return std::exp(-sample_s / t); };
    const double correlation = slow.correlation(decay(least_s), decay(slowest_disturbance_s));
    variance = slow.variance(correlation);
    time_s = std::clamp(-sample_s / std::log(correlation), least_s, slowest_disturbance_s);
  };
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    const auto ours = [g](std::size_t j) { return j < 6 && disturbance_group[j] == static_cast<int>(g); };
    const auto slow = memory(flights, ours);
    if (!slow) continue;
    double white = 0.0, pairs = 0.0;
    for (const Smoothed& f : flights)
      for (std::size_t j = 0; j < 6; ++j)
        if (ours(j)) white += f.white[j], pairs += f.pairs[j];
    next.white[g] = std::max(white / pairs, noise.least_white[g]);
    // what is faster is the white part's, where there is one
    learn(*slow, white > 0.0 ? 0.04 : 0.004, next.variance[g], next.time_s[g]);
  }
  for (std::size_t g = 0; g < noise_groups && noise.errors_last(); ++g) {
    const auto error = memory(flights, [g](std::size_t j) { return j / 3 == g + 2; });
    if (!error) continue;
    learn(*error, 0.2 * sample_s, next.lasting_variance[g], next.lasting_time_s[g]);
  }
  for (std::size_t g = 0; g < noise_groups; ++g) {
    double sum = 0.0, count = 0.0;
    for (const Smoothed& f : flights) sum += f.residual[g], count += f.residual_count[g];
    if (count > 0.0) next.measurement[g] = std::max(sum / count, 1e-14);
  }
  return next;
}

double largest_change(const NoiseModel& before, const NoiseModel& after) {
  double most = 0.0;
  const auto compare = [&](const auto& from, const auto& to) {
    for (std::size_t i = 0; i < from.size(); ++i)
      if (from[i] > 0.0) most = std::max(most, std::abs(std::log(to[i] / from[i])));
  };
  compare(before.variance, after.variance);
  compare(before.time_s, after.time_s);
  compare(before.white, after.white);
  compare(before.measurement, after.measurement);
  compare(before.lasting_variance, after.lasting_variance);
  compare(before.lasting_time_s, after.lasting_time_s);
  return most;
}

NoiseModel extrapolated(const NoiseModel& first, const NoiseModel& second, const NoiseModel& third) {
  constexpr double slowest = 0.95, farthest = 1.5;
  // the limit of a geometric series
  const auto limit = [&](double a, double b, double c) {
    const double before = std::log(b / a), last = std::log(c / b);
    const double rate = before * last > 0.0 ? std::min(last / before, slowest) : 0.0;
    return c * std::exp(std::clamp(last * rate / (1.0 - rate), -farthest, farthest));
  };
  NoiseModel result = third;
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    result.variance[g] = limit(first.variance[g], second.variance[g], third.variance[g]);
    result.time_s[g] = std::min(limit(first.time_s[g], second.time_s[g], third.time_s[g]), slowest_disturbance_s);
    result.white[g] = std::max(limit(first.white[g], second.white[g], third.white[g]), third.least_white[g]);
  }
  for (std::size_t g = 0; g < noise_groups && third.errors_last(); ++g) {
    result.lasting_variance[g] =
        limit(first.lasting_variance[g], second.lasting_variance[g], third.lasting_variance[g]);
    result.lasting_time_s[g] = std::min(
        limit(first.lasting_time_s[g], second.lasting_time_s[g], third.lasting_time_s[g]), slowest_disturbance_s);
  }
  for (std::size_t g = 0; g < noise_groups; ++g)
    result.measurement[g] = limit(first.measurement[g], second.measurement[g], third.measurement[g]);
  return result;
}

}  // namespace gustlab::diagnosis
