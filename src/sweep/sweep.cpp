#include "sweep/sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>
#include <ostream>
#include <utility>

#include "gustlab/errors.hpp"
#include "simulation/recorder.hpp"
#include "util/files.hpp"
#include "util/interrupt.hpp"
#include "util/parallel.hpp"

namespace gustlab {

namespace {

namespace fs = std::filesystem;

std::string store_path(const std::string& folder) { return (fs::path(folder) / "runs.sqlite").string(); }
std::string csv_path(const std::string& folder) { return (fs::path(folder) / "runs.csv").string(); }

void check_same_experiment(const std::string& path, const Provenance& there, const Provenance& here) {
  if (const std::string differs = experiment_difference(there, here); !differs.empty())
    throw ConfigError(fmt::format("{}: this store is of another experiment ({}); use another --out", path, differs));
}

void check_same_sweep(const std::string& path, const Provenance& there, const Provenance& here) {
  check_same_experiment(path, there, here);
  if (there.at("shard") != here.at("shard"))
    throw ConfigError(fmt::format("{}: this store is of shard {}, not {}; use another --out", path, there.at("shard"),
                                  here.at("shard")));
}

bool has_store(const std::string& folder) { return fs::is_regular_file(store_path(folder)); }

// A file of results where their folder is meant. Beside the runs.csv of variants stand their folders.
[[noreturn]] void fail_as_file(const std::string& file) {
  const fs::path parent = fs::path(file).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  const bool is_of_results = has_store(folder) || fs::path(file).filename() == csv_path("").c_str();
  throw DataError(fmt::format(
      "{}: is a file, not a folder of results; {}", file,
      is_of_results ? fmt::format("did you mean \"{}\"?", folder) : "name the folder that `gustlab sweep` wrote"));
}

std::unique_ptr<RunStore> open_to_read(const std::string& folder) {
  const std::string path = store_path(folder);
  if (fs::is_regular_file(folder)) fail_as_file(folder);
  if (!fs::is_regular_file(path))
    throw DataError(
        fmt::format("{}: no results here (runs.sqlite is missing); make them with `gustlab sweep EXPERIMENT --out {}`",
                    folder, folder));
  note_input(path);
  auto store = std::make_unique<RunStore>(path, Database::Mode::read);
  if (store->provenance().empty())
    throw DataError(fmt::format(
        "{}: not a result store of this program (it is empty: a sweep ended before its first run); go on with --resume",
        path));
  return store;
}

// all its runs are flown: that is when a sweep writes the table
bool is_finished(const std::string& folder) { return has_store(folder) && fs::is_regular_file(csv_path(folder)); }

// the names of the variants in the folder whose own folder is `wanted`, in the order of the experiment
std::vector<std::string> variants_in(const std::string& folder, bool (*wanted)(const std::string&) = has_store) {
  std::vector<std::pair<std::size_t, std::string>> found;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!wanted(entry.path().string())) continue;
    const std::string place = open_to_read(entry.path().string())->provenance().at("variant_place");
    found.emplace_back(0, entry.path().filename().string());
    std::from_chars(place.data(), place.data() + place.size(), found.back().first);
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> names;
  for (auto& [place, name] : found) names.push_back(std::move(name));
  return names;
}
// the folders of the stores of a sweep: of each variant, or the sweep's own
std::vector<std::string> store_folders(const std::string& folder) {
  std::vector<std::string> folders;
  if (!fs::exists(store_path(folder)))
    for (const std::string& name : variants_in(folder)) folders.push_back((fs::path(folder) / name).string());
  return folders.empty() ? std::vector<std::string>{folder} : folders;
}

// row by row: memory does not grow with the number of runs
void write_csv(
    const std::vector<RunStore*>& stores, const std::string& folder, void (*at_each_row)() = [] {}) {
  write_file(csv_path(folder), [&](std::ostream& file) {
    bool first = true;
    for (RunStore* store : stores)
      store->for_each([&](const ResultRow& row) {
        at_each_row();
        if (std::exchange(first, false)) file << csv_header(row.axes);
        file << csv_line(row);
      });
    if (first) file << csv_header({});
  });
}

// every planned run is in exactly one shard
void check_complete(const std::vector<std::string>& folders, const std::vector<std::unique_ptr<RunStore>>& shards) {
  std::vector<const std::string*> owner(shards.front()->done().size());
  for (std::size_t k = 0; k < shards.size(); ++k) {
    const std::vector<bool> done = shards[k]->done();
    if (done.size() != owner.size())
      throw DataError(fmt::format("{} and {} plan different runs", folders.front(), folders[k]));
    for (std::size_t run = 0; run < done.size(); ++run) {
      if (!done[run]) continue;
      if (owner[run])
        throw DataError(
            fmt::format("{} and {} both have run {} (each run may be in one shard only); leave one of them out",
                        *owner[run], folders[k], shards[k]->name_of(run)));
      owner[run] = &folders[k];
    }
  }
  const auto missing = std::count(owner.begin(), owner.end(), nullptr);
  const auto first = static_cast<std::size_t>(std::find(owner.begin(), owner.end(), nullptr) - owner.begin());
  if (missing > 0)
    throw DataError(
        fmt::format("{} of {} runs are missing, {} the first of them (every shard must be there, and finished)",
                    missing, owner.size(), shards.front()->name_of(first)));
}

// the whole is made beside, and the store takes its place last: where there is one, all is there
void write_merged(const std::vector<std::unique_ptr<RunStore>>& shards, const Provenance& merged,
                  const std::string& out) {
  for (const auto& entry : fs::directory_iterator(out)) remove_if_left_beside(entry.path().string());
  const ScratchFolder scratch(out);
  const std::string beside = scratch.path().string();
  RunStore store(store_path(beside), Database::Mode::create);
  store.copy_plan(*shards.front(), merged);
  for (const auto& shard : shards) store.take_runs(*shard);
  store.close();
  write_csv({&store}, beside, throw_if_interrupted);
  for (const auto& path : {csv_path, store_path})
    if (std::rename(path(beside).c_str(), path(out).c_str()) != 0)
      throw IoError(fmt::format("{}: cannot write ({})", path(out), std::strerror(errno)));
}

// where the log of a run goes: beside the store
std::string log_path(const Experiment& experiment, const RunSpec& spec, const std::string& folder) {
  return (fs::path(folder) / fmt::format("{}_{}_{}.csv", experiment.trajectories[spec.trajectory].name,
                                         experiment.controllers[spec.controller].name, spec.replicate))
      .string();
}
RunRecord run_with_log(const Experiment& experiment, const RunSpec& spec, const std::string& folder) {
  LoggedRun flown = run_logged(experiment, spec);
  write_run_log(std::move(flown.log), experiment, log_path(experiment, spec, folder));
  return flown.record;
}

// Shards of one experiment without variants, opened, when they can be merged into `out`.
std::vector<std::unique_ptr<RunStore>> shards_to_merge(const std::vector<std::string>& folders,
                                                       const std::string& out) {
  if (fs::exists(store_path(out)))
    throw ConfigError(
        fmt::format("{}: there are results already (a merge never overwrites); use another --out", store_path(out)));
  std::vector<std::unique_ptr<RunStore>> shards;
  for (const std::string& folder : folders) {
    shards.push_back(open_to_read(folder));
    const auto differ = differences(shards.front()->provenance(), shards.back()->provenance());
    if (!differ.empty())
      throw DataError(fmt::format("{} and {} do not belong together (their {} differ)", folders.front(), folder,
                                  fmt::join(differ, ", ")));
  }
  check_complete(folders, shards);
  // throws where a figure is none
  for (const auto& shard : shards) shard->for_each([](const ResultRow&) { throw_if_interrupted(); });
  return shards;
}

// The folder of the whole, and those above it, are made for what `fill` writes there, and go away again where it cannot.
void fill_folder(const std::string& out, const std::function<void()>& fill) {
  std::error_code error;
  std::vector<fs::path> missing;
  for (fs::path path = fs::absolute(out); !fs::exists(path, error) && path.has_relative_path();
       path = path.parent_path())
    missing.push_back(path);
  try {
    make_folder(out);
    fill();
  } catch (...) {
    for (const fs::path& path : missing)  // a link stays, and so does a folder with something in it
      if (const fs::path folder = fs::canonical(path, error); !error) fs::remove(folder, error);
    throw;
  }
}

void merge_stores(const std::vector<std::string>& folders, const std::string& out) {
  const std::vector<std::unique_ptr<RunStore>> shards = shards_to_merge(folders, out);
  Provenance merged = shards.front()->provenance();
  merged["shard"] = "1/1";
  // every kind of machine that took part
  for (const auto& shard : shards)
    if (const std::string& cpu = shard->provenance().at("cpu"); merged["cpu"].find(cpu) == std::string::npos)
      merged["cpu"] += " | " + cpu;

  fill_folder(out, [&] { write_merged(shards, merged, out); });
}

// Whether the whole of these shards stands in `out`, as a merge leaves it that is ended before its last variant.
bool is_merged(const std::vector<std::string>& folders, const std::string& out) {
  if (!is_finished(out)) return false;
  const auto shard = open_to_read(folders.front()), whole = open_to_read(out);
  const std::vector<bool> done = whole->done();
  return differences(shard->provenance(), whole->provenance()).empty() &&
         std::find(done.begin(), done.end(), false) == done.end();
}

// of each store how many variants its sweep was asked for; stores of earlier programs do not say
std::size_t variants_asked(const std::string& folder) {
  const Provenance provenance = open_to_read(folder)->provenance();
  const auto said = provenance.find("variants");
  std::size_t asked = 0;
  if (said != provenance.end()) std::from_chars(said->second.data(), said->second.data() + said->second.size(), asked);
  return asked;
}

// A variant that no shard has begun has left no folder.
void check_all_begun(const std::vector<std::string>& folders, const std::vector<std::string>& variants) {
  for (const std::string& folder : folders)
    for (const std::string& variant : variants) {
      const std::string place = (fs::path(folder) / variant).string();
      const std::size_t asked = has_store(place) ? variants_asked(place) : 0;
      if (asked > variants.size())
        throw DataError(
            fmt::format("{}: {} of {} variants are missing (no shard has begun them); go on with `gustlab sweep "
                        "--resume`, or merge "
                        "the folders of one variant",
                        folder, asked - variants.size(), asked));
    }
}

Results read_store(const std::string& folder) {
  const auto store = open_to_read(folder);
  Results results = store->results();
  const std::size_t planned = store->done().size();
  if (results.rows.size() != planned)
    throw DataError(fmt::format(
        "{}: {} of {} runs are done (a table needs every one); finish with --resume, or `gustlab merge` the shards",
        folder, results.rows.size(), planned));
  return results;
}

}  // namespace

std::vector<RunRecord> fly_all(const Experiment& experiment, std::span<const RunSpec> runs, int jobs) {
  std::vector<RunRecord> records(runs.size());
  parallel_for(static_cast<std::int64_t>(runs.size()), jobs, [&](std::int64_t i) {
    records[static_cast<std::size_t>(i)] = run(experiment, runs[static_cast<std::size_t>(i)], AtInterrupt::end);
  });
  return records;
}

namespace {

// Runs of another program are not mixed with ours; says what differs.
std::string start_over_if_different(RunStore& store, const Provenance& here) {
  std::string because;
  for (const std::string& name : differences(store.provenance(), here))
    because += fmt::format("{}{} was {}, is {}", because.empty() ? "" : "; ", name, store.provenance().at(name),
                           here.at(name));
  if (!because.empty()) store.start_over(here);
  return because;
}

// To open a store for writing changes it: one that was closed well is asked before. One with a log beside it is not, because
// only a writer can take the log in where memory is not shared (a network file system), nor one with a journal beside it,
// which only a writer can roll back (a disk that was full at the very end).
void check_closed(const std::string& path, const std::function<void(const RunStore&)>& check) {
  if (fs::exists(path) && !fs::exists(path + "-wal") && !fs::exists(path + "-journal"))
    check(RunStore(path, Database::Mode::read));
}

}  // namespace

void check_results_in(const std::string& out, const std::vector<Experiment>& variants) {
  const bool apart = !variants.front().variant.empty();
  if (apart && fs::exists(store_path(out)))
    throw ConfigError(fmt::format("{}: there are results already, of an experiment without variants; use another --out",
                                  store_path(out)));
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(out, error)) {
    const std::string path = store_path(entry.path().string()), name = entry.path().filename().string();
    check_closed(path, [&](const RunStore& there) {
      if (there.provenance().empty()) return;
      const auto variant = std::ranges::find(variants, name, &Experiment::variant);
      if (apart && variant != variants.end())
        return check_same_experiment(path, there.provenance(), provenance_of(*variant, Shard{}));
      if (apart || there.provenance().at("name").ends_with("." + name))
        throw ConfigError(fmt::format(
            "{}: there are results already, of a variant that this experiment does not have; use another --out", path));
    });
  }
}

SweepReport sweep(const Experiment& experiment, const SweepOptions& options, const std::atomic<bool>& stop,
                  const std::function<void(std::size_t done, std::size_t planned)>& progress) {
  const std::string path = store_path(options.out);
  if (fs::exists(path) && !options.resume)
    throw ConfigError(
        fmt::format("{}: there are results already (a sweep never overwrites); use --resume or another --out", path));
  make_folder(options.out);

  SweepReport report;
  const Plan runs(experiment);
  const Provenance here = provenance_of(experiment, options.shard);
  const auto check = [&](const RunStore& there) {
    if (!there.provenance().empty()) check_same_sweep(path, there.provenance(), here);
  };
  check_closed(path, check);
  RunStore store(path, Database::Mode::create);
  try {
    check(store);
  } catch (const UserError&) {
    store.close();  // without a log beside it
    throw;
  }
  if (store.provenance().empty()) store.begin(here, experiment, runs);
  else report.redone_because = start_over_if_different(store, here);

  const std::vector<bool> done = store.done();
  if (done.size() != runs.size())
    throw DataError(fmt::format("{}: {} runs are planned here, {} there (the store was changed by another program)",
                                path, runs.size(), done.size()));
  // a run that is in the store and has no log is flown again for it
  const auto is_left = [&](std::size_t run) {
    return !done[run] || (options.logs && !fs::exists(log_path(experiment, runs[run], options.out)));
  };
  for (std::size_t run = options.shard.index_of(0); run < runs.size(); run = options.shard.index_of(++report.planned))
    report.done += is_left(run) ? 0 : 1;
  progress(report.done, report.planned);
  std::mutex one_at_a_time;
  // whoever is free takes the next run, so that the order is one for any number of jobs
  std::atomic<std::size_t> next{0};
  const auto fly = [&](std::int64_t) {
    const std::size_t number = runs.in_turn(next++);
    if (stop || !options.shard.has(number) || !is_left(number)) return;
    const RunSpec spec = runs[number];
    const RunRecord record = options.logs ? run_with_log(experiment, spec, options.out) : run(experiment, spec);
    const std::lock_guard lock(one_at_a_time);
    if (!done[number]) store.add(record);
    progress(++report.done, report.planned);
  };
  try {
    parallel_for(static_cast<std::int64_t>(runs.size()), options.jobs, fly);
  } catch (const Interrupted&) {
    // the report says how far it came
  }

  store.close();
  if (report.done == report.planned) write_csv({&store}, options.out);
  return report;
}

std::string variant_folder(const std::string& out, const Experiment& experiment) {
  return experiment.variant.empty() ? out : (fs::path(out) / experiment.variant).string();
}

std::vector<std::string> write_combined(const std::string& out) {
  std::vector<std::unique_ptr<RunStore>> stores;
  std::vector<RunStore*> all;
  for (const std::string& variant : variants_in(out, is_finished)) {
    stores.push_back(open_to_read((fs::path(out) / variant).string()));
    all.push_back(stores.back().get());
  }
  write_csv(all, out);
  std::vector<std::string> left_out;
  for (const auto& entry : fs::directory_iterator(out))
    if (has_store(entry.path().string()) && !is_finished(entry.path().string()))
      left_out.push_back(entry.path().filename().string());
  std::sort(left_out.begin(), left_out.end());
  return left_out;
}

void merge(const std::vector<std::string>& folders, const std::string& out) {
  interrupted();
  for (const std::string& folder : folders) check_input_path(folder);
  // of each shard: one that was ended in its first variant has no more
  std::vector<std::string> variants;
  for (const std::string& folder : folders)
    if (!fs::exists(store_path(folder)))
      for (std::string& name : variants_in(folder))
        if (std::ranges::find(variants, name) == variants.end()) variants.push_back(std::move(name));
  if (variants.empty()) return merge_stores(folders, out);
  const auto place = [](const std::string& folder, const std::string& name) {
    return (fs::path(folder) / name).string();
  };
  const auto of = [&](const std::string& variant) {
    std::vector<std::string> shards;
    for (const std::string& folder : folders) shards.push_back(place(folder, variant));
    return shards;
  };
  check_all_begun(folders, variants);
  std::vector<std::string> left;
  for (const std::string& variant : variants)
    if (!has_store(folders.front() + "/" + variant) || !is_merged(of(variant), place(out, variant)))
      left.push_back(variant);
  if (left.empty() && fs::exists(csv_path(out))) left = variants;  // nothing is left to do: it says so
  // nothing is written before all of it can be
  for (const std::string& variant : left) shards_to_merge(of(variant), place(out, variant));
  for (const std::string& variant : left) merge_stores(of(variant), place(out, variant));
  write_combined(out);
}

Results read_results_of(const Experiment& experiment, const std::string& out) {
  check_input_path(out);
  const std::string folder = variant_folder(out, experiment);
  const std::string differs =
      experiment_difference(open_to_read(folder)->provenance(), provenance_of(experiment, Shard{}));
  if (!differs.empty())
    throw DataError(fmt::format(
        "{}: these results are of another experiment ({}); give the experiment, --set and --seed of the sweep",
        store_path(folder), differs));
  return read_store(folder);
}

Results read_results(const std::string& folder) {
  check_input_path(folder);
  Results all;
  note_input(csv_path(folder));
  bool first = true;
  for (const std::string& one : store_folders(folder)) {
    note_input(csv_path(one));
    Results results = read_store(one);
    if (!std::exchange(first, false)) {
      if (results.settle_s != all.settle_s)
        throw DataError(
            fmt::format("{}: its variants settle for {} s and for {} s (no table has both); name a variant's folder",
                        folder, all.settle_s, results.settle_s));
      if (results.arcs != all.arcs) results.arcs.clear();
    }
    results.rows.insert(results.rows.begin(), std::make_move_iterator(all.rows.begin()),
                        std::make_move_iterator(all.rows.end()));
    all = std::move(results);
  }
  return all;
}

}  // namespace gustlab
