#include "util/sha256.hpp"

#include <bit>
#include <cmath>

#include "gustlab/errors.hpp"
#include "util/files.hpp"

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

void add_block(const unsigned char* block, const Constants& constants, std::array<Word, 8>& hash) {
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

const Constants& constants() {
  static const Constants all;
  return all;
}

constexpr std::size_t block_bytes = 64;

}  // namespace

Sha256::Sha256() : hash_(constants().initial) {}

void Sha256::add(std::string_view bytes) {
  bytes_ += bytes.size();
  rest_ += bytes;
  std::size_t at = 0;
  for (; at + block_bytes <= rest_.size(); at += block_bytes)
    add_block(reinterpret_cast<const unsigned char*>(rest_.data()) + at, constants(), hash_);
  rest_.erase(0, at);
}

std::string Sha256::digest() {
  // padding: a one, zeros, the length in bits
  const std::uint64_t bits = 8 * bytes_;
  std::string end(1, static_cast<char>(0x80));
  while ((rest_.size() + end.size()) % block_bytes != block_bytes - 8) end += '\0';
  for (int shift = 56; shift >= 0; shift -= 8) end += static_cast<char>(bits >> shift & 0xff);
  add(end);
  std::string text;
  for (const Word word : hash_)
    for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 0xf];
  return text;
}

std::string sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.digest();
}

std::string sha256_of_file(const std::string& path, std::size_t most_bytes) {
  Sha256 hash;
  if (const std::string why = read_blocks(path, most_bytes, [&](std::string_view bytes) { hash.add(bytes); });
      !why.empty())
    throw DataError(path + ": cannot read (" + why + ")");
  return hash.digest();
}

}  // namespace gustlab
