// Short concealed trials as a session: checked and prepared as diagnose() does, on one thread.
#pragma once

#include "diagnosis/estimation/session.hpp"
#include "diagnosis/recording/recordings.hpp"
#include "support/trials.hpp"

namespace gustlab::test {

// Flights of a few seconds, one a trajectory, with every command; a circle is held out.
inline diagnosis::Recordings short_flights(const std::string& concealed, std::vector<std::string> fit,
                                           double duration_s = 5.0, double log_rate_hz = 0.0,
                                           std::vector<std::string> sensors = {"pose", "gyroscope"}) {
  const TemporaryFolder folder;
  const diagnosis::DiagnoseOptions trial = fly_trial(folder, {.fit = std::move(fit),
                                                              .holdout = {"circle"},
                                                              .sensors = std::move(sensors),
                                                              .duration_s = duration_s,
                                                              .log_rate_hz = log_rate_hz,
                                                              .concealed = concealed});
  return check(diagnosis::read_recordings(trial.fit, trial.holdout, {}, std::nullopt));
}

inline diagnosis::Session session_of(const diagnosis::Recordings& flown) {
  return {diagnosis::prepare(flown.fit, flown.vehicle, {}), flown.vehicle, 1};
}

// Two flights (log_rate_hz 0: with every command), linearised about the vehicle file, with the noise that this leaves.
struct Unexplained {
  explicit Unexplained(const std::string& concealed, std::vector<std::string> sensors = {"pose", "gyroscope"},
                       double log_rate_hz = 100.0)
      : recordings(short_flights(concealed, {"multisine", "lemniscate"}, 8.0, log_rate_hz, std::move(sensors))) {
    session.linearise(session.value(), session.all_columns());
    session.learn_noise(6, session.biases());
  }
  const diagnosis::Group& group(ColumnFrom column) const {
    return session.catalogue().group(session.catalogue().find(column));
  }
  diagnosis::Recordings recordings;
  diagnosis::Session session = session_of(recordings);
};

}  // namespace gustlab::test
