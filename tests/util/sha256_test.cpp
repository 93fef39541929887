#include "util/sha256.hpp"

#include <gtest/gtest.h>

namespace gustlab {
namespace sha256_test {

// FIPS 180-4 examples (NIST, "Examples with Intermediate Values"), and every length around the padding's edge
TEST(Sha256, KnownAnswers) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1000000, 'a')), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  // coreutils' sha256sum
  EXPECT_TRUE(sha256(std::string(55, 'a')).starts_with("9f4390f8d30c2dd9"));
  EXPECT_TRUE(sha256(std::string(56, 'a')).starts_with("b35439a4ac6f0948"));
  EXPECT_TRUE(sha256(std::string(64, 'a')).starts_with("ffe054fe7ae0cb6d"));
}

TEST(Sha256, PiecesAreTheWhole) {
  const std::string bytes = std::string(100, 'a') + std::string(200, 'b');
  for (const std::size_t piece : {1u, 63u, 64u, 65u, 299u}) {
    Sha256 hash;
    for (std::size_t at = 0; at < bytes.size(); at += piece) hash.add(std::string_view(bytes).substr(at, piece));
    EXPECT_EQ(hash.digest(), sha256(bytes)) << piece;
  }
}

}  // namespace sha256_test
}  // namespace gustlab
