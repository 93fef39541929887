// SHA-256 (FIPS 180-4), for checksums that people compare.
#pragma once

#include <string>
#include <string_view>

namespace gustlab {

// 64 hex digits.
std::string sha256(std::string_view bytes);

}  // namespace gustlab
