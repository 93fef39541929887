#include "draw.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "limit.hpp"
#include "oracle.hpp"
#include "outside.hpp"
#include "trial_settings.hpp"
#include "vehicle.hpp"

namespace reality {
namespace {

using Json = nlohmann::ordered_json;

enum Stream : std::uint64_t { kWhat = 0, kScatter = 1, kPaths = 2, kAirBefore = 100, kAir = 200 };
constexpr std::size_t kFlights = kFitFlights + 1;
constexpr int kAttempts = 16;
constexpr std::uint64_t kDraws = 16, kRedraw = 1ULL << 32;
constexpr double kTotalShare = 3e-4;  // of what all effects gain, DIAGNOSIS.md 3.6

struct Concealed {
  Plan plan;
  double factor = 0, strength = 0;
  Limit limit;
};

std::string file_name(std::size_t n) { return n < kFitFlights ? "fit_" + std::to_string(n + 1) : "holdout_1"; }

bool lost(const std::vector<Flight>& flights) {
  return std::any_of(flights.begin(), flights.end(), [](const Flight& f) { return f.lost; });
}

// a trial while it is drawn
class Draft {
 public:
  // what is concealed, the size and the noise belong to the trial; all else, redrawn, to another lot
  Draft(const Request& request, std::uint64_t index, std::uint64_t redraws)
      : request_(request), index_(index + redraws * kRedraw) {
    Rng trial(request.seed, index, kWhat);
    setting_ = draw_setting(request, trial);
    Rng rng = redraws == 0 ? trial : Rng(request.seed, index_, kWhat);
    // not everything flies in rough air, close to the ground for one
    if (request.roughness && redraws > 0) setting_ = draw_setting(request, rng);
    trial_.vehicle = nominal_vehicle(setting_.large, rng.chance(0.25) || setting_.needs(Need::drag));
    trial_.columns.velocity = rng.chance(0.8);
    trial_.columns.accel = rng.chance(0.35) || setting_.needs(Need::accel);
    trial_.columns.voltage = rng.chance(0.45);
    trial_.surroundings = draw_surroundings(setting_, rng);
    for (const auto& name : setting_.effects)
      concealed_.push_back({draw_plan(name, trial_.vehicle, trial_.columns.voltage, kFlights, rng), 0, 0, {}});
    for (Concealed& c : concealed_) c.factor = request.factor.value_or(rng.log_uniform(0.3, 10));
    if (!setting_.stranger.empty())
      stranger_ =
          draw_stranger(setting_.stranger, trial_.vehicle, request.factor.value_or(rng.log_uniform(0.6, 2.5)), rng);

    base_ = as_nominal(trial_.vehicle);
    base_.surroundings = trial_.surroundings;
    Rng errors(request.seed, index_, kScatter);
    scatter(base_, setting_.kind == "scatter" ? errors.uniform(0.5, 1.0) : 0.1, errors);
    // what is concealed carries no error of its own
    for (const Concealed& c : concealed_) plant(base_, c.plan.effect, values_at(c.plan, trial_.vehicle, 0, 0));
    scene_.columns = trial_.columns;
    scene_.noise = noise_level(setting_.large, setting_.noise);
    if (request.roughness) set_air(scene_.noise, setting_.large, *request.roughness, request.air);
    scene_.base.assign(kFitFlights, base_);
  }

  // draws paths until the vehicle flies all of them, ever more gently; nothing if it flies none
  std::optional<Trial> finish() {
    for (int attempt = 0; attempt < kAttempts; ++attempt)
      if (try_to_fly(attempt)) {
        answer();
        return std::move(trial_);
      }
    return {};
  }

 private:
  Flight fly_once(const Truth& truth, std::size_t n, Stream stream) const {
    return fly(truth, paths_[n], scene_.noise, request_.seed, index_, stream + 10 * n);
  }

  bool try_to_fly(int attempt) {
    const Figure figure[] = {Figure::circle, Figure::staircase, Figure::waypoints, Figure::holdout};
    paths_.clear();
    // a pilot swings a load gently
    const bool load =
        std::any_of(concealed_.begin(), concealed_.end(), [](const auto& c) { return c.plan.effect == "slung_load"; });
    const double calm = load ? 0.6 : 1;
    for (std::uint64_t n = 0; n < kFlights; ++n) {
      Rng rng(request_.seed, index_, kPaths + 10 * (n + 1) + 1000 * static_cast<std::uint64_t>(attempt));
      paths_.push_back(draw_path(figure[n], trial_.vehicle, trial_.surroundings, calm * std::pow(0.9, attempt), rng));
    }
    const double weaker = std::pow(0.85, std::max(0, attempt - kAttempts / 2));
    if (!concealed_.empty() || stranger_) {
      scene_.flight.clear();
      for (std::size_t n = 0; n < kFitFlights; ++n) scene_.flight.push_back(fly_once(base_, n, kAirBefore));
      if (lost(scene_.flight) || !size_up(weaker)) return false;
    }
    truth_.assign(kFlights, base_);
    for (std::size_t n = 0; n < kFlights; ++n) {
      for (const Concealed& c : concealed_)
        plant(truth_[n], c.plan.effect, values_at(c.plan, trial_.vehicle, c.strength, n));
      if (stranger_) truth_[n].outside = stranger_->physics;
    }
    trial_.flight.clear();
    for (std::size_t n = 0; n < kFlights; ++n) trial_.flight.push_back(fly_once(truth_[n], n, kAir));
    return !lost(trial_.flight);
  }

  // detection limits from the flights without the effects, then strengths; false if a load cannot be carried so
  bool size_up(double weaker) {
    double total = 0;
    for (Concealed& c : concealed_) {
      const double most = weaker * most_strength(c.plan, trial_.vehicle);
      if (c.plan.effect == "saturation") {
        const Bite bite = saturation_bite(c.plan, scene_, weaker * c.factor);
        c.strength = bite.strength;
        c.limit = bite.limit;
        c.factor = bite.factor;
      } else {
        const bool load = c.plan.effect == "slung_load";
        const Pushes pushes = load ? load_history(c.plan) : Pushes{};
        if (load && pushes.empty()) return false;
        c.limit = detection_limit(c.plan, scene_, pushes);
        c.strength = std::min(c.factor * c.limit.strength, most);
      }
      total += gain(c);
    }
    if (concealed_.size() < 2) return true;
    // beside a strong effect a weak one must also be material
    for (Concealed& c : concealed_) {
      if (c.plan.effect == "saturation" || c.plan.effect == "gust") continue;
      const double share = c.strength * std::sqrt(kTotalShare * total / gain(c));
      c.limit.materiality = std::max(c.limit.materiality, share);
      c.limit.strength = std::max(c.limit.strength, share);
      c.strength = std::min(c.factor * c.limit.strength, weaker * most_strength(c.plan, trial_.vehicle));
    }
    return true;
  }

  double gain(const Concealed& c) const { return 25 * std::pow(c.strength / c.limit.five_sigma, 2); }

  // cable force per kilogram of a light load along the fit flights; empty if it swings too far
  Pushes load_history(const Plan& plan) const {
    Pushes pushes;
    for (std::size_t n = 0; n < kFitFlights; ++n) {
      Truth loaded = base_;
      plant(loaded, plan.effect, values_at(plan, trial_.vehicle, 0.5, n));
      const Flight flight = fly_once(loaded, n, kAirBefore);
      if (flight.lost) return {};
      pushes.push_back(history(flight, 1 / loaded.load_kg));
    }
    return pushes;
  }

  static Pushes::value_type history(const Flight& flight, double scale) {
    Pushes::value_type pushes(static_cast<std::size_t>(std::lround(kFlight_s / kSample_s)),
                              Eigen::Matrix<double, 6, 1>::Zero());
    for (std::size_t k = 0; k < flight.sample.size(); ++k)
      pushes[k] << scale * flight.sample[k].extra_force_W_N, scale * flight.sample[k].extra_torque_B_Nm;
    return pushes;
  }

  void answer() {
    Json& a = trial_.answer;
    a["vehicle"] = trial_.vehicle.name;
    a["kind"] = setting_.kind;
    a["noise"] = setting_.noise;
    if (request_.roughness) {
      static const char* const kinds[] = {"steady", "gusty", "outdoor"};
      a["air"] = {{"roughness", *request_.roughness}, {"kind", kinds[static_cast<int>(request_.air)]}};
    }
    a["effects"] = Json::array();
    for (const Concealed& c : concealed_) a["effects"].push_back(describe(c));
    if (stranger_) {
      scene_.flight.assign(trial_.flight.begin(), trial_.flight.begin() + kFitFlights);
      const bool remembers = stranger_->physics.payload_kg > 0 || stranger_->physics.dropout_rotor >= 0;
      Pushes pushes;
      for (std::size_t n = 0; remembers && n < kFitFlights; ++n) pushes.push_back(history(trial_.flight[n], 1));
      const std::vector<Truth> with(truth_.begin(), truth_.begin() + kFitFlights);
      a["outside"] = {{"name", stranger_->name},
                      {"channels", stranger_->channels},
                      {"strength_over_limit", visibility(with, pushes, scene_)}};
    }
    a["oracle"] = oracle(as_nominal_in_room(), truth_.back(), trial_.flight.back());
  }

  Truth as_nominal_in_room() const {
    Truth t = as_nominal(trial_.vehicle);
    t.surroundings = trial_.surroundings;
    return t;
  }

  Json describe(const Concealed& c) const {
    Json entry;
    entry["effect"] = c.plan.effect;
    Values mean;
    for (std::size_t n = 0; n < kFitFlights; ++n)
      for (const auto& [name, value] : values_at(c.plan, trial_.vehicle, c.strength, n))
        mean[name] += value / kFitFlights;
    Json parameters = Json::object();
    for (const auto& [name, value] : mean) parameters[name] = value;
    if (c.plan.fixed.count("rotor")) parameters["rotor"] = static_cast<int>(c.plan.fixed.at("rotor"));
    entry["parameters"] = parameters;
    for (std::size_t n = 0; c.plan.direction.size() > 1 && n < kFlights; ++n)
      for (const auto& [name, value] : values_at(c.plan, trial_.vehicle, c.strength, n))
        entry["per_flight"][file_name(n) + ".csv"][name] = value;
    const double whole = c.limit.strength;
    entry["strength_over_limit"] = c.plan.effect == "saturation" ? c.factor : c.strength / whole;
    entry["limit_parts"] = {{"tolerance", c.limit.tolerance / whole},
                            {"materiality", c.limit.materiality / whole},
                            {"five_sigma", c.limit.five_sigma / whole}};
    return entry;
  }

  const Request& request_;
  std::uint64_t index_;
  Setting setting_;
  std::vector<Concealed> concealed_;
  std::optional<Stranger> stranger_;
  Truth base_;
  Scene scene_;
  std::vector<Path> paths_;
  std::vector<Truth> truth_;
  Trial trial_;
};

}  // namespace

Trial draw_trial(const Request& request, std::uint64_t index) {
  for (std::uint64_t redraws = 0; redraws < kDraws; ++redraws)
    if (auto trial = Draft(request, index, redraws).finish()) {
      trial->answer["redraws"] = redraws;
      return std::move(*trial);
    }
  throw std::runtime_error("trial " + std::to_string(index) + " does not fly, drawn " + std::to_string(kDraws) +
                           " times");
}

}  // namespace reality
