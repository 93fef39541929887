#include "diagnosis/alignment/hold.hpp"

#include "diagnosis/estimation/session.hpp"

namespace gustlab::diagnosis {

bool linear_is_likelier(const VehicleModel& vehicle, int jobs,
                        const std::function<std::vector<FlightData>(bool linear)>& read) {
  double misfit[2];
  for (const bool linear : {false, true}) {
    Session session(read(linear), vehicle, jobs);
    session.linearise(session.value(), session.all_columns());
    session.learn_noise(6, session.all_columns());
    const Eigen::MatrixXd total = session.grams().total();
    const std::vector<int>& columns = session.all_columns();
    Fit fit = solve(total, columns, 1e-4);
    // no vehicle answers before it is asked
    std::vector<int> causal;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const Column& column = session.catalogue().column(columns[i]);
      const bool way = column.group >= 0 && session.catalogue().group(column.group).row->place == Place::actuation;
      if (!way || column.admits(column.nominal + fit.coefficient[static_cast<Eigen::Index>(i)] * column.natural))
        causal.push_back(columns[i]);
    }
    if (causal.size() < columns.size()) fit = solve(total, causal, 1e-4);
    misfit[linear] = session.misfit(causal, fit.coefficient);
  }
  return misfit[true] < misfit[false];
}

}  // namespace gustlab::diagnosis
