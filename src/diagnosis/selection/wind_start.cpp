#include "diagnosis/selection/wind_start.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace gustlab::diagnosis {

int force_like_wind(const Catalogue& catalogue) {
  const int wind = catalogue.find(Airflow::wind);
  return wind < 0 ? -1 : catalogue.find(catalogue.group(wind).row->stand_in);
}

std::vector<StartedSet> winds_instead(const Catalogue& catalogue, const std::vector<int>& groups,
                                      const Eigen::VectorXd& value) {
  std::vector<StartedSet> sets;
  const auto& all = catalogue.groups();
  const auto column = [&](int c) -> const Column& { return catalogue.column(c); };
  const int wind = catalogue.find(Airflow::wind), force = force_like_wind(catalogue),
            linear = catalogue.find(Airflow::drag);
  if (force < 0 || linear < 0) return sets;
  const double c_Nspm = value[all[static_cast<std::size_t>(linear)].columns.front()];
  if (!(c_Nspm > 0.0)) return sets;
  const auto& force_columns = all[static_cast<std::size_t>(force)].columns;
  const auto is_drag = [&](int g) { return all[static_cast<std::size_t>(g)].row->air == Airflow::drag; };

  for (int drag = 0; drag < static_cast<int>(all.size()); ++drag) {
    const Group& group = all[static_cast<std::size_t>(drag)];
    if (!is_drag(drag) || !group.candidate || group.columns.empty()) continue;
    StartedSet set{groups, value};
    std::erase_if(set.groups, [&](int g) { return g == force || is_drag(g); });
    set.groups.push_back(drag);
    set.groups.push_back(wind);
    std::sort(set.groups.begin(), set.groups.end());

    const double per_c = drag == linear ? 1.0 : 2.0;
    std::map<int, double> squares;  // of a flight's wind
    for (const int w : all[static_cast<std::size_t>(wind)].columns) {
      const auto same = std::find_if(force_columns.begin(), force_columns.end(), [&](int f) {
        return column(f).flight == column(w).flight && column(f).parameter == column(w).parameter;
      });
      set.value[w] = same == force_columns.end() ? 0.0 : per_c * value[*same] / c_Nspm;
      squares[column(w).flight] += set.value[w] * set.value[w];
    }
    for (const int f : force_columns) set.value[f] = column(f).nominal;
    for (int g = 0; g < static_cast<int>(all.size()); ++g)
      if (is_drag(g) && g != drag)
        for (const int c : all[static_cast<std::size_t>(g)].columns) set.value[c] = column(c).nominal;
    if (drag != linear) {
      double speed = 0.0;
      for (const auto& [flight, square] : squares) speed += std::sqrt(square) / static_cast<double>(squares.size());
      for (const int c : group.columns) set.value[c] = c_Nspm / (air_density_kgpm3 * std::max(speed, 1.0));
    }
    catalogue.clamp(set.value);
    sets.push_back(std::move(set));
  }
  return sets;
}

}  // namespace gustlab::diagnosis
