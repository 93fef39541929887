// FNV-1a (Fowler, Noll, Vo), 128 bit: tells texts apart, and keeps no secret.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace gustlab::config {

class Hash {
 public:
  Hash& add(std::string_view bytes) {
    for (const char c : bytes) value_ = (value_ ^ static_cast<unsigned char>(c)) * prime;
    return *this;
  }
  std::array<std::uint64_t, 2> words() const {
    return {static_cast<std::uint64_t>(value_ >> 64), static_cast<std::uint64_t>(value_)};
  }

 private:
  using Word = unsigned __int128;
  static constexpr Word prime = (Word{1} << 88) + (Word{1} << 8) + 0x3b;
  Word value_ = (Word{0x6c62272e07bb0142} << 64) + 0x62b821756295c58d;
};

}  // namespace gustlab::config
