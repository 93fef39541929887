#include "diagnosis/estimation/session.hpp"

#include <gtest/gtest.h>

#include "support/sessions.hpp"

namespace gustlab::diagnosis {
namespace session_test {

// a set that was tried in vain leaves no number unasked
TEST(Session, OnlyTheseColumnsAreFrozen) {
  Session session = test::session_of(test::short_flights("", {"multisine"}, 2.0));
  const int group = session.catalogue().find("center_of_mass");
  const auto asked = [&] { return session.catalogue().group(group).columns; };
  const std::vector<int> all = session.all_columns(), own = asked();
  ASSERT_EQ(own.size(), 3u);
  session.freeze(own[2]);
  session.freeze(own[0]);
  EXPECT_EQ(asked(), std::vector<int>{own[1]});
  EXPECT_EQ(session.frozen(), (std::vector<int>{own[2], own[0]}));
  session.freeze_only({own[2]});
  EXPECT_EQ(asked(), (std::vector<int>{own[0], own[1]}));
  EXPECT_EQ(session.all_columns().size(), all.size() - 1);
  session.freeze_only({});
  EXPECT_EQ(asked(), own);
  EXPECT_EQ(session.all_columns(), all);
}

}  // namespace session_test
}  // namespace gustlab::diagnosis
