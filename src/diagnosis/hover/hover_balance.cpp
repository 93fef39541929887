#include "diagnosis/hover/hover_balance.hpp"

#include <algorithm>
#include <cmath>

#include "diagnosis/result/decisions.hpp"

namespace gustlab::diagnosis {

namespace {

// hover: half seconds this slow on average, this far from take-off, landing and gaps
constexpr double slow_mps = 0.3, slow_vertical_mps = 0.15, margin_s = 1.0;
using decisions::block_s;

}  // namespace

Eigen::Vector4d wrench_per_newton(const VehicleModel& vehicle, int rotor_index) {
  const Rotor& rotor = vehicle.rotors[static_cast<std::size_t>(rotor_index)];
  const Vector3 moment = (rotor.position_B_m - vehicle.center_of_mass_B_m).cross(rotor.axis_B) -
                         rotor.direction * rotor.torque_ratio_m * rotor.axis_B;
  return {rotor.axis_B.z(), moment.x(), moment.y(), moment.z()};
}

namespace {

// blocks of hover: the mean thrust of every rotor in each, the speeds of all their samples, and the sum of their mean voltages
struct HoverBlocks {
  std::vector<std::vector<double>> thrust_N, speed_radps;  // per block; per rotor
  double volts = 0.0;
};

// one block, when it is hover
void add_block(const FlightData& flight, const VehicleModel& vehicle, std::size_t first, std::size_t length,
               HoverBlocks& out) {
  const CommandRecord& record = flight.rotor_record();
  const auto rotors = static_cast<std::size_t>(vehicle.rotor_count);
  double level = 0.0, vertical = 0.0, mean_V = 0.0;
  bool known = true;
  std::vector<double> thrust(rotors, 0.0);
  std::vector<RotorArray> speeds;
  const double n = static_cast<double>(length);
  for (std::size_t k = first; k < first + length; ++k) {
    const Sample& sample = flight.samples[k];
    known = known && (sample.channels & (has_position | has_velocity));
    level += flight.motion[k].velocity_W_mps.head<2>().norm() / n;
    vertical += std::abs(flight.motion[k].velocity_W_mps.z()) / n;
    mean_V += sample.voltage_V / n;
    speeds.push_back(record.mean(sample.time_s - flight.sample_s, sample.time_s));
    for (std::size_t i = 0; i < rotors; ++i)
      thrust[i] += vehicle.rotors[i].thrust_coefficient_Ns2 * speeds.back()[i] * speeds.back()[i] / n;
  }
  if (!known || level > slow_mps || vertical > slow_vertical_mps) return;
  out.thrust_N.push_back(thrust);
  out.volts += mean_V;
  for (const RotorArray& speed : speeds)
    for (std::size_t i = 0; i < rotors; ++i) out.speed_radps[i].push_back(speed[i]);
}

HoverBlocks hover_blocks(const FlightData& flight, const VehicleModel& vehicle) {
  HoverBlocks blocks;
  blocks.speed_radps.resize(static_cast<std::size_t>(vehicle.rotor_count));
  const auto length = static_cast<std::size_t>(std::max(1.0, std::round(block_s / flight.sample_s)));
  for (std::size_t begin = 0; begin < flight.samples.size();) {
    std::size_t end = begin + 1;
    while (end < flight.samples.size() && flight.samples[end].time_s - flight.samples[end - 1].time_s < block_s) ++end;
    const double from_s = flight.samples[begin].time_s + margin_s, to_s = flight.samples[end - 1].time_s - margin_s;
    for (std::size_t first = begin; first + length <= end; first += length)
      if (!(flight.samples[first].time_s < from_s) && !(flight.samples[first + length - 1].time_s > to_s))
        add_block(flight, vehicle, first, length, blocks);
    begin = end;
  }
  return blocks;
}

}  // namespace

std::optional<HoverBalance> hover_balance(const FlightData& flight, const VehicleModel& vehicle) {
  if (flight.collective_only || flight.samples.empty()) return std::nullopt;
  const HoverBlocks blocks = hover_blocks(flight, vehicle);
  const double n = static_cast<double>(blocks.thrust_N.size());
  if (n * block_s < least_hover_s) return std::nullopt;

  const auto rotors = static_cast<std::size_t>(vehicle.rotor_count);
  HoverBalance balance;
  balance.hover_s = n * block_s;
  balance.thrust_N.assign(rotors, 0.0);
  Eigen::Vector4d square = Eigen::Vector4d::Zero();
  for (const auto& thrust : blocks.thrust_N) {
    Eigen::Vector4d wrench = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < rotors; ++i) {
      balance.thrust_N[i] += thrust[i] / n;
      wrench += thrust[i] * wrench_per_newton(vehicle, static_cast<int>(i));
    }
    balance.wrench += wrench / n;
    square += wrench.cwiseAbs2() / n;
  }
  balance.deviation = ((square - balance.wrench.cwiseAbs2()).cwiseMax(0.0) / (n - 1.0)).cwiseSqrt();

  // a speed that is often the highest of all, or that needs more voltage than there was
  const double share_V =
      flight.has_voltage && vehicle.nominal_voltage_V > 0.0 ? blocks.volts / n / vehicle.nominal_voltage_V : 1.0;
  for (std::size_t i = 0; i < rotors; ++i) {
    const std::vector<double>& speed = blocks.speed_radps[i];
    const double top = *std::max_element(speed.begin(), speed.end());
    const auto at_top = std::count_if(speed.begin(), speed.end(), [&](double s) { return s > 0.999 * top; });
    const double most_N = vehicle.rotors[i].thrust_coefficient_Ns2 * std::pow(vehicle.max_speed_radps * share_V, 2);
    balance.limited.push_back(balance.thrust_N[i] > most_N ||
                              static_cast<double>(at_top) >
                                  decisions::often_limited * static_cast<double>(speed.size()));
  }
  return balance;
}

}  // namespace gustlab::diagnosis
