// What a calibration has flown, one line of JSON each in a file: a calibration that was killed goes on from there, with the same values.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace gustlab {

struct Evaluation {
  double loss = 0.0;
  std::vector<double> figures;            // of each target
  std::vector<std::vector<double>> runs;  // of each target, by replicate
};

class Evaluations {
 public:
  // Reads what the file holds; a line that was cut off goes. An empty path: nothing is kept.
  explicit Evaluations(std::string path);
  // nullptr: not flown yet
  const Evaluation* find(const std::string& key) const;
  // Throws IoError.
  void add(const std::string& key, const Evaluation& evaluation);

 private:
  std::string path_;
  std::map<std::string, Evaluation> known_;
};

}  // namespace gustlab
