// What a flight is called in everything that a diagnosis says.
#pragma once

#include <string>

namespace gustlab::diagnosis {

// A path without its folders; with the last of them where the file has the name that `gustlab run` gives to every flight.
inline std::string label_of(const std::string& path) {
  const std::size_t name = path.find_last_of('/') + 1;
  if (name < 2 || !path.substr(name).starts_with("flight.csv")) return path.substr(name);
  const std::size_t folder = path.find_last_of('/', name - 2) + 1;
  const std::string last = path.substr(folder, name - 1 - folder);
  return last.empty() || last == "." || last == ".." ? path.substr(name) : path.substr(folder);
}

}  // namespace gustlab::diagnosis
