// Trials with a secret, flown by our own plant: the nominal vehicle in the sidecar, something else in the air
// (FORMATS.md §5). The recordings hold what sensors would say and nothing of what was concealed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gustlab/flight_log.hpp"
#include "simulation/experiment.hpp"

namespace gustlab {

struct ConcealedTrial {
  std::string name, kind;  // kind: clean, single, pair, … from the number of effects unless it is given
  std::vector<EffectSpec> concealed;
  Experiment experiment;                  // everything that acts
  std::vector<std::size_t> fit, holdout;  // indices of its trajectories
};

struct TrialsFile {
  std::vector<ConcealedTrial> trials;
  std::vector<std::string> sensors;  // pose, velocity, gyroscope, accelerometer, rotor_speed
};

// TRIALS.toml: an experiment (its [[effect]] tables are the room: noise, turbulence) with `fit` and `holdout` lists of
// trajectories, `sensors`, and [[trial]] tables: name, and optionally vehicle, effects, kind, fit, holdout.
// Throws ConfigError with file:line:col.
TrialsFile read_trials_file(const std::string& path, const std::vector<std::string>& overrides = {});

// Flies every trial and writes OUT/<trial>/{fit,holdout}_N.csv; returns the answers, one JSON object per line. Throws
// ConfigError for a flight that does not come to its end. The same bytes for any `jobs`. `progress` is called with flights that are
// flown, of all, from one thread at a time.
std::string fly_concealed_trials(const TrialsFile& file, const std::string& out, int jobs,
                                 const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace gustlab
