// own random numbers: the same bytes on every machine and library
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace reality {

using Vec3 = Eigen::Vector3d;

/// xoshiro256++ (Blackman & Vigna 2019), seeded by splitmix64 from (seed, trial, stream); streams do not interact.
class Rng {
 public:
  Rng(std::uint64_t seed, std::uint64_t trial, std::uint64_t stream) {
    std::uint64_t x = seed;
    x = scramble(x) ^ (trial + 1) * 0xD1342543DE82EF95ULL;
    x = scramble(x) ^ (stream + 1) * 0xAF251AF3B0F025B5ULL;
    for (auto& word : word_) word = scramble(x);
  }

  std::uint64_t bits() {
    const std::uint64_t result = turn(word_[0] + word_[3], 23) + word_[0];
    const std::uint64_t t = word_[1] << 17;
    word_[2] ^= word_[0];
    word_[3] ^= word_[1];
    word_[1] ^= word_[2];
    word_[0] ^= word_[3];
    word_[2] ^= t;
    word_[3] = turn(word_[3], 45);
    return result;
  }

  /// uniform in [0, 1)
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  bool chance(double probability) { return uniform() < probability; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  /// a size between the two, with either sign
  double either(double low, double high) {
    const double size = uniform(low, high);
    return chance(0.5) ? size : -size;
  }
  int below(int count) { return static_cast<int>(uniform() * count); }

  /// standard normal, Box-Muller, one value per call
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }
  Vec3 normal3() {
    const double x = normal(), y = normal(), z = normal();
    return {x, y, z};
  }

 private:
  static std::uint64_t turn(std::uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }
  static std::uint64_t scramble(std::uint64_t& x) {
    std::uint64_t z = (x += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  std::uint64_t word_[4]{};
};

/// stationary Ornstein-Uhlenbeck process, advanced exactly
class Wander {
 public:
  Wander(double sigma, double time_s, Rng& rng) : sigma_(sigma), time_s_(time_s), value_(sigma * rng.normal()) {}
  double value() const { return value_; }
  void advance(double step_s, Rng& rng) {
    const double keep = std::exp(-step_s / time_s_);
    value_ = keep * value_ + sigma_ * std::sqrt(1.0 - keep * keep) * rng.normal();
  }

 private:
  double sigma_, time_s_, value_;
};

}  // namespace reality
