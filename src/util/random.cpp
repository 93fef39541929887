#include "gustlab/random.hpp"

#include <Random123/philox.h>

#include <cmath>

#include "gustlab/types.hpp"

namespace gustlab {

namespace {

// FNV-1a (Fowler, Noll, Vo), 64 bit: a stable number for a stream's name
std::uint64_t hash_name(std::string_view name) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return hash;
}

}  // namespace

// key = seed xor name; counter words = (counter low, counter high, replicate, lane)
RandomStream::RandomStream(std::uint64_t seed, std::uint32_t replicate, std::string_view stream) {
  const std::uint64_t name = hash_name(stream);
  key0_ = static_cast<std::uint32_t>(seed ^ name);
  key1_ = static_cast<std::uint32_t>((seed ^ name) >> 32);
  word2_ = replicate;
}

std::array<double, 4> RandomStream::uniform4(std::uint64_t counter, std::uint32_t lane) const {
  const r123::Philox4x32::ctr_type words = {
      {static_cast<std::uint32_t>(counter), static_cast<std::uint32_t>(counter >> 32), word2_, lane}};
  const r123::Philox4x32::key_type key = {{key0_, key1_}};
  const auto bits = r123::Philox4x32{}(words, key);
  std::array<double, 4> result;
  for (std::size_t i = 0; i < 4; ++i) result[i] = (static_cast<double>(bits[i]) + 0.5) * 0x1p-32;
  return result;
}

std::array<double, 4> RandomStream::normal4(std::uint64_t counter, std::uint32_t lane) const {
  const auto u = uniform4(counter, lane);
  const double a = std::sqrt(-2.0 * std::log(u[0])), b = std::sqrt(-2.0 * std::log(u[2]));
  return {a * std::cos(2.0 * pi * u[1]), a * std::sin(2.0 * pi * u[1]), b * std::cos(2.0 * pi * u[3]),
          b * std::sin(2.0 * pi * u[3])};
}

}  // namespace gustlab
