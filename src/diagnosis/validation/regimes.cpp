#include "diagnosis/validation/regimes.hpp"

#include <algorithm>
#include <array>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numeric>

#include "diagnosis/result/decisions.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

namespace {

using decisions::block_s;
constexpr int thirds = 3;
constexpr double few = 4.0, not_known = 1.0;  // clusters; a deviation

struct Variables {
  std::vector<std::string> name = {"speed", "vertical speed", "height",           "x",   "y",
                                   "tilt",  "thrust",         "command activity", "time"};
  std::vector<std::vector<double>> value;  // per variable, per block
};

Variables variables_of(const Session& session, const Grams& grams) {
  Variables result;
  result.value.assign(result.name.size(), std::vector<double>(grams.block.size(), 0.0));
  for (std::size_t b = 0; b < grams.block.size(); ++b) {
    const FlightData& flight = session.flights()[static_cast<std::size_t>(grams.flight[b])];
    const CommandRecord& record = flight.rotor_record();
    const auto first = std::lower_bound(flight.samples.begin(), flight.samples.end(), grams.time_s[b],
                                        [](const Sample& s, double t) { return s.time_s < t; }) -
                       flight.samples.begin();
    std::array<double, 9> sum{};
    double count = 0.0;
    for (auto k = static_cast<std::size_t>(first);
         k < flight.samples.size() && flight.samples[k].time_s < grams.time_s[b] + block_s; ++k) {
      const Motion& m = flight.motion[k];
      const double t = flight.samples[k].time_s;
      const RotorArray now = record.mean(t, t + flight.sample_s), old = record.mean(t - flight.sample_s, t);
      double thrust = 0.0, change = 0.0;
      for (std::size_t i = 0; i < max_rotors; ++i) thrust += now[i] * now[i], change += std::pow(now[i] - old[i], 2);
      const std::array<double, 9> here = {m.velocity_W_mps.norm(),
                                          m.velocity_W_mps.z(),
                                          m.position_W_m.z(),
                                          m.position_W_m.x(),
                                          m.position_W_m.y(),
                                          -(m.attitude_WB * Vector3::UnitZ()).z(),
                                          thrust,
                                          change,
                                          t - flight.start_s};
      for (std::size_t v = 0; v < sum.size(); ++v) sum[v] += here[v];
      count += 1.0;
    }
    for (std::size_t v = 0; v < sum.size(); ++v) result.value[v][b] = sum[v] / std::max(1.0, count);
  }
  return result;
}

// of a finding, per block: information that its pattern gives, and how much of that the whole fit leaves
struct Information {
  std::vector<double> information, remaining;
  double all = 0.0;
};

Information information_of(const Session& session, const Selection& selection, const Finding& finding) {
  const Catalogue& catalogue = session.catalogue();
  const Grams& grams = selection.grams;
  Eigen::VectorXd own = Eigen::VectorXd::Zero(grams.columns + 1), left = own;
  left[grams.columns] = 1.0;
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.column(c);
    const double coefficient = (selection.value[c] - column.nominal) / column.natural;
    left[c] = -coefficient;
    if (column.group == finding.group) own[c] = coefficient;
  }
  Information known;
  for (std::size_t b = 0; b < grams.block.size(); ++b) {
    const Eigen::VectorXd pattern = grams.known[b] ? Eigen::VectorXd::Zero(own.size()) : (grams.block[b] * own).eval();
    known.information.push_back(pattern.dot(own));
    known.remaining.push_back(pattern.dot(left));
  }
  known.all = std::accumulate(known.information.begin(), known.information.end(), 0.0);
  return known;
}

// standard error of a finding's size in one part of the blocks, clustered
double deviation_in(const Grams& grams, const Information& known, const std::vector<int>& part, int p, double share,
                    double information) {
  std::vector<double> cluster(static_cast<std::size_t>(grams.clusters), 0.0), clustered = cluster;
  for (std::size_t b = 0; b < part.size(); ++b)
    if (part[b] == p) {
      cluster[static_cast<std::size_t>(grams.cluster[b])] += known.remaining[b] - (share - 1.0) * known.information[b];
      clustered[static_cast<std::size_t>(grams.cluster[b])] += known.information[b];
    }
  double variance = 0.0, squares = 0.0;
  for (const double c : cluster) variance += c * c;
  for (const double i : clustered) squares += i * i;
  // what few clusters say has no error that they could show
  return information * information > few * squares ? std::sqrt(variance) / information : not_known;
}

// the finding's size where one variable is low, middling and high, each part with as much information
Regimes regimes_along(const std::string& variable, const std::vector<double>& value, const Grams& grams,
                      const Information& known) {
  const std::vector<std::size_t> order = ascending(value);
  Regimes regimes;
  regimes.variable = variable;
  std::array<double, thirds> info{}, score{};
  std::vector<int> part(order.size());
  double before = 0.0;
  for (const std::size_t b : order) {
    part[b] = std::min(thirds - 1, static_cast<int>(before / known.all * thirds));
    before += known.information[b];
    info[static_cast<std::size_t>(part[b])] += known.information[b];
    score[static_cast<std::size_t>(part[b])] += known.remaining[b];
  }
  for (std::size_t p = 0; p < thirds; ++p) {
    regimes.share.push_back(info[p] > 0.0 ? 1.0 + score[p] / info[p] : 1.0);
    regimes.deviation.push_back(deviation_in(grams, known, part, static_cast<int>(p), regimes.share[p], info[p]));
  }
  const double mean = std::accumulate(regimes.share.begin(), regimes.share.end(), 0.0) / thirds;
  double between = 0.0, expected = 0.0;
  for (std::size_t p = 0; p < thirds; ++p) {
    between += std::pow(regimes.share[p] - mean, 2) / (thirds - 1);
    expected += std::pow(regimes.deviation[p], 2) / thirds;
    regimes.chi_squared += std::pow((regimes.share[p] - mean) / regimes.deviation[p], 2);
  }
  regimes.spread = std::sqrt(std::max(0.0, between - expected));
  return regimes;
}

std::vector<Regimes> regimes_of(const Session& session, const Selection& selection, const Finding& finding,
                                const Variables& variables) {
  std::vector<Regimes> result;
  const Information known = information_of(session, selection, finding);
  if (!(known.all > 0.0)) return result;
  for (std::size_t v = 0; v < variables.name.size(); ++v)
    result.push_back(regimes_along(variables.name[v], variables.value[v], selection.grams, known));
  std::stable_sort(result.begin(), result.end(),
                   [](const Regimes& a, const Regimes& b) { return a.spread > b.spread; });
  return result;
}

}  // namespace

std::vector<std::vector<Regimes>> regimes(const Session& session, const Selection& selection) {
  std::vector<std::vector<Regimes>> result;
  if (selection.findings.empty()) return result;
  const Variables variables = variables_of(session, selection.grams);
  for (const Finding& finding : selection.findings)
    result.push_back(regimes_of(session, selection, finding, variables));
  return result;
}

double most_astray(const std::vector<Regimes>& regimes) {
  double most = 0.0;
  std::size_t known = 0;
  for (const Regimes& r : regimes) {
    if (std::find(r.deviation.begin(), r.deviation.end(), not_known) != r.deviation.end()) continue;
    ++known;
    double expected = 0.0;
    for (const double d : r.deviation) expected += d * d / thirds;
    most = std::max(most, std::sqrt(r.spread * r.spread + 2.0 * expected * std::sqrt(2.0 / (thirds - 1))));
  }
  return 2 * known > regimes.size() ? most : not_known;
}

double surely_astray(const std::vector<Regimes>& regimes) {
  const double chance = decisions::uneven_p / static_cast<double>(std::max<std::size_t>(1, regimes.size()));
  const double least = boost::math::quantile(boost::math::complement(boost::math::chi_squared(thirds - 1.0), chance));
  double most = 0.0;
  for (const Regimes& r : regimes)
    if (std::ranges::count(r.deviation, not_known) == 0 && r.chi_squared > least) most = std::max(most, r.spread);
  return most;
}

}  // namespace gustlab::diagnosis
