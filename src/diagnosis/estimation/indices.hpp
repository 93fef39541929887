#pragma once

#include <algorithm>
#include <vector>

namespace gustlab::diagnosis {

// Where each of some columns stands among others, which hold all of them.
inline std::vector<int> indices_of(const std::vector<int>& some, const std::vector<int>& among) {
  std::vector<int> indices;
  for (const int c : some)
    indices.push_back(static_cast<int>(std::find(among.begin(), among.end(), c) - among.begin()));
  return indices;
}

}  // namespace gustlab::diagnosis
