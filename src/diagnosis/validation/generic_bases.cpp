#include "diagnosis/validation/generic_bases.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "diagnosis/estimation/indices.hpp"

namespace gustlab::diagnosis {

namespace {

// what a basis function may look at, per sample
struct Look {
  PlaceFunctions place;  // functions of where it is
  Vector3 velocity_B;    // m/s
  double time;           // 0 … 1
  RotorArray past;       // mean command one to two samples ago over hover − 1
  RotorArray change;     // its last change over hover
};

std::vector<Look> looks(const FlightData& flight, const FlownVolume& volume, double hover) {
  std::vector<Look> result(flight.samples.size());
  const CommandRecord& record = flight.rotor_record();
  for (std::size_t k = 0; k < result.size(); ++k) {
    const Motion& m = flight.motion[k];
    const double t = flight.samples[k].time_s, dt = flight.sample_s;
    Look& look = result[k];
    look.place = volume.functions(m.position_W_m);
    look.velocity_B = m.attitude_WB.conjugate() * m.velocity_W_mps;
    look.time = (t - flight.start_s) / std::max(flight.duration_s(), dt);
    const RotorArray late = record.mean(t - dt, t), early = record.mean(t - 2.0 * dt, t - dt);
    for (std::size_t i = 0; i < max_rotors; ++i) {
      look.past[i] = late[i] / hover - 1.0;
      look.change[i] = (late[i] - early[i]) / hover;
    }
  }
  return result;
}

using Looks = std::shared_ptr<const std::vector<std::vector<Look>>>;  // [flight][sample]

Looks looks(const Session& session) {
  const FlownVolume volume(session);
  std::vector<std::vector<Look>> result;
  for (const FlightData& flight : session.flights())
    result.push_back(looks(flight, volume, session.vehicle().hover_speed_radps()));
  return std::make_shared<const std::vector<std::vector<Look>>>(std::move(result));
}

// one generic column: a function of the look that is a force along one axis of the world or the body, or a moment about one
struct Term {
  enum Kind { force_W, force_B, torque_B } kind;
  int axis;
  double size;  // m/s² or rad/s² per unit of the function
  std::function<double(const Look&)> function;
};

BasisFamily family(const std::string& name, const Session& session, const Looks& look, const std::vector<Term>& terms) {
  BasisFamily result;
  result.name = name;
  result.size = static_cast<int>(terms.size());
  for (const Term& term : terms) result.channel.push_back(term.axis + (term.kind == Term::torque_B ? 3 : 0));
  result.set = [&session, look, terms](std::size_t f, std::size_t k, Eigen::Ref<SpatialAccelerations> columns) {
    const Matrix3 R = session.flights()[f].motion[k].attitude_WB.toRotationMatrix();
    for (std::size_t j = 0; j < terms.size(); ++j) {
      const Term& term = terms[j];
      const double value = term.size * term.function((*look)[f][k]);
      columns.block<3, 1>(term.kind == Term::torque_B ? 3 : 0, static_cast<Eigen::Index>(j)) =
          value * (term.kind == Term::force_B ? Vector3(R.col(term.axis)) : Vector3(Vector3::Unit(term.axis)));
    }
  };
  return result;
}

}  // namespace

FlownVolume::FlownVolume(const Session& session) {
  Vector3 low = Vector3::Constant(1e9), high = -low;
  for (const FlightData& flight : session.flights())
    for (const Motion& m : flight.motion) {
      low = low.cwiseMin(m.position_W_m);
      high = high.cwiseMax(m.position_W_m);
    }
  middle_W_m_ = 0.5 * (low + high), half_m_ = (0.5 * (high - low)).cwiseMax(0.05), lowest_m_ = low.z();
}

PlaceFunctions FlownVolume::functions(const Vector3& position_W_m) const {
  const Vector3 p = (position_W_m - middle_W_m_).cwiseQuotient(half_m_);
  PlaceFunctions place;
  place.head<near_ground + 1>() << p, p.cwiseProduct(p), p.x() * p.y(),
      0.0025 / std::pow(std::max(position_W_m.z() - lowest_m_, 0.0) + 0.05, 2);
  int at = near_ground;
  for (const double x : {-0.7, 0.0, 0.7})
    for (const double y : {-0.7, 0.0, 0.7})
      place[++at] = std::exp(-(std::pow(p.x() - x, 2) + std::pow(p.y() - y, 2)) / (2.0 * 0.35 * 0.35));
  return place;
}

std::vector<BasisFamily> omnibus_bases(const Session& session) {
  const Looks look = looks(session);
  const auto floor = reference_floor(session.vehicle());
  const double turn = 6.0 * floor[2];

  std::vector<Term> position, velocity, time, command;
  for (int i = 0; i < PlaceFunctions::RowsAtCompileTime; ++i)
    for (int axis = 0; axis < 3; ++axis)
      position.push_back({Term::force_W, axis, 1.0, [i](const Look& l) { return l.place[i]; }});

  for (int i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      velocity.push_back({Term::force_B, axis, 1.0, [i](const Look& l) { return l.velocity_B[i]; }});
      velocity.push_back(
          {Term::force_B, axis, 1.0, [i](const Look& l) { return l.velocity_B.norm() * l.velocity_B[i]; }});
      velocity.push_back({Term::force_B, axis, 1.0, [i](const Look& l) { return l.velocity_B[i] * l.velocity_B[i]; }});
      velocity.push_back({Term::torque_B, axis, turn, [i](const Look& l) { return l.velocity_B[i]; }});
    }
  const std::vector<std::function<double(const Look&)>> clock = {
      [](const Look& l) { return l.time; }, [](const Look& l) { return l.time * l.time; },
      [](const Look& l) { return std::sin(2.0 * pi * l.time); },
      [](const Look& l) { return std::cos(2.0 * pi * l.time); }};
  for (const auto& f : clock)
    for (int axis = 0; axis < 3; ++axis) {
      time.push_back({Term::force_W, axis, 1.0, f});
      time.push_back({Term::torque_B, axis, turn, f});
    }
  for (std::size_t i = 0; i < static_cast<std::size_t>(session.vehicle().rotor_count); ++i) {
    const auto sign = [i](const Look& l) { return std::tanh(l.change[i] / 0.01); };
    for (int axis = 0; axis < 3; ++axis) command.push_back({Term::torque_B, axis, turn, sign});
    command.push_back({Term::force_B, 2, 1.0, sign});
    for (int axis = 0; axis < 2; ++axis)
      command.push_back({Term::torque_B, axis, turn, [i](const Look& l) { return l.past[i] * l.past[i]; }});
  }
  return {family("position", session, look, position), family("velocity", session, look, velocity),
          family("time", session, look, time), family("past command", session, look, command)};
}

std::vector<BasisFamily> channel_bases(const Session& session) {
  const Looks look = looks(session);
  const double turn = 6.0 * reference_floor(session.vehicle())[2];
  const auto total = [rotors = static_cast<std::size_t>(session.vehicle().rotor_count)](const Look& l) {
    double sum = 0.0;
    for (std::size_t i = 0; i < rotors; ++i) sum += l.past[i] / static_cast<double>(rotors);
    return sum;
  };
  std::vector<std::function<double(const Look&)>> state = {[](const Look&) { return 1.0; },
                                                           [](const Look& l) { return l.time; },
                                                           [](const Look& l) { return l.place[near_ground]; }, total,
                                                           [total](const Look& l) { return total(l) * total(l); }};
  for (int i = 0; i < 3; ++i) {
    state.emplace_back([i](const Look& l) { return l.velocity_B[i]; });
    state.emplace_back([i](const Look& l) { return l.velocity_B.norm() * l.velocity_B[i]; });
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(session.vehicle().rotor_count); ++i)
    state.emplace_back([i](const Look& l) { return l.past[i]; });
  std::vector<BasisFamily> result;
  for (int channel = 0; channel < 6; ++channel) {
    std::vector<Term> terms;
    for (const auto& f : state)
      terms.push_back({channel < 3 ? Term::force_B : Term::torque_B, channel % 3, channel < 3 ? 1.0 : turn, f});
    result.push_back(family(channel < 3 ? "smooth force" : "smooth torque", session, look, terms));
  }
  return result;
}

Eigen::MatrixXd gram_with(const Session& session, const BasisFamily& family, const std::vector<int>& columns) {
  std::vector<Grams> of_flight(session.flights().size());
  session.for_each_flight([&](std::size_t f) {
    const LinearFlight linear = only(session.linear()[f], columns);
    std::vector<int> to = indices_of(linear.columns, columns);
    for (int j = 0; j < family.size; ++j) to.push_back(static_cast<int>(columns.size()) + j);
    SpatialAccelerations of_sample;
    const FurtherColumns further = {family.size, [&](std::size_t k) -> const SpatialAccelerations& {
                                      family.set(f, k, of_sample.setZero(6, family.size));
                                      return of_sample;
                                    }};
    GramBlocks blocks(std::move(to), static_cast<int>(f), static_cast<int>(columns.size()) + family.size, of_flight[f],
                      true);
    add_innovations(session.flights()[f], linear, session.noise, blocks, further);
  });
  Grams grams;
  for (Grams& part : of_flight) append(std::move(part), grams);
  return grams.total();
}

void keep_small(const std::vector<Trim>& trims, std::size_t first, Eigen::MatrixXd& gram) {
  for (std::size_t i = 0; i < trims.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(first + i);
    gram(at, at) += 1.0 / (trims[i].deviation * trims[i].deviation);
  }
}

std::vector<FamilyDeltaChi2> delta_chi2_of_families(const Session& session, const std::vector<BasisFamily>& families,
                                                    const std::vector<int>& columns, const std::vector<Trim>& trims) {
  // one pass of the filter for all
  BasisFamily together;
  for (const BasisFamily& family : families) together.size += family.size;
  together.set = [&](std::size_t f, std::size_t k, Eigen::Ref<SpatialAccelerations> columns_of_all) {
    Eigen::Index at = 0;
    for (const BasisFamily& family : families) {
      family.set(f, k, columns_of_all.middleCols(at, family.size));
      at += family.size;
    }
  };
  std::vector<int> beside = columns;
  for (const Trim& trim : trims) beside.push_back(trim.column);
  Eigen::MatrixXd gram = gram_with(session, together, beside);
  keep_small(trims, columns.size(), gram);
  std::vector<int> known(beside.size());
  std::iota(known.begin(), known.end(), 0);
  const double before = solve(gram, known, 1e-6).loss;
  std::vector<FamilyDeltaChi2> result;
  int first = static_cast<int>(known.size());
  for (const BasisFamily& family : families) {
    FamilyDeltaChi2 delta_chi2;
    const auto with = [&](int channel) {
      std::vector<int> all = known;
      for (int j = 0; j < family.size; ++j)
        if (channel < 0 || family.channel[static_cast<std::size_t>(j)] == channel) all.push_back(first + j);
      return all;
    };
    delta_chi2.all = before - solve(gram, with(-1), 1e-6).loss;
    for (std::size_t c = 0; c < delta_chi2.channel.size(); ++c) {
      const std::vector<int> own = with(static_cast<int>(c));
      delta_chi2.size[c] = static_cast<int>(own.size() - known.size());
      if (delta_chi2.size[c] > 0)
        delta_chi2.channel[c] =
            delta_chi2.size[c] == family.size ? delta_chi2.all : before - solve(gram, own, 1e-6).loss;
    }
    result.push_back(delta_chi2);
    first += family.size;
  }
  return result;
}

}  // namespace gustlab::diagnosis
