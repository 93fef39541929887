#include "diagnosis/validation/remainder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/trims.hpp"
#include "diagnosis/validation/dependence.hpp"
#include "diagnosis/validation/generic_bases.hpp"
#include "util/quantiles.hpp"

namespace gustlab::diagnosis {

using namespace decisions;

namespace {

constexpr std::array<const char*, 12> sensor_name = {"position x",
                                                     "position y",
                                                     "position z",
                                                     "roll",
                                                     "pitch",
                                                     "yaw",
                                                     "roll rate",
                                                     "pitch rate",
                                                     "yaw rate",
                                                     "specific force x",
                                                     "specific force y",
                                                     "specific force z"};

// the disturbance groups in words, and their channels
constexpr std::array<const char*, disturbance_groups> group_name = {"horizontal force", "vertical force",
                                                                    "roll/pitch torque", "yaw torque"};
const std::array<std::vector<std::string>, disturbance_groups> channels_of = {
    {{"force_x", "force_y"}, {"force_z"}, {"torque_x", "torque_y"}, {"torque_z"}}};

// generic functions of everything that was recorded, beside what was found and small trims
void ask_generic_bases(const Session& session, const Selection& selection, const std::vector<int>& columns,
                       Remainder& result) {
  const double rows = selection.degrees_of_freedom;
  const std::vector<Trim> trims = trims_beside(session, columns, scatter_share);
  double worst = 0.0;
  std::vector<BasisFamily> families = omnibus_bases(session);
  for (BasisFamily& family : channel_bases(session)) families.push_back(std::move(family));
  const std::vector<FamilyDeltaChi2> delta_chi2 = delta_chi2_of_families(session, families, columns, trims);
  for (std::size_t i = 0; i < families.size(); ++i) {
    const BasisFamily& family = families[i];
    const bool smooth = family.name.starts_with("smooth");
    // what moves slowly is like any slow function of place and time
    if (result.gust_like && (smooth ? family.channel.front() < 2 : family.name == "position" || family.name == "time"))
      continue;
    if (!beyond_chance(delta_chi2[i].all, family.size, rows)) continue;
    worst = std::max(worst, delta_chi2[i].all);
    Alarm alarm{"omnibus", fmt::format("what is left depends on {}", family.name), delta_chi2[i].all / rows, {}};
    const double most = *std::max_element(delta_chi2[i].channel.begin(), delta_chi2[i].channel.end());
    for (std::size_t c = 0; c < channel_name.size(); ++c)
      if (beyond_chance(delta_chi2[i].channel[c], delta_chi2[i].size[c], rows) &&
          delta_chi2[i].channel[c] > least_channel_of_alarm * most)
        alarm.channels.emplace_back(channel_name[c]);
    if (smooth) {
      const std::string& where = alarm.channels.front();
      if (std::any_of(result.alarms.begin(), result.alarms.end(), [&](const Alarm& a) {
            return std::find(a.channels.begin(), a.channels.end(), where) != a.channels.end();
          }))
        continue;
      alarm.says = fmt::format("what is left of {} follows how the vehicle moves", where);
    }
    result.alarms.push_back(std::move(alarm));
  }
  result.gust_like = result.gust_like && worst == 0.0;
  const double explained = std::max(0.0, selection.loss_nominal - selection.loss_selected);
  result.omnibus_share = worst > 0.0 ? worst / (worst + explained) : 0.0;
}

// autocorrelation of the whitened innovations over 25 lags
void ask_whiteness(const Session& session, const NoiseModel& noise, const std::vector<int>& columns,
                   Remainder& result) {
  const Fit fit = solve(session.grams(columns).total(), columns);
  const auto whitened = session.innovations(columns, fit.coefficient);
  const auto correlated = lag_correlation(whitened, 25);
  const bool own_rate = std::none_of(session.flights().begin(), session.flights().end(),
                                     [](const FlightData& f) { return f.read_slower; });
  for (std::size_t c = 0; c < row_count; ++c) {
    // a gust is not quite what the filter has for it
    if (std::isnan(correlated[0][c]) || (result.gust_like && (c < 3 || c > 8))) continue;
    const auto most = std::max_element(correlated.begin(), correlated.end(),
                                       [c](const auto& a, const auto& b) { return std::abs(a[c]) < std::abs(b[c]); });
    const double r = std::abs((*most)[c]);
    const auto lag = most - correlated.begin() + 1;
    if (r > (noise.errors_last() ? most_correlation_of_lasting : most_correlation) && own_rate)
      result.alarms.push_back({"whiteness",
                               fmt::format("what the model does not predict of {} is alike over {} sample{}",
                                           sensor_name[c], lag, lag == 1 ? "" : "s"),
                               0.01 * r,
                               {channel_name[c % 3 + (c < 3 || c > 8 ? 0 : 3)]},
                               sensor_name[c]});
  }
}

// disturbance above what a calm room leaves
void ask_floor(const Session& session, const NoiseModel& noise, Remainder& result) {
  const auto floor = reference_floor(session.vehicle());
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    // half a second ahead shows what lasts: its spectral density against that of a calm room's air
    const double lasting = std::sqrt(noise.variance[g] * noise.time_s[g] / calm_memory_s) / floor[g],
                 ratio = std::max(noise.rms(g) / floor[g], lasting);
    if (ratio > most_of_floor && !(g < 2 && result.gust_like))
      result.alarms.push_back({"floor",
                               fmt::format("{} is disturbed {:.1f} times as much as in a calm room{}", group_name[g],
                                           ratio, ratio == lasting ? ", slowly" : ""),
                               0.001 * ratio, channels_of[g]});
  }
}

// blocks of the flights: what was done in each, and how large the disturbance was
struct Stretches {
  std::vector<double> activity, speed, depth;
  std::array<std::vector<double>, disturbance_groups> energy;
};

Stretches stretches_of(const Session& session, const std::vector<Smoothed>& smoothed) {
  Stretches result;
  for (std::size_t f = 0; f < session.flights().size(); ++f) {
    const FlightData& flight = session.flights()[f];
    const auto length = static_cast<std::size_t>(std::max(1.0, std::round(block_s / flight.sample_s)));
    const CommandRecord& record = flight.rotor_record();
    for (std::size_t first = 1; first + length <= flight.samples.size(); first += length) {
      std::array<double, disturbance_groups> e{};
      double change = 0.0, fast = 0.0, high = 0.0;
      for (std::size_t k = first; k < first + length; ++k) {
        for (std::size_t j = 0; j < 6; ++j)
          e[static_cast<std::size_t>(disturbance_group[j])] +=
              std::pow(smoothed[f].disturbance[k][static_cast<Eigen::Index>(j)], 2);
        const double t = flight.samples[k].time_s;
        const RotorArray now = record.mean(t - flight.sample_s, t),
                         old = record.mean(t - 2.0 * flight.sample_s, t - flight.sample_s);
        for (std::size_t i = 0; i < max_rotors; ++i) change += std::pow(now[i] - old[i], 2);
        fast += flight.motion[k].velocity_W_mps.norm();
        high += flight.motion[k].position_W_m.z();
      }
      result.activity.push_back(std::sqrt(change));
      result.speed.push_back(fast);
      result.depth.push_back(-high);
      for (std::size_t g = 0; g < disturbance_groups; ++g)
        result.energy[g].push_back(e[g] / static_cast<double>(length * channels_of[g].size()));
    }
  }
  return result;
}

// disturbance that grows with the state: dynamics that linear bases cannot follow
void ask_growth(const Session& session, const Selection& selection, Remainder& result) {
  const auto floor = reference_floor(session.vehicle());
  const Stretches stretches = stretches_of(session, selection.smoothed_selected);
  for (std::size_t g = 0; g < disturbance_groups; ++g) {
    const std::vector<double>& energy = stretches.energy[g];
    for (const auto& [name, x] :
         {std::pair<const char*, const std::vector<double>*>{"command activity", &stretches.activity},
          {"speed", &stretches.speed},
          {"low height", &stretches.depth}}) {
      const double r = correlation(ranks(energy), ranks(*x));
      const std::vector<std::size_t> order = ascending(*x);
      const std::size_t quarter = order.size() / 4;
      double low = 1e-300, high = 0.0;
      for (std::size_t i = 0; i < quarter; ++i) {
        low += energy[order[i]];
        high += energy[order[order.size() - 1 - i]];
      }
      // where it is largest it must be more than a calm room's
      if (r > growth_correlation && high > growth_ratio * low &&
          std::sqrt(high / static_cast<double>(quarter)) > floor[g]) {
        if (g == 0) result.gust_like = false;
        result.alarms.push_back({"heteroscedastic", fmt::format("{} grows with {}", group_name[g], name),
                                 0.001 * high / low, channels_of[g]});
        break;
      }
    }
  }
}

}  // namespace

bool beyond_chance(double delta_chi2, int size, double rows) {
  return delta_chi2 > size + beyond_chance_sd * std::sqrt(2.0 * size) + beyond_chance_share * rows;
}

// A gust lasts longer than the air of a calm room, or has a line; it does not depend on where the vehicle is.
Remainder lasting_push(const Session& session, const Selection& selection, bool force_withdrawn) {
  Remainder result;
  const auto floor = reference_floor(session.vehicle());
  result.gust = gust_parts(session, selection.smoothed_selected);
  const bool slow = result.gust.slow_mps2 > least_slow_share * floor[0] && result.gust.time_s > fastest_gust_s &&
                    result.gust.time_s < slowest_gust_s;
  // a line below a calm room's disturbance may be the flown figure's own, and so may a small part of what the vehicle does
  const bool line = result.gust.line_mps2 > floor[0] && !result.gust.line_of_motion;
  if (!line) result.gust.line_mps2 = 0.0;
  if (!slow) result.gust.horizontal_mps2 = 0.0;
  result.depends_on_state = (slow || line) && depends_on_state(session, selection.smoothed_selected);
  if (result.depends_on_state)
    result.alarms.push_back(
        {"omnibus", "horizontal force depends on where or how fast the vehicle is", 0.0, channels_of[0]});
  result.gust_like = !force_withdrawn && (slow || line) && !result.depends_on_state;
  return result;
}

void ask_rest(const Session& session, const Selection& selection, Remainder& result) {
  const std::vector<int> columns = session.with_biases(selection.groups());
  ask_generic_bases(session, selection, columns, result);
  ask_whiteness(session, selection.noise_selected, columns, result);
  ask_floor(session, selection.noise_selected, result);
  ask_growth(session, selection, result);
  const GustParts& gust = result.gust;
  result.names_gust = result.gust_like && (gust.line_mps2 > 0.0 || gust.time_s > longest_of_rough_air_s ||
                                           gust.horizontal_mps2 > least_sideways * gust.vertical_mps2);
}

}  // namespace gustlab::diagnosis
