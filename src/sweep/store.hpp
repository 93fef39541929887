// The result store: one SQLite file with the plan, the runs that are done, and where they came from.
//
// Every run is committed as it ends, in a write-ahead log: kill -9 at any moment loses only unfinished runs.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simulation/plan.hpp"
#include "sweep/results.hpp"
#include "sweep/sqlite.hpp"

namespace gustlab {

// Part i of N of a plan: every N-th run, from the i-th on.
struct Shard {
  std::size_t part = 1, parts = 1;
  bool has(std::size_t index) const { return index % parts == part - 1; }
  std::size_t index_of(std::size_t i) const { return part - 1 + i * parts; }  // its i-th run in the plan
};

// What a store says about itself, by name.
using Provenance = std::map<std::string, std::string>;
Provenance provenance_of(const Experiment& experiment, const Shard& shard);
// Names under which two provenances differ although results may only be put together when they agree: the experiment,
// or the program that flew it. Shard and CPU may differ.
std::vector<std::string> differences(const Provenance& a, const Provenance& b);
// How the experiment of a store (`there`) differs from another one, in words: the first difference; empty when they are equal.
std::string experiment_difference(const Provenance& there, const Provenance& here);

class RunStore {
 public:
  // Opens a store; Mode::create makes the file when it is not there. Throws DataError when it is no store, IoError when it
  // cannot be opened or another process writes it.
  RunStore(const std::string& path, Database::Mode mode);

  // Empty for a store that was just made.
  const Provenance& provenance() const { return provenance_; }
  void begin(const Provenance& provenance, const Experiment& experiment, const Plan& plan);

  // Of every planned run, whether it is done.
  std::vector<bool> done();
  void add(const RunRecord& record);
  // Forgets every run, and takes on the provenance of the program that will fly them.
  void start_over(const Provenance& provenance);
  // A planned run in words: trajectory, controller, replicate.
  std::string name_of(std::size_t run);
  // Copies the plan, or the runs, of another store of the same experiment; no run may be in both.
  void copy_plan(RunStore& from, const Provenance& provenance);
  void take_runs(RunStore& from);
  // One row for every run that is done, in plan order.
  void for_each(const std::function<void(ResultRow)>& use);
  Results results();
  // Folds the write-ahead log into the file, which may then be copied and read anywhere.
  void close();

 private:
  void write_provenance(const Provenance& provenance);

  Database database_;
  Provenance provenance_;
  double settle_s_ = 0.0;
  std::optional<Statement> insert_;
};

}  // namespace gustlab
