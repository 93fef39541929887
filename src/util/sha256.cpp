#include "util/sha256.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace gustlab {

namespace {

using Word = std::uint32_t;

// the first 32 bits of the fractional part of a root (FIPS 180-4, 4.2.2 and 5.3.3)
Word fraction(long double root) { return static_cast<Word>((root - std::floor(root)) * 4294967296.0L); }

struct Constants {
  std::array<Word, 64> round;   // cube roots of the first 64 primes
  std::array<Word, 8> initial;  // square roots of the first 8
  Constants() {
    std::size_t found = 0;
    for (unsigned candidate = 2; found < round.size(); ++candidate) {
      bool prime = true;
      for (unsigned divisor = 2; divisor * divisor <= candidate; ++divisor) prime = prime && candidate % divisor != 0;
      if (!prime) continue;
      if (found < initial.size()) initial[found] = fraction(std::sqrt(static_cast<long double>(candidate)));
      round[found++] = fraction(std::cbrt(static_cast<long double>(candidate)));
    }
  }
};

void digest(const unsigned char* block, const Constants& constants, std::array<Word, 8>& hash) {
  std::array<Word, 64> w;
  for (std::size_t t = 0; t < 16; ++t)
    w[t] =
        Word{block[4 * t]} << 24 | Word{block[4 * t + 1]} << 16 | Word{block[4 * t + 2]} << 8 | Word{block[4 * t + 3]};
  for (std::size_t t = 16; t < 64; ++t) {
    const Word small0 = std::rotr(w[t - 15], 7) ^ std::rotr(w[t - 15], 18) ^ (w[t - 15] >> 3);
    const Word small1 = std::rotr(w[t - 2], 17) ^ std::rotr(w[t - 2], 19) ^ (w[t - 2] >> 10);
    w[t] = small1 + w[t - 7] + small0 + w[t - 16];
  }
  auto [a, b, c, d, e, f, g, h] = hash;
  for (std::size_t t = 0; t < 64; ++t) {
    const Word big1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const Word big0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const Word first = h + big1 + ((e & f) ^ (~e & g)) + constants.round[t] + w[t];
    const Word second = big0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + first, d = c, c = b, b = a, a = first + second;
  }
  const std::array<Word, 8> step{a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < hash.size(); ++i) hash[i] += step[i];
}

}  // namespace

std::string sha256(std::string_view bytes) {
  static const Constants constants;
  // padding: a one, zeros, the length in bits
  std::string message(bytes);
  message += static_cast<char>(0x80);
  while (message.size() % 64 != 56) message += '\0';
  const std::uint64_t bits = 8 * static_cast<std::uint64_t>(bytes.size());
  for (int shift = 56; shift >= 0; shift -= 8) message += static_cast<char>(bits >> shift & 0xff);

  std::array<Word, 8> hash = constants.initial;
  for (std::size_t at = 0; at < message.size(); at += 64)
    digest(reinterpret_cast<const unsigned char*>(message.data()) + at, constants, hash);
  std::string text;
  for (const Word word : hash)
    for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 0xf];
  return text;
}

}  // namespace gustlab
