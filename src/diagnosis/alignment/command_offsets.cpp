#include "diagnosis/alignment/command_offsets.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>

#include "diagnosis/estimation/session.hpp"
#include "diagnosis/recording/log_checks.hpp"
#include "diagnosis/recording/vehicle_check.hpp"
#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

// −2 log likelihood of one flight, its commands read some time later, each with the noise that fits it best
double misfit(FlightData flight, const VehicleModel& vehicle, double later_s) {
  // whenever they are read, of the same samples
  flight = without_spin_up(std::move(flight), 2.0 * spin_up_s);
  flight.delay_inputs(later_s);
  std::vector<FlightData> one;
  one.push_back(std::move(flight));
  Session session(std::move(one), vehicle, 1);
  // a lag is no delay: it is late by more in slow turns than in quick ones
  const std::vector<int> free = session.with_biases({session.catalogue().find(Place::actuation, Latency::lag)});
  session.linearise(session.value(), free);
  session.learn_noise(5, free);
  const Fit fit = solve(session.grams(free).total(), free);
  return session.innovations(free, fit.coefficient).front().minus_two_log_likelihood;
}

}  // namespace

bool is_likeliest(double later_s, const std::function<double(double)>& gain) {
  const double most = gain(later_s);
  return most >= decisions::least_offset_gain &&
         std::ranges::all_of(std::array{0.5, 1.5}, [&](double share) { return gain(share * later_s) <= most; });
}

std::vector<double> command_offsets(const std::vector<FlightData>& fit, const std::vector<FlightData>& held,
                                    const VehicleModel& vehicle, std::vector<LogFinding>& findings) {
  std::vector<const FlightData*> all;
  for (const FlightData& f : fit) all.push_back(&f);
  for (const FlightData& f : held) all.push_back(&f);
  std::vector<std::optional<double>> delay;
  for (const FlightData* f : all) delay.push_back(torque_delay_s(*f, vehicle));
  double least = std::numeric_limits<double>::infinity();
  std::size_t promptest = 0;
  for (std::size_t i = 0; i < delay.size(); ++i)
    if (delay[i] && *delay[i] < least) least = *delay[i], promptest = i;
  std::map<std::pair<std::size_t, double>, double> asked;  // of a flight whose commands are read so much later
  const auto misfit_of = [&](std::size_t i, double later_s) {
    const auto [at, fresh] = asked.try_emplace({i, later_s});
    if (fresh) at->second = misfit(*all[i], vehicle, later_s);
    return at->second;
  };
  std::vector<double> offset(all.size(), 0.0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    // parts of one recording have one clock
    if (all[i]->file == all[promptest]->file) continue;
    if (!delay[i] || *delay[i] - least <= decisions::least_offset_samples * all[i]->sample_s) continue;
    // a controller that answers sensor noise moves the correlation's peak, not the likelihood's; a lag that all flights share
    // moves both, but then the promptest flight does not refute later commands, either
    const auto gain_of = [&](std::size_t flight, double at_s) {
      return misfit_of(flight, 0.0) - misfit_of(flight, at_s);
    };
    const auto gain = [&](double at_s) { return gain_of(i, at_s); };
    // the peak of a correlation is near the likeliest
    const double about_s = *delay[i] - least;
    const double later_s = std::ranges::max(std::array{0.75 * about_s, about_s, 1.25 * about_s}, {}, gain);
    if (!is_likeliest(later_s, gain) || gain_of(promptest, later_s) > -decisions::least_offset_loss) continue;
    offset[i] = later_s;
    findings.push_back({all[i]->label, "u1…uN", "delay", all[i]->start_s, all[i]->start_s + all[i]->duration_s(),
                        fmt::format("the vehicle answers its rotors {:.0f} ms later than in the promptest flight: "
                                    "commands are read that much later",
                                    1e3 * offset[i]),
                        false, false});
  }
  return offset;
}

}  // namespace gustlab::diagnosis
