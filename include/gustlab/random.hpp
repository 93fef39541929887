// Pure random numbers: a value is a function of (seed, replicate, stream, counter) and of nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace gustlab {

// Philox-4x32-10 (Salmon et al., SC'11, doi 10.1145/2063384.2063405), keyed by seed and stream.
class RandomStream {
 public:
  RandomStream() = default;
  // stream: a stable name such as "gust" or "measurement_noise"; two names are two independent streams.
  RandomStream(std::uint64_t seed, std::uint32_t replicate, std::string_view stream);

  // four uniforms in (0, 1) of one counter value
  std::array<double, 4> uniform4(std::uint64_t counter, std::uint32_t lane = 0) const;
  // four independent standard normals of one counter value (Box–Muller)
  std::array<double, 4> normal4(std::uint64_t counter, std::uint32_t lane = 0) const;

 private:
  std::uint32_t key0_ = 0, key1_ = 0, word2_ = 0;
};

}  // namespace gustlab
