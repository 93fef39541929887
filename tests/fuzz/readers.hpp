// Every reader as a function of bytes, for libFuzzer and for the replay of what it found.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace gustlab::fuzz {

struct ReaderTarget {
  const char* name;  // of its folder in tests/fuzz/corpus
  // Reads the bytes as a file in `folder`. A UserError is an answer; anything else is a finding.
  std::function<void(const std::string& bytes, const std::string& folder)> read;
};
const std::vector<ReaderTarget>& reader_targets();

}  // namespace gustlab::fuzz
