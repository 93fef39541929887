#include "calibration/evaluations.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "config/json_text.hpp"
#include "gustlab/errors.hpp"
#include "util/files.hpp"

namespace gustlab {

using nlohmann::ordered_json;

Evaluations::Evaluations(std::string path) : path_(std::move(path)) {
  if (path_.empty()) return;
  std::ifstream file(path_);
  std::string kept;
  bool cut_off = false;
  for (std::string line; std::getline(file, line);) {
    Evaluation one;
    try {
      const ordered_json json = ordered_json::parse(line);
      json.at("loss").get_to(one.loss);
      json.at("figures").get_to(one.figures);
      json.at("runs").get_to(one.runs);
      known_[json.at("key").get<std::string>()] = std::move(one);
      kept += line + "\n";
    } catch (const nlohmann::json::exception&) {
      cut_off = true;
    }
    cut_off = cut_off || file.eof();  // the end of a line is written last
  }
  if (cut_off) write_file(path_, kept);
}

const Evaluation* Evaluations::find(const std::string& key) const {
  const auto found = known_.find(key);
  return found == known_.end() ? nullptr : &found->second;
}

void Evaluations::add(const std::string& key, const Evaluation& evaluation) {
  known_[key] = evaluation;
  if (path_.empty()) return;
  errno = 0;
  std::ofstream file(path_, std::ios::app);
  file << config::json_text(
              {{"key", key}, {"loss", evaluation.loss}, {"figures", evaluation.figures}, {"runs", evaluation.runs}})
       << "\n";
  if (!file.flush())
    throw IoError(fmt::format("{}: cannot write ({})", path_, std::strerror(errno != 0 ? errno : EIO)));
}

}  // namespace gustlab
