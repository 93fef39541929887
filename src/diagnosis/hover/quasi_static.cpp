#include "diagnosis/hover/quasi_static.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

using namespace decisions;

namespace {

using Vector4 = Eigen::Vector4d;

constexpr std::array<const char*, 4> channel_name = {"force_z", "torque_x", "torque_y", "torque_z"};

// wrench of a flight whose lever in each channel carries the whole weight
Vector4 unit_of(const VehicleModel& vehicle, double weight_N) {
  Vector4 unit = Vector4::Zero();
  for (int i = 0; i < vehicle.rotor_count; ++i) unit += wrench_per_newton(vehicle, i).cwiseAbs() / vehicle.rotor_count;
  return weight_N * unit;
}

double tail(double chi_squared, int degrees) {
  if (degrees < 1) return chi_squared < 1e-6 ? 1.0 : 0.0;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(degrees), std::max(0.0, chi_squared)));
}

struct Flight {
  std::string label;
  bool held_out = false;
  HoverBalance balance;
};

// what the flights that agree with each other say, and how far another one may be from it by chance
struct Reference {
  Vector4 mean = Vector4::Zero(), unit = Vector4::Ones();
  Vector4 deviation = Vector4::Zero();  // of one further flight's difference, in units

  Reference(const std::vector<const Flight*>& flights, const VehicleModel& vehicle) {
    const double n = static_cast<double>(flights.size());
    for (const Flight* f : flights) mean += f->balance.wrench / n;
    unit = unit_of(vehicle, mean[0]);
    Vector4 spread = Vector4::Zero(), within = Vector4::Zero();
    for (const Flight* f : flights) {
      spread += (f->balance.wrench - mean).cwiseQuotient(unit).cwiseAbs2();
      within += f->balance.deviation.cwiseQuotient(unit).cwiseAbs2() / (n * n);
    }
    const Vector4 between =
        (Vector4::Constant(flight_to_flight_counts * flight_to_flight * flight_to_flight) + spread) /
        (flight_to_flight_counts + n - 1.0);
    deviation = (between * (1.0 + 1.0 / n) + within).cwiseSqrt();
  }
  Vector4 difference(const Flight& f) const { return (f.balance.wrench - mean).cwiseQuotient(unit); }
  Vector4 deviation_of(const Flight& f) const {
    return (deviation.cwiseAbs2() + f.balance.deviation.cwiseQuotient(unit).cwiseAbs2()).cwiseSqrt();
  }
  double distance(const Flight& f) const { return difference(f).cwiseQuotient(deviation_of(f)).squaredNorm(); }
  bool agrees(const Flight& f) const { return tail(distance(f), 4) > hover_significance; }
};

// a change of the vehicle, as directions in which the balance moves
struct Hypothesis {
  bool weight = false, center_of_mass = false;
  std::vector<int> rotors;  // that lost thrust
  Eigen::Matrix<double, 4, Eigen::Dynamic> directions;
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
  double misfit = 0.0;    // squared standard deviations
  bool adequate = false;  // nothing significant is left, and no rotor gains thrust

  int size() const { return static_cast<int>(directions.cols()); }
  bool contains(const Hypothesis& other) const {
    return (weight || !other.weight) && (center_of_mass || !other.center_of_mass) &&
           std::includes(rotors.begin(), rotors.end(), other.rotors.begin(), other.rotors.end());
  }
};

std::vector<Hypothesis> hypotheses(const VehicleModel& vehicle, const Reference& reference) {
  std::vector<Hypothesis> all;
  const auto add = [&](bool weight, bool center_of_mass, std::vector<int> rotors) {
    Hypothesis h;
    h.weight = weight;
    h.center_of_mass = center_of_mass;
    h.rotors = std::move(rotors);
    const auto direction = [&](const Vector4& d) {
      h.directions.conservativeResize(4, h.directions.cols() + 1);
      h.directions.col(h.directions.cols() - 1) = d;
    };
    // more weight, or less thrust of all rotors, scales the whole trim
    if (weight) direction(reference.mean.cwiseQuotient(reference.unit));
    if (center_of_mass) {
      direction(Vector4::Unit(1));
      direction(Vector4::Unit(2));
    }
    for (const int i : h.rotors)
      direction(reference.mean[0] * wrench_per_newton(vehicle, i).cwiseQuotient(reference.unit));
    all.push_back(std::move(h));
  };
  add(true, false, {});
  add(false, true, {});
  add(true, true, {});
  for (int i = 0; i < vehicle.rotor_count; ++i) add(false, false, {i});
  for (int i = 0; i < vehicle.rotor_count; ++i)
    for (int j = i + 1; j < vehicle.rotor_count; ++j) add(false, false, {i, j});
  return all;
}

// `rows`: the channels that count
void fit(Hypothesis& h, const Reference& reference, const std::vector<const Flight*>& flights,
         const std::vector<int>& rows) {
  const auto at = Eigen::Map<const Eigen::VectorXi>(rows.data(), static_cast<Eigen::Index>(rows.size()));
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(h.size(), h.size());
  Eigen::VectorXd right = Eigen::VectorXd::Zero(h.size());
  const auto whitened = [&](const Flight& f, Eigen::MatrixXd& A, Eigen::VectorXd& y) {
    const Eigen::VectorXd weight = reference.deviation_of(f).cwiseInverse();
    A = (weight.asDiagonal() * h.directions)(at, Eigen::all);
    y = (weight.cwiseProduct(reference.difference(f)))(at);
  };
  Eigen::MatrixXd A;
  Eigen::VectorXd y;
  for (const Flight* f : flights) {
    whitened(*f, A, y);
    gram += A.transpose() * A;
    right += A.transpose() * y;
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(gram);
  h.value = solver.solve(right);
  h.covariance = solver.solve(Eigen::MatrixXd::Identity(h.size(), h.size()));
  h.misfit = 0.0;
  for (const Flight* f : flights) {
    whitened(*f, A, y);
    h.misfit += (y - A * h.value).squaredNorm();
  }
  // loss is positive: as many rows as the flights give, less what was fitted
  h.adequate = tail(h.misfit, static_cast<int>(rows.size() * flights.size()) - h.size()) > hover_significance;
  for (int i = h.size() - static_cast<int>(h.rotors.size()); i < h.size(); ++i)
    h.adequate = h.adequate && h.value[i] > 0.0;
}

std::string labels(const std::vector<const Flight*>& flights) {
  std::string text;
  for (const Flight* f : flights) text += (text.empty() ? "" : ", ") + f->label;
  return text;
}

void cannot_tell(Diagnosis& out, bool anything) {
  for (const EffectRow& row : effect_registry())
    if (row.diagnosable && !(anything && row.in_hover != InHover::nothing))
      out.not_identifiable.push_back(
          {std::string(row.name),
           anything ? "mean commands of hover do not show it, and the log has neither attitude nor body rate"
                    : "the log has neither attitude nor body rate",
           Lack::attitude_and_rate});
}

// hypotheses as catalogue names, in catalogue order: every name that explains the same means
std::vector<std::string> names_of(const std::vector<const Hypothesis*>& alike) {
  std::vector<std::string> names;
  for (const EffectRow& row : effect_registry())
    if (std::any_of(alike.begin(), alike.end(), [&](const Hypothesis* h) {
          switch (row.in_hover) {
            case InHover::nothing:
              return false;
            case InHover::rotor:
              return !h->rotors.empty();
            case InHover::center:
              return h->center_of_mass;
            case InHover::weight:
              return h->weight && !h->center_of_mass;
          }
          return false;
        }))
      names.emplace_back(row.name);
  return names;
}

// of the names for one change the first of the catalogue; beside a moved centre of mass it is the body that is heavier
const EffectRow& moved_center() {
  return first_effect([](const EffectRow& row) { return row.in_hover == InHover::center; });
}
const EffectRow& lost_thrust() {
  return first_effect([](const EffectRow& row) { return row.in_hover == InHover::rotor; });
}
const EffectRow& more_weight() {
  return first_effect([](const EffectRow& row) { return row.in_hover == InHover::weight; });
}
const EffectRow& heavier_body() {
  return first_effect([](const EffectRow& row) { return row.in_hover == InHover::weight && row.place == Place::body; });
}

EffectFinding finding(const EffectRow& row, std::vector<NamedValue> parameters) {
  EffectFinding effect;
  effect.effect = row.name;
  effect.place = to_string(row.place);
  effect.says = row.says;
  effect.parameters = std::move(parameters);
  effect.classmates = {effect.effect};
  return effect;
}

// the named effects of one hypothesis, values counted from the vehicle file
std::vector<EffectFinding> effects_of(const Hypothesis& h, const Reference& reference, const VehicleModel& vehicle,
                                      const std::vector<const Flight*>& flights) {
  std::vector<EffectFinding> effects;
  const auto sd = [&](int i) { return std::sqrt(h.covariance(i, i)); };
  const double weight_N = reference.mean[0];
  int at = 0;
  const double more = h.weight ? h.value[0] : 0.0, more_sd = h.weight ? sd(0) : 0.0;
  if (h.weight) ++at;
  if (h.center_of_mass) {
    // moment about x is weight times y, about y minus weight times x
    const double total = 1.0 + more, y = reference.unit[1] / weight_N / total,
                 x = -reference.unit[2] / weight_N / total;
    effects.push_back(finding(moved_center(), {{"x", "m", x * h.value[at + 1], std::abs(x) * sd(at + 1)},
                                               {"y", "m", y * h.value[at], std::abs(y) * sd(at)},
                                               {"z", "m", 0.0, vehicle.arm_m()}}));
  }
  if (h.weight && h.center_of_mass) effects.push_back(finding(heavier_body(), {{"delta", "-", more, more_sd}}));
  if (h.weight && !h.center_of_mass)
    effects.push_back(finding(
        more_weight(),
        {{"x", "N", 0.0, weight_N}, {"y", "N", 0.0, weight_N}, {"z", "N", -more * weight_N, more_sd * weight_N}}));
  if (h.center_of_mass) at += 2;
  for (const int rotor : h.rotors) {
    // thrust asked for beyond what is needed, as a share of what is asked
    double asked = 0.0;
    for (const Flight* f : flights)
      asked += f->balance.thrust_N[static_cast<std::size_t>(rotor)] / static_cast<double>(flights.size());
    const double share = weight_N / asked;
    effects.push_back(finding(
        lost_thrust(),
        {{"rotor", "-", rotor + 1.0, 0.0}, {"loss", "-", std::clamp(share * h.value[at], 0.0, 1.0), share * sd(at)}}));
    ++at;
  }
  return effects;
}

void report_mismatch(const Reference& reference, const std::vector<const Flight*>& flights, Diagnosis& out) {
  for (Eigen::Index c = 0; c < 4; ++c) {
    double square = 0.0, noise = 0.0, size = 0.0;
    for (const Flight* f : flights) {
      const double d = reference.difference(*f)[c], sd = reference.deviation_of(*f)[c],
                   n = static_cast<double>(flights.size());
      square += d * d / (sd * sd);
      noise += sd * sd / n;
      size += d * d / n;
    }
    Mismatch m;
    m.channel = channel_name[static_cast<std::size_t>(c)];
    m.p_value = tail(square, static_cast<int>(flights.size()));
    m.significant = m.p_value < hover_significance;
    m.rms = reference.unit[c] * std::sqrt(size);
    m.noise_rms = reference.unit[c] * std::sqrt(noise);
    m.unit = c == 0 ? "N" : "N m";
    out.mismatch.push_back(std::move(m));
  }
}

// rotors whose thrust is not what the command says, in any of the flights
std::vector<int> limited_rotors(const std::vector<const Flight*>& flights) {
  std::vector<int> result;
  for (std::size_t i = 0; i < flights.front()->balance.limited.size(); ++i)
    if (std::any_of(flights.begin(), flights.end(), [&](const Flight* f) { return f->balance.limited[i]; }))
      result.push_back(static_cast<int>(i));
  return result;
}

double score(const Hypothesis& h, double cost) { return h.misfit + cost * h.size(); }

// `none`: the misfit of no change
void reject_all(const std::vector<Hypothesis>& all, double none, Diagnosis& out) {
  for (const Hypothesis& h : all)
    if (h.size() <= 2 && h.rotors.size() < 2)
      out.rejected.push_back({with_rotor(names_of({&h}).front(), h.rotors.empty() ? 0 : h.rotors.front() + 1),
                              none - score(h, number_costs), "does not explain the mean commands"});
  out.verdict = Verdict::insufficient_data;
}

// the best explanation and every other one that does as well and is not this one with more added; best first
struct Alike {
  std::vector<const Hypothesis*> hypotheses;
  double nearest = 1e9;  // of those that do worse: by how much
};

Alike alike_to(const Hypothesis& best, const std::vector<Hypothesis>& all) {
  Alike alike{.hypotheses = {&best}};
  for (const Hypothesis& h : all) {
    if (&h == &best || !h.adequate || h.contains(best) || best.contains(h)) continue;
    const double behind = score(h, other_number_costs) - score(best, other_number_costs);
    if (behind < equivalent_z * equivalent_z) alike.hypotheses.push_back(&h);
    else alike.nearest = std::min(alike.nearest, behind);
  }
  std::stable_sort(alike.hypotheses.begin(), alike.hypotheses.end(), [](const auto* a, const auto* b) {
    return score(*a, other_number_costs) < score(*b, other_number_costs);
  });
  return alike;
}

// squared standard deviations of some flights from normal, or from where a change moves it
double misfit_of(const std::vector<const Flight*>& flights, const Reference& reference, const std::vector<int>& rows,
                 const Vector4& moved) {
  double sum = 0.0;
  for (const Flight* f : flights)
    for (const int row : rows)
      sum += std::pow((reference.difference(*f) - moved)[row] / reference.deviation_of(*f)[row], 2);
  return sum;
}

void name_what_changed(const Reference& reference, const std::vector<const Flight*>& fitted,
                       const std::vector<const Flight*>& checked, const VehicleModel& vehicle, Diagnosis& out) {
  // neither thrust nor reaction torque of a rotor at its limit is known: the balance of yaw, which would distinguish a loss from
  // a weight beside that rotor, does not count
  const std::vector<int> limited = limited_rotors(fitted);
  const std::vector<int> rows = limited.empty() ? std::vector<int>{0, 1, 2, 3} : std::vector<int>{0, 1, 2};
  for (const int i : limited)
    out.notes.push_back(
        fmt::format("rotor {} was asked for more thrust than the battery could give: its reaction torque is not known, "
                    "and the balance of yaw is left out",
                    i + 1));

  std::vector<Hypothesis> all = hypotheses(vehicle, reference);
  const Hypothesis* best = nullptr;
  for (Hypothesis& h : all) fit(h, reference, fitted, rows);
  for (const Hypothesis& h : all)
    if (h.adequate && (!best || score(h, number_costs) < score(*best, number_costs))) best = &h;
  const double none = misfit_of(fitted, reference, rows, Vector4::Zero());
  if (!best) return reject_all(all, none, out);
  const Alike alike = alike_to(*best, all);
  const std::vector<std::string> names = names_of(alike.hypotheses);
  const Hypothesis& chosen = **std::find_if(alike.hypotheses.begin(), alike.hypotheses.end(), [&](const Hypothesis* h) {
    return names_of({h}).front() == names.front();
  });
  const bool which = std::any_of(alike.hypotheses.begin(), alike.hypotheses.end(), [&](const Hypothesis* h) {
    return !chosen.rotors.empty() && h->rotors != chosen.rotors;
  });

  // does it hold on flights that were not used?
  const double before = misfit_of(checked, reference, rows, Vector4::Zero()),
               after = misfit_of(checked, reference, rows, chosen.directions * chosen.value);
  const bool pays = checked.empty() || after < most_left_in_hover * before;
  std::vector<EffectFinding> effects = effects_of(chosen, reference, vehicle, fitted);
  // one cause that needs nothing beside it is as good: what was added beside this one is part of the class
  if (names.size() > 1 && effects.size() > 1 && chosen.center_of_mass) {
    out.notes.push_back(fmt::format("if it is the centre of mass that moved, the vehicle is {:.1f} g heavier as well",
                                    1e3 * chosen.value[0] * reference.mean[0] / vehicle.gravity_mps2));
    effects.resize(1);
  }
  for (EffectFinding& effect : effects) {
    effect.delta_chi2 = none - chosen.misfit;
    if (which || !pays) {
      out.rejected.push_back({with_rotor(effect.effect, effect.rotor()), none - score(chosen, number_costs),
                              pays ? "another rotor explains the means as well"
                                   : "explains the flights it was found on, and not the held-out ones"});
      continue;
    }
    if (effect.effect == names.front()) effect.classmates = names;
    if (effect.effect == heavier_body().name) effect.classmates = names_of({&all.front()});
    const double distinct = 1.0 - 0.25 * std::exp(-0.3 * std::max(0.0, alike.nearest - equivalent_z * equivalent_z));
    effect.confidence = (checked.empty() ? unchecked_confidence : checked_confidence) * distinct;
    out.effects.push_back(std::move(effect));
  }
  out.verdict = out.effects.empty() ? Verdict::insufficient_data : Verdict::explained;
  if (names.size() < 2) return;
  out.next_trajectory = "multisine";
  out.next_why = "with attitude and body rate recorded would separate " + fmt::format("{}", fmt::join(names, " from "));
}

// without a normal flight: the one that is nearest to the vehicle file's balance, weight and no moment
const Flight* nearest_to_file(const std::vector<const Flight*>& flights, const VehicleModel& vehicle) {
  const Vector4 unit = unit_of(vehicle, vehicle.weight_N());
  const auto far = [&](const Flight* f) { return (f->balance.wrench.cwiseQuotient(unit) - Vector4::Unit(0)).norm(); };
  return *std::min_element(flights.begin(), flights.end(),
                           [&](const Flight* a, const Flight* b) { return far(a) < far(b); });
}

// the largest loss of one rotor, as a share of its thrust, with which some flight would still have agreed
double hidden_loss(const Reference& reference, const std::vector<const Flight*>& flights, const VehicleModel& vehicle) {
  const double most = boost::math::quantile(boost::math::complement(boost::math::chi_squared(4), hover_significance));
  double hidden = 0.0;
  for (const Flight* f : flights)
    for (int i = 0; i < vehicle.rotor_count; ++i) {
      const Vector4 per_weight = reference.mean[0] * wrench_per_newton(vehicle, i).cwiseQuotient(reference.unit);
      const double shows = per_weight.cwiseQuotient(reference.deviation_of(*f)).norm();
      // a share p of the thrust that is lost asks for p / (1 − p) more
      const double more =
          std::sqrt(most) / shows * reference.mean[0] / f->balance.thrust_N[static_cast<std::size_t>(i)];
      hidden = std::max(hidden, more / (1.0 + more));
    }
  return hidden;
}

std::string agreement(const Reference& reference, const std::vector<const Flight*>& agreed,
                      const VehicleModel& vehicle) {
  return fmt::format(
      "mean commands of hover agree: {}; a rotor that lost less than {:.0f} % of its thrust may not show",
      labels(agreed), 100.0 * hidden_loss(reference, agreed, vehicle));
}

void ask_for_reference(Diagnosis& out) {
  out.notes.emplace_back(
      "mean commands of hover tell nothing without another flight of the same vehicle: name a normal one with "
      "--reference");
  out.next_trajectory = "hover";
  out.next_why =
      "of the vehicle in its normal state, named with --reference; with attitude or body rate recorded, it would not "
      "be needed";
}

}  // namespace

void compare_hover(const std::vector<FlightData>& reference, const std::vector<FlightData>& fit,
                   const std::vector<FlightData>& holdout, const VehicleModel& vehicle, Diagnosis& out) {
  out.verdict = Verdict::insufficient_data;
  std::vector<Flight> flights, given;
  const auto read = [&](const std::vector<FlightData>& from, bool held_out, std::vector<Flight>& to) {
    for (const FlightData& data : from) {
      if (auto balance = hover_balance(data, vehicle)) to.push_back({data.label, held_out, std::move(*balance)});
      else
        out.notes.push_back(
            fmt::format("{}: no {:.1f} s of hover, so no balance of mean commands", data.label, least_hover_s));
    }
  };
  read(reference, false, given);
  read(fit, false, flights);
  read(holdout, true, flights);
  std::vector<const Flight*> agreed, others, fitted, checked;
  for (const Flight& f : given) agreed.push_back(&f);
  for (const Flight& f : flights) others.push_back(&f);
  const bool compared = !given.empty() || std::any_of(others.begin(), others.end(), [&](const Flight* f) {
    return f->label != others.front()->label;
  });
  if (others.empty() || !compared) {
    ask_for_reference(out);
    return cannot_tell(out, false);
  }
  if (given.empty()) {
    agreed.push_back(nearest_to_file(others, vehicle));
    std::erase(others, agreed.front());
  }
  const std::vector<const Flight*> asked = others;
  // flights that agree with the reference are as good as it
  const Reference first(agreed, vehicle);
  std::erase_if(others, [&](const Flight* f) {
    const bool agrees = first.agrees(*f);
    if (agrees) agreed.push_back(f);
    return agrees;
  });
  if (others.empty()) {
    out.notes.push_back(agreement(first, agreed, vehicle));
    if (given.empty())
      out.notes.emplace_back("what all flights share cannot be told without a normal one (--reference)");
    else out.verdict = Verdict::consistent;
    report_mismatch(first, asked, out);
    return cannot_tell(out, !given.empty());
  }
  for (const Flight* f : others) {
    (f->held_out ? checked : fitted).push_back(f);
    if (given.empty())
      out.log_findings.push_back({f->label, "u1…uN", "inconsistent", 0.0, 0.0,
                                  fmt::format("mean commands of hover are not those of {}, which is nearest to the "
                                              "vehicle file and taken as normal (or name one with --reference)",
                                              labels(agreed)),
                                  false, false});
  }
  if (fitted.empty()) std::swap(fitted, checked);
  const Reference normal(agreed, vehicle);
  report_mismatch(normal, fitted, out);
  name_what_changed(normal, fitted, checked, vehicle, out);
  cannot_tell(out, true);
}

}  // namespace gustlab::diagnosis
