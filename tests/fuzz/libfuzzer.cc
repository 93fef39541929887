// The entry points of libFuzzer. GUSTLAB_FUZZ_TARGET names the reader.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "fuzz/readers.hpp"
#include "gustlab/errors.hpp"
#include "support/temporary_folder.hpp"

namespace {

const gustlab::fuzz::ReaderTarget* target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("GUSTLAB_FUZZ_TARGET");
  for (const auto& known : gustlab::fuzz::reader_targets())
    if (name != nullptr && known.name == std::string(name)) target = &known;
  if (target != nullptr) return 0;
  std::cerr << "fuzz: GUSTLAB_FUZZ_TARGET is none of";
  for (const auto& known : gustlab::fuzz::reader_targets()) std::cerr << ' ' << known.name;
  std::cerr << '\n';
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const gustlab::TemporaryFolder folder;
  try {
    target->read(std::string(reinterpret_cast<const char*>(data), size), folder.path().string());
  } catch (const gustlab::UserError&) {
    // an answer
  }
  return 0;
}
