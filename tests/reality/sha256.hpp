#pragma once

#include <string>

namespace reality {

/// FIPS 180-4 SHA-256 of a byte string, as 64 lower-case hexadecimal digits.
std::string sha256(const std::string& bytes);

}  // namespace reality
