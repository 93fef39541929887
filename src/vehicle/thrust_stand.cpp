#include "vehicle/thrust_stand.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "flight_log/csv.hpp"
#include "gustlab/errors.hpp"
#include "gustlab/types.hpp"
#include "vehicle/estimates.hpp"

namespace gustlab {

namespace {

constexpr std::size_t fewest_rows = 5;
constexpr double least_voltage_spread = 0.02;  // of the mean: less does not tell an exponent
constexpr int voltage_rounds = 50;
constexpr double most_below_zero = 0.02;  // of the largest thrust
// of the span of thrust over the range of inputs: a parabola through a dead band at the foot falls by so much before it rises
constexpr double most_fall = 0.05;

// A column that may be written in several units, as SI; the least and the most that it says, as it is written.
struct Quantity {
  struct Name {
    std::string_view column;
    double factor, offset;
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
  };
  std::vector<Name> names;
};
const Quantity thrust{{{"thrust_N", 1.0, 0.0},
                       {"thrust_gf", 1e-3 * standard_gravity_mps2, 0.0},
                       {"thrust_kgf", standard_gravity_mps2, 0.0}}};
const Quantity torque{{{"torque_Nm", 1.0, 0.0}}};
const Quantity speed{{{"speed_radps", 1.0, 0.0}, {"speed_rpm", pi / 30.0, 0.0}}};
const Quantity voltage{{{"voltage_V", 1.0, 0.0}}};
const Quantity throttle{{{"throttle", 1.0, 0.0, -0.05, 1.05}, {"pulse_us", 1e-3, -1.0, 950.0, 2050.0}}};
const Quantity pwm{{{"pwm", 1.0, 0.0}}};

// the name under which a quantity stands in a table, and its column
std::optional<std::pair<Quantity::Name, std::size_t>> find_column(const CsvNumbers& csv, const Quantity& quantity) {
  for (const Quantity::Name& name : quantity.names) {
    const auto found = std::find(csv.names().begin(), csv.names().end(), name.column);
    if (found != csv.names().end()) return std::pair{name, static_cast<std::size_t>(found - csv.names().begin())};
  }
  return std::nullopt;
}

std::optional<Eigen::VectorXd> read_column(const CsvNumbers& csv, const Quantity& quantity) {
  const auto found = find_column(csv, quantity);
  if (!found) return std::nullopt;
  const auto& [name, index] = *found;
  const std::vector<double>& column = csv.column(index);
  for (std::size_t row = 0; row < column.size(); ++row) {
    if (std::isnan(column[row]))
      throw DataError(fmt::format("{}: the cell of \"{}\" is empty", csv.where(row, index), name.column));
    if (column[row] < name.least || column[row] > name.most)
      throw DataError(fmt::format("{}: throttle is from 0 to 1 and pulse_us from 1000 to 2000 (this \"{}\" is {})",
                                  csv.where(row, index), name.column, column[row]));
  }
  return Eigen::VectorXd(
      Eigen::Map<const Eigen::VectorXd>(column.data(), static_cast<Eigen::Index>(column.size())).array() * name.factor +
      name.offset);
}

Eigen::VectorXd read_thrust_N(const CsvNumbers& csv, const std::string& path) {
  const auto measured_N = read_column(csv, thrust);
  if (!measured_N)
    throw DataError(fmt::format("{}:1:1: column \"thrust_N\" is missing (or thrust_gf, thrust_kgf)", path));
  if (csv.rows() < fewest_rows)
    throw DataError(fmt::format("{}: {} rows are too few (at least {})", path, csv.rows(), fewest_rows));
  if (!(measured_N->maxCoeff() > 0.0))
    throw DataError(fmt::format("{}: no row has thrust above zero (it is positive upwards)", path));
  const auto [name, index] = *find_column(csv, thrust);
  const std::vector<double>& column = csv.column(index);
  // a load cell's zero is no sharper than that
  const double least = -most_below_zero * *std::max_element(column.begin(), column.end());
  const auto negative = std::find_if(column.begin(), column.end(), [&](double value) { return value < least; });
  if (negative != column.end())
    throw DataError(worded(
        fmt::format("{}: \"{}\" is negative ({})",
                    csv.where(static_cast<std::size_t>(negative - column.begin()), index), name.column, *negative),
        "it is positive upwards, and so it is in other rows", "mend the sign, or leave the row out"));
  return *measured_N;
}

// Throws where the map falls within the range of inputs that were measured: no rotor does.
void check_rises(const std::array<double, 3>& map, const Eigen::VectorXd& u, std::string_view input,
                 const std::string& path) {
  const auto thrust_N = [&](double at) { return map[0] + at * (map[1] + at * map[2]); };
  const double low = u.minCoeff(), high = u.maxCoeff();
  const double turn = map[2] == 0.0 ? low : std::clamp(-0.5 * map[1] / map[2], low, high);
  const auto [least, most] = std::minmax({thrust_N(low), thrust_N(turn), thrust_N(high)});
  for (const auto& [from, to] : {std::pair{low, turn}, {turn, high}})
    if (thrust_N(from) - thrust_N(to) > most_fall * (most - least))
      throw DataError(worded(
          fmt::format(
              "{}: the map from {} to thrust does not rise: it falls from {:.3g} N at {:.3g} to {:.3g} N at {:.3g}",
              path, input, thrust_N(from), from, thrust_N(to), to),
          fmt::format("{:.3g} + {:.3g} u + {:.3g} u² fits the rows best", map[0], map[1], map[2]),
          "look for rows whose thrust is wrong, or that are of another rotor"));
}

// y = value x
Estimate proportion(const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  const double value = x.dot(y) / x.squaredNorm();
  return {value, (y - value * x).norm() / (x.norm() * std::sqrt(static_cast<double>(x.size() - 1)))};
}

// f = (c0 + c1 u + c2 u²) (V / V₀)^a, least squares, the two parts in turn
void fit_input(const Eigen::VectorXd& u, const Eigen::VectorXd& thrust_N,
               const std::optional<Eigen::VectorXd>& voltage_V, ThrustStand& out) {
  Eigen::MatrixXd powers(u.size(), 3);
  powers << Eigen::VectorXd::Ones(u.size()), u, u.cwiseAbs2();
  const auto decomposition = powers.colPivHouseholderQr();
  if (decomposition.rank() < 3) {
    out.unknown.emplace_back("the map from the input to thrust: it was measured at fewer than three inputs");
    return;
  }
  const bool varied =
      voltage_V && (voltage_V->maxCoeff() - voltage_V->minCoeff()) > least_voltage_spread * voltage_V->mean();
  const Eigen::ArrayXd log_voltage =
      varied ? (voltage_V->array() / *out.nominal_voltage_V).log().eval() : Eigen::ArrayXd::Zero(u.size());
  Vector3 c = decomposition.solve(thrust_N);
  double exponent = 0.0;
  Eigen::ArrayXd scale = Eigen::ArrayXd::Ones(u.size());
  for (int round = 0; varied && round < voltage_rounds; ++round) {
    // one Gauss-Newton step on all four
    Eigen::MatrixXd slope(u.size(), 4);
    slope << (powers.array().colwise() * scale).matrix(), ((powers * c).array() * scale * log_voltage).matrix();
    const Eigen::Vector4d step = slope.colPivHouseholderQr().solve(thrust_N - ((powers * c).array() * scale).matrix());
    c += step.head<3>();
    exponent += step[3];
    scale = (exponent * log_voltage).exp();
  }
  const Eigen::VectorXd misfit = thrust_N - ((powers * c).array() * scale).matrix();
  out.thrust_misfit_N = misfit.norm() / std::sqrt(static_cast<double>(u.size()));
  out.input_thrust = {c[0], c[1], c[2]};
  if (!varied) {
    out.unknown.emplace_back(voltage_V ? "what the voltage does: it varied by less than 2 %"
                                       : "what the voltage does: there is no column voltage_V");
    return;
  }
  Eigen::MatrixXd slope(u.size(), 4);
  slope << (powers.array().colwise() * scale).matrix(), ((powers * c).array() * scale * log_voltage).matrix();
  const Eigen::Matrix4d covariance = (slope.transpose() * slope).inverse() * misfit.squaredNorm() /
                                     static_cast<double>(std::max<Eigen::Index>(1, u.size() - 4));
  out.voltage_exponent = Estimate{exponent, std::sqrt(covariance(3, 3))};
}

}  // namespace

ThrustStand read_thrust_stand(const std::string& csv_path) {
  const CsvNumbers csv(csv_path, [](std::string_view) { return false; });
  const Eigen::VectorXd measured_thrust_N = read_thrust_N(csv, csv_path);
  ThrustStand out;
  out.rows = csv.rows();
  const auto speed_radps = read_column(csv, speed), torque_Nm = read_column(csv, torque),
             voltage_V = read_column(csv, voltage);
  if (voltage_V) out.nominal_voltage_V = voltage_V->mean();
  if (speed_radps && speed_radps->squaredNorm() > 0.0)
    out.coefficient_Ns2 = proportion(speed_radps->cwiseAbs2(), measured_thrust_N);
  else out.unknown.emplace_back("the thrust coefficient: there is no column speed_radps or speed_rpm");
  if (torque_Nm) {
    out.torque_ratio_m = proportion(measured_thrust_N, *torque_Nm);
    out.torque_ratio_m->value = std::abs(out.torque_ratio_m->value);
  } else {
    out.unknown.emplace_back("the torque ratio: there is no column torque_Nm");
  }
  const auto as_throttle = read_column(csv, throttle), as_pwm = read_column(csv, pwm);
  out.input = as_throttle ? "throttle" : as_pwm ? "pwm" : "";
  if (as_throttle || as_pwm) fit_input(as_throttle ? *as_throttle : *as_pwm, measured_thrust_N, voltage_V, out);
  else out.unknown.emplace_back("the map from the input to thrust: there is no column throttle, pulse_us or pwm");
  if (out.input_thrust) check_rises(*out.input_thrust, as_throttle ? *as_throttle : *as_pwm, out.input, csv_path);
  if (!out.coefficient_Ns2 && !out.torque_ratio_m && !out.input_thrust)
    throw DataError(
        fmt::format("{}: nothing can be told from these rows ({})", csv_path, fmt::join(out.unknown, "; ")));
  return out;
}

}  // namespace gustlab
