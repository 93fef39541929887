#include "diagnosis/evidence/gather_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "diagnosis/estimation/indices.hpp"
#include "diagnosis/estimation/latency_between_rows.hpp"
#include "diagnosis/estimation/slow_and_fast.hpp"
#include "diagnosis/estimation/slow_speeds.hpp"
#include "diagnosis/estimation/surrogates.hpp"
#include "diagnosis/result/decisions.hpp"
#include "diagnosis/selection/trims.hpp"
#include "diagnosis/validation/parts.hpp"
#include "diagnosis/validation/regimes.hpp"
#include "util/parallel.hpp"

namespace gustlab::diagnosis {

namespace {

constexpr int parts_of_flight = 6;
constexpr double shortest_part_s = 4.0;

// which sixth of which flight a block of the Gram matrices belongs to
std::vector<int> clusters_of(const Session& session, const Grams& grams) {
  std::vector<int> cluster;
  for (std::size_t b = 0; b < grams.block.size(); ++b) {
    const FlightData& flight = session.flights()[static_cast<std::size_t>(grams.flight[b])];
    const double part_s = std::max(shortest_part_s, flight.duration_s() / parts_of_flight);
    cluster.push_back(
        grams.flight[b] * parts_of_flight +
        std::clamp(static_cast<int>((grams.time_s[b] - flight.start_s) / part_s), 0, parts_of_flight - 1));
  }
  return cluster;
}

// Of all columns and z: the coefficients of a finding's own columns, zero elsewhere.
Eigen::VectorXd own_weights(const Catalogue& catalogue, const Selection& selection, const Finding& finding) {
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(catalogue.size() + 1);
  for (const int c : own_columns(catalogue, selection.groups(), finding.group)) {
    const Column& column = catalogue.column(c);
    weights[c] = (selection.value[c] - column.nominal) / column.natural;
  }
  return weights;
}

std::vector<int> groups_beside(const Selection& selection, const Finding& finding) {
  std::vector<int> groups = selection.groups();
  std::erase(groups, finding.group);
  return groups;
}

// weights of all columns and z: the finding's pattern less what the others can imitate, and what the whole fit leaves
struct Weights {
  Eigen::VectorXd pattern, left;
};

Weights weights_of(const Session& session, const Selection& selection, const Eigen::MatrixXd& total,
                   const Finding& finding) {
  const Catalogue& catalogue = session.catalogue();
  const std::vector<int> known = session.with_biases(groups_beside(selection, finding));
  const Eigen::Index size = total.cols();
  Weights w{own_weights(catalogue, selection, finding), Eigen::VectorXd::Zero(size)};
  w.left[size - 1] = 1.0;
  for (int c = 0; c < catalogue.size(); ++c) {
    const Column& column = catalogue.column(c);
    w.left[c] = -(selection.value[c] - column.nominal) / column.natural;
  }
  Eigen::MatrixXd target = total;
  target.col(size - 1) = total * w.pattern;
  const Eigen::VectorXd imitated = solve(target, known).coefficient;
  for (std::size_t i = 0; i < known.size(); ++i) w.pattern[known[i]] -= imitated[static_cast<Eigen::Index>(i)];
  return w;
}

// Of a finding beside all else that was found: the share that the innovation of the commands does as well. What lasts (a shifted centre
// of mass, less thrust) is no answer to anything, and has next to none.
double share_of_innovations(const Session& session, const Selection& selection, const Eigen::MatrixXd& total,
                            const Finding& finding) {
  const Catalogue& catalogue = session.catalogue();
  std::vector<int> known, innovations;
  for (const int c : session.with_biases(groups_beside(selection, finding)))
    (catalogue.column(c).of_command_innovation() ? innovations : known).push_back(c);
  return share_done_by(total, own_weights(catalogue, selection, finding), known, innovations);
}

// shares of the effect per flight and the variance of its size between sixths of flights
void measure_flights(const Session& session, const Selection& selection, const Weights& w,
                     const std::vector<int>& cluster, Evidence& out) {
  const Grams& grams = selection.grams;
  const int flights = static_cast<int>(session.flights().size());
  struct Sum {
    double information = 0.0, left = 0.0, known = 0.0;
  };
  std::vector<Sum> of_flight(static_cast<std::size_t>(flights)),
      of_cluster(static_cast<std::size_t>(flights * parts_of_flight));
  double all = 0.0, squares = 0.0;
  for (std::size_t b = 0; b < grams.block.size(); ++b) {
    const Eigen::VectorXd seen = grams.block[b] * w.pattern;
    const double information = seen.dot(w.pattern), left = seen.dot(w.left);
    all += information;
    Sum& flight = of_flight[static_cast<std::size_t>(grams.flight[b])];
    flight.information += information, flight.left += left;
    if (grams.known[b]) {  // scatters as it is said to
      flight.known += information, squares += information;
      continue;
    }
    Sum& part = of_cluster[static_cast<std::size_t>(cluster[b])];
    part.information += information, part.left += left;
  }
  if (!(all > 0.0)) return;
  for (const Sum& sum : of_cluster) squares += sum.left * sum.left;
  out.clustered_inflation = squares / all;
  double mean = 0.0, weight = 0.0;
  for (int f = 0; f < flights; ++f) {
    const Sum& sum = of_flight[static_cast<std::size_t>(f)];
    FlightShare& share = out.flights.emplace_back();
    share.file = session.flights()[static_cast<std::size_t>(f)].label;
    if (!(sum.information > 1e-6 * all)) continue;
    share.share = 1.0 + sum.left / sum.information;
    double variance = 0.0;
    for (int p = 0; p < parts_of_flight; ++p) {
      const Sum& part = of_cluster[static_cast<std::size_t>(f * parts_of_flight + p)];
      variance += std::pow(part.left - (share.share - 1.0) * part.information, 2);
    }
    share.deviation =
        std::sqrt(std::max(sum.known + variance * parts_of_flight / (parts_of_flight - 1.0), sum.information)) /
        sum.information;
    mean += share.share / std::pow(share.deviation, 2), weight += 1.0 / std::pow(share.deviation, 2);
  }
  // random effects, DerSimonian & Laird 1986
  double q = 0.0, weight_squares = 0.0, count = 0.0;
  for (const FlightShare& share : out.flights) {
    const double w_f = 1.0 / std::pow(share.deviation, 2);
    q += w_f * std::pow(share.share - mean / weight, 2), weight_squares += w_f * w_f, count += 1.0;
  }
  out.spread_flights =
      count > 1.0 ? std::sqrt(std::max(0.0, (q - (count - 1.0)) / (weight - weight_squares / weight))) : 0.0;
}

// what each finding does, weights of these columns
Eigen::MatrixXd effects_of(const Catalogue& catalogue, const Selection& selection, const std::vector<int>& columns) {
  Eigen::MatrixXd effects(std::ssize(columns), std::ssize(selection.findings));
  for (std::size_t i = 0; i < selection.findings.size(); ++i)
    effects.col(static_cast<Eigen::Index>(i)) = own_weights(catalogue, selection, selection.findings[i])(columns);
  return effects;
}

// The whitened rows of all columns that any finding is tested with, and what was fitted: both counted from the vehicle file.
struct FittedRows {
  std::vector<int> columns;
  RowSeries series;
  Eigen::VectorXd coefficient;
  Eigen::MatrixXd products = {};  // of the columns
};

// Takes out of the rows what the likeliest errors of the numbers that reference flights show do in them.
void take_out_known_errors(const Session& session, FittedRows& rows) {
  if (!session.reference()) return;
  const KnownColumns known = known_columns(session.catalogue(), session.all_columns(), *session.reference());
  const RowSeries errors = session.row_series(known.column);
  const auto size = std::ssize(known.column), fitted = std::ssize(rows.columns);
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd score = Eigen::VectorXd::Zero(size);
  for (std::size_t f = 0; f < errors.size(); ++f)
    for (std::size_t c = 0; c < errors[f].size(); ++c) {
      const auto own = errors[f][c].leftCols(size);
      const Eigen::MatrixXd& row = rows.series[f][c];
      information += own.transpose() * own;
      score += own.transpose() * (row.col(fitted) - row.leftCols(fitted) * rows.coefficient);
    }
  const Eigen::VectorXd likeliest = known_errors(*session.reference(), known, information, score);
  for (std::size_t f = 0; f < errors.size(); ++f)
    for (std::size_t c = 0; c < errors[f].size(); ++c)
      rows.series[f][c].col(fitted) -= errors[f][c].leftCols(size) * likeliest;
}

FittedRows fitted_rows(const Session& session, const Selection& selection) {
  FittedRows rows{session.with_biases(selection.groups()), {}, {}};
  // beside fewer effects an alias has more columns of its own
  for (const Finding& finding : selection.findings)
    for (const int c : session.with_biases(groups_beside(selection, finding)))
      if (std::find(rows.columns.begin(), rows.columns.end(), c) == rows.columns.end()) rows.columns.push_back(c);
  rows.series = session.row_series(rows.columns);
  const auto size = std::ssize(rows.columns);
  Eigen::VectorXd shift(size);
  rows.coefficient.resize(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const int c = rows.columns[static_cast<std::size_t>(i)];
    const Column& column = session.catalogue().column(c);
    shift[i] = (session.value()[c] - column.nominal) / column.natural;
    rows.coefficient[i] = (selection.value[c] - column.nominal) / column.natural;
  }
  for (auto& flight : rows.series)
    for (Eigen::MatrixXd& of_channel : flight)
      of_channel.col(of_channel.cols() - 1) += of_channel.leftCols(size) * shift;
  take_out_known_errors(session, rows);
  rows.products = column_products(rows.series);
  return rows;
}

// its surrogate test, and by how much its size differs between low and high frequencies
void measure_signature(const Session& session, const Selection& selection, const FittedRows& rows,
                       const Finding& finding, Evidence& out) {
  const std::vector<int> known = indices_of(session.with_biases(groups_beside(selection, finding)), rows.columns),
                         own = indices_of(own_columns(session.catalogue(), selection.groups(), finding.group),
                                          rows.columns);
  std::vector<int> both = known;
  both.insert(both.end(), own.begin(), own.end());
  const SignatureSeries parts = signature_series(rows.series, rows.products, known, own, rows.coefficient(both));
  const Eigen::VectorXd fitted = rows.coefficient(own);
  out.surrogates = surrogate_test(parts, fitted);
  out.slow_fast = slow_fast_difference(parts, fitted);
}

// By means of torques alone a rotor is distinguished from the one across, and from a centre of mass, by the total thrust: whether it is known well
// enough for the share of it that this rotor lost.
bool thrust_tells_rotor(const Session& session, const Selection& selection, const Group& of_rotor) {
  if (session.reference()) return true;
  double total_Ns2 = 0.0;
  for (int r = 0; r < session.vehicle().rotor_count; ++r)
    total_Ns2 += session.vehicle().rotors[static_cast<std::size_t>(r)].thrust_coefficient_Ns2;
  const double own_Ns2 = session.vehicle().rotors[static_cast<std::size_t>(of_rotor.rotor - 1)].thrust_coefficient_Ns2;
  const double lost = std::abs(selection.value[of_rotor.columns.front()]) * own_Ns2 / total_Ns2;
  for (const Group& group : session.catalogue().groups())
    if (group.row->in_hover == InHover::weight && group.row->place == Place::rotor)
      return lost > decisions::thrust_tells_rotor * session.catalogue().column(group.columns.front()).tolerance;
  return false;
}

// Other findings of the same effect, of another rotor, and what may as well be one.
int alike(const Session& session, const Selection& selection, const Finding& finding) {
  const Group& group = session.catalogue().group(finding.group);
  const auto others = std::ranges::count_if(selection.findings, [&](const Finding& other) {
    return other.group != finding.group && !other.calibration &&
           session.catalogue().group(other.group).row == group.row;
  });
  const bool by_means = session.catalogue().mean_torques_alone() && group.rotor > 0;
  return static_cast<int>(others) + (by_means && !thrust_tells_rotor(session, selection, group) ? 1 : 0);
}

// what measured speeds say of a lag or a delay
void ask_speeds(const Session& session, const Selection& selection, const Finding& finding, Evidence& record) {
  const Catalogue& catalogue = session.catalogue();
  if (!makes_rotors_late(*catalogue.group(finding.group).row)) return;
  Eigen::VectorXd without = selection.value;
  for (const int c : own_columns(catalogue, selection.groups(), finding.group))
    without[c] = catalogue.column(c).nominal;
  const auto ask = [&](const auto& statistic) {
    return statistic(session.flights(), catalogue, selection.value, without)
        .value_or(std::numeric_limits<double>::infinity());
  };
  record.slow_speeds_delta_chi2 = ask(latency_of_slow_speeds);
  record.between_rows_delta_chi2 = ask(latency_between_rows);
}

// what the search says of a finding by itself
Evidence begun_record(const Catalogue& catalogue, const Selection& selection, const Finding& finding) {
  const Group& group = catalogue.group(finding.group);
  Evidence record;
  record.effect = group.row->name;
  record.group = finding.group;
  record.rotor = group.rotor;
  record.per_flight = group.row->per_flight;
  record.may_differ = may_differ(*group.row);
  record.parameters = static_cast<int>(own_columns(catalogue, selection.groups(), finding.group).size());
  record.delta_chi2 = finding.delta_chi2;
  record.delta_chi2_with_partner = finding.delta_chi2_with_partner;
  record.delta_chi2_alone = finding.delta_chi2_alone;
  return record;
}

}  // namespace

bool headings_are_kept(const Session& session) {
  return std::ranges::all_of(session.linear(), [](const LinearFlight& flight) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const auto& R_WB : flight.R_WB) sum += R_WB.col(0).head<2>().normalized();
    return sum.norm() > decisions::kept_heading * static_cast<double>(flight.R_WB.size());
  });
}

double own_acceleration_mps2(const Session& session, const Selection& selection, const Finding& finding) {
  const Eigen::VectorXd weights = own_weights(session.catalogue(), selection, finding);
  double squares = 0.0, samples = 0.0;
  for (const LinearFlight& flight : session.linear())
    for (std::size_t k = 0; k < flight.acceleration_by.size(); ++k, samples += 1.0)
      squares += (flight.acceleration_by[k].topRows<3>() * weights(flight.columns)).squaredNorm();
  return std::sqrt(squares / std::max(1.0, samples));
}

double share_done_by(const Eigen::MatrixXd& gram, const Eigen::VectorXd& effect, const std::vector<int>& known,
                     const std::vector<int>& further) {
  const Eigen::Index z = gram.cols() - 1;
  Eigen::MatrixXd target = gram;
  target.col(z) = gram * effect;
  target.row(z) = target.col(z).transpose();
  target(z, z) = effect.dot(gram * effect);
  std::vector<int> all = known;
  all.insert(all.end(), further.begin(), further.end());
  return 1.0 - solve(target, all).loss / std::max(1e-12, solve(target, known).loss);
}

std::vector<Eigen::VectorXd> weights_added_up(const Catalogue& catalogue, const Selection& selection) {
  double filed = 1.0;
  for (const Finding& finding : selection.findings) {
    const Group& group = catalogue.group(finding.group);
    const int size = group.columns.front();
    if (group.row->air == Airflow::drag && selection.value[size] > 0.0)
      filed = std::min(filed, catalogue.column(size).nominal / selection.value[size]);
  }
  std::vector<Eigen::VectorXd> weights;
  for (const Finding& finding : selection.findings) {
    const bool is_wind = catalogue.group(finding.group).row->air == Airflow::wind;
    weights.push_back((is_wind ? filed : 1.0) * own_weights(catalogue, selection, finding));
  }
  return weights;
}

std::vector<Undoing> undoings(const Eigen::MatrixXd& gram, const std::vector<Eigen::VectorXd>& effects) {
  Eigen::VectorXd all = Eigen::VectorXd::Zero(gram.cols());
  for (const Eigen::VectorXd& effect : effects) all += effect;
  std::vector<Undoing> found;
  for (const Eigen::VectorXd& effect : effects) {
    const Eigen::VectorXd seen = gram * effect;
    const double own = std::max(1e-12, seen.dot(effect));
    const auto share = [&](const Eigen::VectorXd& others) {
      return std::max(0.0, -seen.dot(others) / std::sqrt(own * std::max(own, others.dot(gram * others))));
    };
    const Eigen::VectorXd others = all - effect;
    Undoing& undoing = found.emplace_back(share(others), std::max(0.0, -seen.dot(others) / own));
    for (const Eigen::VectorXd& other : effects)
      if (&other != &effect) undoing.share = std::max(undoing.share, share(other));
  }
  return found;
}

Eigen::MatrixXd shown_beside(const RowSeries& rows, const Eigen::MatrixXd& effects) {
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(effects.cols(), effects.cols());
  for (const auto& flight : rows)
    for (const Eigen::MatrixXd& of_channel : flight) {
      const Eigen::MatrixXd done = (of_channel.leftCols(effects.rows()) * effects).cwiseAbs2();
      squares += done.transpose() * done;
    }
  return (squares.diagonal().array() + 1e-300).inverse().matrix().asDiagonal() * squares;
}

double dwarfed_by(const Catalogue& catalogue, const Selection& selection, const Eigen::MatrixXd& beside,
                  std::size_t i) {
  const auto air = [&](std::size_t f) { return catalogue.group(selection.findings[f].group).row->air; };
  const auto one_feels_the_other = [&](std::size_t other) {
    return (air(i) == Airflow::wind && air(other) == Airflow::drag) ||
           (air(i) == Airflow::drag && air(other) == Airflow::wind);
  };
  double largest = 0.0;
  for (std::size_t other = 0; other < selection.findings.size(); ++other)
    if (other != i && !selection.findings[other].calibration && !one_feels_the_other(other))
      largest = std::max(largest, beside(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(other)));
  return largest;
}

double may_differ(const EffectRow& row) {
  if (row.per_flight || row.latency != Latency::none || (row.in_hover == InHover::weight && row.place == Place::body))
    return decisions::constant_differs;
  if (row.place == Place::body || row.per_rotor) return decisions::airframe_differs;
  const bool law_of_thrust =
      row.place == Place::rotor && row.commanded && row.needs == Need::nothing && row.like_but_for_turning.empty();
  return law_of_thrust ? decisions::law_differs : decisions::other_differs;
}

std::vector<Evidence> gather_evidence(const Session& session, const Selection& selection, const HoldoutTest& tested,
                                      const std::vector<std::vector<Regimes>>& regimes) {
  const Catalogue& catalogue = session.catalogue();
  const Eigen::MatrixXd total = selection.grams.total();
  const std::vector<int> cluster = clusters_of(session, selection.grams);
  const std::vector<Parts> both = parts(session, selection);
  const std::vector<Undoing> undone =
      undoings(project_out(total, session.biases()), weights_added_up(catalogue, selection));
  const FittedRows rows = fitted_rows(session, selection);
  const Eigen::MatrixXd beside = shown_beside(rows.series, effects_of(catalogue, selection, rows.columns));
  const bool headings_kept = headings_are_kept(session);
  std::vector<Evidence> records(selection.findings.size());
  parallel_for(std::ssize(records), session.jobs(), [&](std::int64_t at) {
    const auto i = static_cast<std::size_t>(at);
    const Finding& finding = selection.findings[i];
    const Group& group = catalogue.group(finding.group);
    Evidence& record = records[i] = begun_record(catalogue, selection, finding);
    record.held_out_delta_chi2 = tested.delta_chi2[i];
    record.held_out_expected = tested.expected[i];
    measure_signature(session, selection, rows, finding, record);
    measure_flights(session, selection, weights_of(session, selection, total, finding), cluster, record);
    if (record.held_out_expected > 0.0)
      record.flights.push_back({"held out", true, 0.5 * (1.0 + record.held_out_delta_chi2 / record.held_out_expected),
                                std::sqrt(std::max(1.0, record.clustered_inflation) / record.held_out_expected)});
    record.spread_regimes = most_astray(regimes[i]);
    record.uneven = surely_astray(regimes[i]);
    // a force that every flight has for itself is at least as large as what a frame that is not level leaves
    record.size_in_tolerances = size_in_tolerances(session, selection.value, finding.group);
    if (group.row->per_flight) {
      const double push_share = own_acceleration_mps2(session, selection, finding) / session.vehicle().gravity_mps2;
      record.size_in_tolerances = push_share / decisions::level_share;
      if (headings_kept) record.force_over_tilt = push_share / decisions::tilt_share;
    }
    record.inclusion = finding.inclusion;
    for (const Rival& rival : finding.rivals)
      if (is_told(rival) && !equal(rival, finding) &&
          (record.rival_z == 0.0 || rival.delta_chi2 < record.rival_delta_chi2))
        record.rival_delta_chi2 = rival.delta_chi2, record.rival_z = rival.z;
    if (group.row->commanded)
      record.unpredicted_commands =
          selection.unpredicted_delta_chi2 * share_of_innovations(session, selection, total, finding);
    record.force_excess = both[i].excess, record.force_excess_sd = both[i].deviation;
    record.part_lacking = both[i].lacking;
    record.at_bound = at_its_bound(catalogue, selection.value, finding.group);
    record.undone = undone[i].share, record.outweighed = undone[i].outweighed;
    record.dwarfed_by = dwarfed_by(catalogue, selection, beside, i);
    record.lone_latency = session.reference() && session.reference()->flights == 1 && makes_rotors_late(*group.row);
    record.alike = alike(session, selection, finding);
    ask_speeds(session, selection, finding, record);
  });
  return records;
}

}  // namespace gustlab::diagnosis
