// SHA-256 (FIPS 180-4), for checksums that people compare.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace gustlab {

// Of bytes that come one piece after the other.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  // 64 hex digits of all that was added; nothing can be added any more.
  std::string digest();

 private:
  std::array<std::uint32_t, 8> hash_;
  std::string rest_;  // less than a block
  std::uint64_t bytes_ = 0;
};
std::string sha256(std::string_view bytes);
// Of a file; in memory is a block of it. Throws DataError when it cannot be read, or is larger.
std::string sha256_of_file(const std::string& path, std::size_t most_bytes);

}  // namespace gustlab
