#include "diagnosis/selection/suspect_histories.hpp"

#include <algorithm>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/limit_scan.hpp"
#include "diagnosis/selection/pendulum.hpp"

namespace gustlab::diagnosis {

void suspect_histories(Session& session, const Eigen::VectorXd& value, const std::vector<int>& chosen) {
  const Catalogue& catalogue = session.catalogue();
  bool stale = false;
  std::vector<int> others = chosen;
  if (!chosen.empty()) {
    Eigen::VectorXd bare = value;
    if (const int load = catalogue.find(ColumnFrom::swing); std::erase(others, load) > 0) {
      for (const int c : columns_of(catalogue, {load})) bare[c] = 0.0;
      session.linearise(bare, session.all_columns());
      stale = true;
    }
    session.learn_noise(2, session.with_biases(others));
  }
  const PendulumScan load = scan_pendulum(session);
  const bool limited = std::find(chosen.begin(), chosen.end(), catalogue.find(ColumnFrom::speed_limit)) != chosen.end();
  const LimitScan limit = limited ? LimitScan{} : scan_limit(session, session.with_biases(others));
  if (load.share > decisions::least_load_share) {
    std::vector<std::vector<Vector3>> force(session.flights().size());
    session.for_each_flight([&](std::size_t f) {
      const FlightData& flight = session.flights()[f];
      force[f] = load.starts.empty()
                     ? pendulum_force(flight, session.smoothed[f], session.vehicle().mass_kg, load.swing, load.mass_kg)
                     : swinging_force(flight, load.swing, load.starts[f]);
    });
    session.suspect_load(load.swing, std::move(force));
    stale = true;
  }
  if (limit.delta_chi2 > decisions::least_limit_delta_chi2) {
    session.suspect_limit(limit.limit_radps);
    stale = true;
  }
  if (stale) session.linearise(value, session.all_columns());
}

void suspect_histories_found(const Session& fitted, const Selection& selection, Session& session) {
  const int load = fitted.catalogue().find(ColumnFrom::swing);
  if (load >= 0 && selection.find(load)) {
    const Group& group = fitted.catalogue().group(load);
    session.linearise(session.catalogue().nominal(), {});
    session.learn_noise(1, {});
    session.noise = selection.noise_selected;
    std::vector<std::vector<Vector3>> force;
    for (std::size_t f = 0; f < session.flights().size(); ++f)
      force.push_back(pendulum_force(session.flights()[f], session.smoothed[f], session.vehicle().mass_kg, group.swing,
                                     selection.value[group.columns.front()]));
    session.suspect_load(group.swing, std::move(force));
  }
  const int limit = fitted.catalogue().find(ColumnFrom::speed_limit);
  if (limit >= 0 && selection.find(limit)) session.suspect_limit(fitted.catalogue().group(limit).limit_radps);
}

}  // namespace gustlab::diagnosis
