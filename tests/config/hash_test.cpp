// FNV-1a of 128 bits against its published test vectors (draft-eastlake-fnv, isthe.com/chongo/tech/comp/fnv).
#include "config/hash.hpp"

#include <gtest/gtest.h>

namespace gustlab::config {
namespace hash_test {

using Words = std::array<std::uint64_t, 2>;

TEST(Hash, HasThePublishedValues) {
  EXPECT_EQ(Hash().words(), (Words{0x6c62272e07bb0142, 0x62b821756295c58d}));
  EXPECT_EQ(Hash().add("a").words(), (Words{0xd228cb696f1a8caf, 0x78912b704e4a8964}));
  EXPECT_EQ(Hash().add("foobar").words(), (Words{0x343e1662793c64bf, 0x6f0d3597ba446f18}));
}

TEST(Hash, IsOfAllBytesInTheirOrderAndNotOfTheirParts) {
  EXPECT_EQ(Hash().add("foo").add("").add("bar").words(), Hash().add("foobar").words());
  EXPECT_NE(Hash().add("foobra").words(), Hash().add("foobar").words());
  EXPECT_NE(Hash().add(std::string_view("a\0", 2)).words(), Hash().add("a").words());
  EXPECT_NE(Hash().add("\xff").words(), Hash().add("\x7f").words());
}

}  // namespace hash_test
}  // namespace gustlab::config
