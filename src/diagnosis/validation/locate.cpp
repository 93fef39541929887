#include "diagnosis/validation/locate.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numeric>

#include "diagnosis/result/decisions.hpp"
#include "diagnosis/validation/dependence.hpp"
#include "diagnosis/validation/generic_bases.hpp"

namespace gustlab::diagnosis {

namespace {

double chi_squared_tail(double value, double degrees) {
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(degrees), std::max(value, 0.0)));
}

// explained variance of one series by smooth functions of one variable, 5 s blocks left out in turn
class SmoothPredictor {
 public:
  SmoothPredictor(const Eigen::VectorXd& x, const std::vector<int>& fold) : fold_(fold) {
    const double mean = x.mean(), sd = std::sqrt((x.array() - mean).square().mean()) + 1e-12;
    basis_.resize(x.size(), 4);
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double s = std::clamp((x[i] - mean) / sd, -4.0, 4.0);
      basis_.row(i) << 1.0, s, s * std::abs(s), s * s;
    }
    const int folds = *std::max_element(fold.begin(), fold.end()) + 1;
    Eigen::Matrix4d whole = basis_.transpose() * basis_;
    for (int f = 0; f < folds; ++f) {
      Eigen::Matrix4d without = whole;
      for (Eigen::Index i = 0; i < x.size(); ++i)
        if (fold[static_cast<std::size_t>(i)] == f) without -= basis_.row(i).transpose() * basis_.row(i);
      without.diagonal().array() += 1.0;
      inverse_.push_back(without.inverse());
    }
  }
  double explained(const Eigen::VectorXd& y) const {
    std::vector<Eigen::Vector4d> sums(inverse_.size(), Eigen::Vector4d::Zero());
    Eigen::Vector4d all = Eigen::Vector4d::Zero();
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      const Eigen::Vector4d part = basis_.row(i).transpose() * y[i];
      sums[static_cast<std::size_t>(fold_[static_cast<std::size_t>(i)])] += part;
      all += part;
    }
    double left = 0.0, total = 0.0;
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      const auto f = static_cast<std::size_t>(fold_[static_cast<std::size_t>(i)]);
      const double error = y[i] - basis_.row(i).dot(inverse_[f] * (all - sums[f]));
      left += error * error;
      total += y[i] * y[i];
    }
    return 1.0 - left / (total + 1e-300);
  }

 private:
  Eigen::Matrix<double, Eigen::Dynamic, 4> basis_;
  std::vector<Eigen::Matrix4d> inverse_;
  std::vector<int> fold_;
};

// where the energy of a channel sits along one variable
Region region(const std::string& variable, const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
  std::vector<std::size_t> order(static_cast<std::size_t>(x.size()));
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto size = [&](std::size_t i) { return std::abs(x[static_cast<Eigen::Index>(i)]); };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(a) > size(b); });
  const double total = y.squaredNorm() + 1e-300;
  Region best{variable, 0.0, 0.0};
  double energy = 0.0, widest = -1.0;
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    energy += y[static_cast<Eigen::Index>(order[i])] * y[static_cast<Eigen::Index>(order[i])] / total;
    const double advantage = energy - static_cast<double>(i + 1) / static_cast<double>(order.size());
    if (advantage > widest) {
      widest = advantage;
      best.above = size(order[i]);
      best.share = energy;
    }
  }
  return best;
}

}  // namespace

Blocks blocks(const Session& session, const std::vector<Smoothed>& smoothed) {
  Blocks result;
  result.variable = {"forward_speed_mps",
                     "left_speed_mps",
                     "vertical_speed_mps",
                     "airspeed_mps",
                     "height_m",
                     "x_m",
                     "y_m",
                     "time_s",
                     "voltage_V",
                     "thrust_ratio",
                     "forward_tilt_rad",
                     "left_tilt_rad",
                     "yaw_rate_radps"};
  const VehicleModel& vehicle = session.vehicle();
  const double hover = vehicle.hover_speed_radps();
  for (std::size_t f = 0; f < session.flights().size(); ++f) {
    const FlightData& flight = session.flights()[f];
    const auto length = static_cast<std::size_t>(std::max(1.0, std::round(decisions::block_s / flight.sample_s)));
    const CommandRecord& record = flight.rotor_record();
    for (std::size_t first = length; first + length <= flight.samples.size(); first += length) {
      Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
      Eigen::VectorXd value = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(result.variable.size()));
      for (std::size_t k = first; k < first + length; ++k) {
        const Motion& m = flight.motion[k];
        // what reacts to the disturbance enters with its past
        const Motion& before = flight.motion[k - length];
        const Matrix3 R = m.attitude_WB.toRotationMatrix();
        const auto& d = smoothed[f].disturbance[k];
        wrench.head<3>() += vehicle.mass_kg * (R.transpose() * d.head<3>());
        wrench.tail<3>() += vehicle.inertia_B_kgm2 * d.tail<3>();
        const Vector3 v = R.transpose() * m.velocity_W_mps;
        const RotorArray speed =
            record.mean(flight.samples[k - length].time_s - flight.sample_s, flight.samples[k - length].time_s);
        double thrust = 0.0;
        for (int i = 0; i < vehicle.rotor_count; ++i)
          thrust += std::pow(speed[static_cast<std::size_t>(i)] / hover, 2) / vehicle.rotor_count;
        const Vector3 up = before.attitude_WB.conjugate() * Vector3::UnitZ();
        Eigen::VectorXd now(value.size());
        now << v, v.norm(), m.position_W_m.z(), m.position_W_m.x(), m.position_W_m.y(),
            flight.samples[k].time_s - flight.start_s, flight.samples[k].voltage_V, thrust, -up.x(), -up.y(),
            before.body_rate_B_radps.z();
        value += now;
      }
      result.flight.push_back(static_cast<int>(f));
      result.wrench.push_back(wrench / static_cast<double>(length));
      result.value.push_back(value / static_cast<double>(length));
    }
  }
  return result;
}

namespace {

// where the rest of each channel stands: smooth functions of single variables, significance by circular shift on the maximum over all pairs
void find_regions(const Blocks& before, std::vector<Mismatch>& result) {
  const auto count = static_cast<Eigen::Index>(before.wrench.size());
  if (count < 30) return;
  std::vector<int> fold;
  for (Eigen::Index i = 0; i < count; ++i) fold.push_back(static_cast<int>(i / 10));
  std::vector<SmoothPredictor> predictors;
  std::vector<Eigen::VectorXd> x;
  for (std::size_t v = 0; v < before.variable.size(); ++v) {
    Eigen::VectorXd column(count);
    for (Eigen::Index i = 0; i < count; ++i)
      column[i] = before.value[static_cast<std::size_t>(i)][static_cast<Eigen::Index>(v)];
    x.push_back(column);
    predictors.emplace_back(column, fold);
  }
  const auto series = [&](int c, Eigen::Index shift) {
    Eigen::VectorXd y(count);
    for (Eigen::Index i = 0; i < count; ++i) y[i] = before.wrench[static_cast<std::size_t>(i)][c];
    y = moved_along(y, before.flight, shift);
    return Eigen::VectorXd(y.array() - y.mean());
  };
  std::vector<double> largest_shifted;
  for (Eigen::Index shift = 4; shift <= 44; shift += 2) {
    double most = 0.0;
    for (int c = 0; c < 6; ++c) {
      const Eigen::VectorXd y = series(c, shift);
      for (const SmoothPredictor& p : predictors) most = std::max(most, p.explained(y));
    }
    largest_shifted.push_back(most);
  }
  std::sort(largest_shifted.begin(), largest_shifted.end());
  const double threshold = std::max(decisions::least_where, largest_shifted[largest_shifted.size() - 2]);
  for (int c = 0; c < 6; ++c) {
    if (!result[static_cast<std::size_t>(c)].significant) continue;
    const Eigen::VectorXd y = series(c, 0);
    std::vector<std::pair<double, std::size_t>> explained;
    for (std::size_t v = 0; v < predictors.size(); ++v) explained.emplace_back(predictors[v].explained(y), v);
    std::stable_sort(explained.begin(), explained.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [share, v] : explained)
      if (share > threshold && result[static_cast<std::size_t>(c)].where.size() < 2)
        result[static_cast<std::size_t>(c)].where.push_back(region(before.variable[v], x[v], y));
  }
}

// what a delay of the pose, of the command or a lag would gain, from the nominal vehicle
Mismatch latency_mismatch(const Session& session, const Eigen::MatrixXd& total, Place place,
                          std::initializer_list<Latency> kinds, double rows, double largest) {
  const Catalogue& catalogue = session.catalogue();
  const double alone = solve(total, session.biases()).loss;
  Mismatch m;
  m.channel = place == Place::actuation ? "actuation" : "timing";
  m.unit = "s";
  double best = 0.0;
  for (const Latency kind : kinds) {
    const int g = catalogue.find(place, kind);
    if (g < 0) continue;
    std::vector<int> columns = catalogue.group(g).columns;
    const int c = columns.front();
    const int size = static_cast<int>(columns.size());
    columns.insert(columns.end(), session.biases().begin(), session.biases().end());
    const Fit fit = solve(total, columns);
    if (alone - fit.loss <= best) continue;
    best = alone - fit.loss;
    const Column& column = catalogue.column(c);
    m.p_value = chi_squared_tail(best, size);
    m.rms = std::abs(fit.coefficient[0] * column.natural);
    m.noise_rms = column.tolerance;
    m.significant =
        beyond_chance(best, size, rows) && m.rms > column.tolerance && best > decisions::least_timing * largest;
  }
  return m;
}

}  // namespace

std::vector<Mismatch> locate(Session& session, const Selection& selection, const Remainder& rest) {
  const Catalogue& catalogue = session.catalogue();
  session.noise = selection.noise_selected;
  session.linearise(catalogue.nominal(), session.all_columns());
  const double rows = selection.degrees_of_freedom;

  // smooth functions of the state, per channel
  std::vector<Mismatch> result;
  const auto families = channel_bases(session);
  const std::vector<FamilyDeltaChi2> of_families = delta_chi2_of_families(session, families, session.biases());
  double largest = 0.0;
  for (const FamilyDeltaChi2& family : of_families) largest = std::max(largest, family.all);
  const Blocks before = blocks(session, selection.smoothed_nominal),
               after = blocks(session, selection.smoothed_selected);
  const auto rms = [](const Blocks& b, int c) {
    double sum = 0.0;
    for (const auto& w : b.wrench) sum += w[c] * w[c];
    return std::sqrt(sum / std::max<double>(1.0, static_cast<double>(b.wrench.size())));
  };
  for (int c = 0; c < 6; ++c) {
    Mismatch m;
    m.channel = channel_name[static_cast<std::size_t>(c)];
    const double delta_chi2 = of_families[static_cast<std::size_t>(c)].all;
    m.p_value = chi_squared_tail(delta_chi2, families[static_cast<std::size_t>(c)].size);
    m.significant = beyond_chance(delta_chi2, families[static_cast<std::size_t>(c)].size, rows) &&
                    delta_chi2 > decisions::least_channel * largest;
    for (const Alarm& alarm : rest.alarms)
      m.significant |= std::find(alarm.channels.begin(), alarm.channels.end(), m.channel) != alarm.channels.end();
    m.rms = rms(before, c);
    m.noise_rms = rms(after, c);
    m.unit = c < 3 ? "N" : "N m";
    result.push_back(m);
  }

  find_regions(before, result);
  const Eigen::MatrixXd total = session.grams().total();
  result.push_back(latency_mismatch(session, total, Place::actuation, {Latency::lag, Latency::delay}, rows, largest));
  result.push_back(latency_mismatch(session, total, Place::measurement, {Latency::delay}, rows, largest));
  return result;
}

}  // namespace gustlab::diagnosis
