// All runs of an experiment, on several cores, into a store that survives anything.
#pragma once

#include <atomic>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "sweep/store.hpp"

namespace gustlab {

// Flies runs on at most `jobs` threads: the records in the order of the runs, the same for any number of threads. At an
// interrupt the flights in hand are not finished, and it throws Interrupted.
std::vector<RunRecord> fly_all(const Experiment& experiment, std::span<const RunSpec> runs, int jobs);

struct SweepOptions {
  std::string out;  // folder of runs.sqlite and runs.csv
  Shard shard;
  int jobs = 1;
  bool resume = false;
  bool logs = false;  // writes the flight log of every run that has none: OUT/TRAJECTORY_CONTROLLER_REPLICATE.csv
};
struct SweepReport {
  std::size_t planned = 0;     // runs of the shard
  std::size_t done = 0;        // of those, now in the store, and with a log where it was asked for
  std::string redone_because;  // not empty: runs of another program were thrown away
};

// Throws ConfigError when the folder has results that are of none of these variants (all of an experiment, or the one without a name): one table
// would mix them.
void check_results_in(const std::string& out, const std::vector<Experiment>& variants);

// Throws ConfigError when the store is there without `resume`, or is of another experiment or shard. runs.csv is written
// when every run is done.
SweepReport sweep(const Experiment& experiment, const SweepOptions& options, const std::atomic<bool>& stop,
                  const std::function<void(std::size_t done, std::size_t planned)>& progress);

// Where the results of a variant are in the folder of a sweep: in one of its name.
std::string variant_folder(const std::string& out, const Experiment& experiment);
// The runs of all variants that are finished in one OUT/runs.csv, the values of the axes in columns of their own. Returns
// the names of those that are not.
std::vector<std::string> write_combined(const std::string& out);

// Joins shards of one experiment, of each of its variants, into `out`. Throws DataError when they differ, overlap, or leave a run out.
void merge(const std::vector<std::string>& folders, const std::string& out);

// Every planned run of a finished sweep, of all its variants where it has some. Throws DataError when there is no store, or runs
// are missing.
Results read_results(const std::string& folder);
// Those of one experiment, or variant, in the folder of its sweep. Throws DataError also when they are of another experiment.
Results read_results_of(const Experiment& experiment, const std::string& out);

}  // namespace gustlab
