#include "diagnosis/estimation/indices.hpp"

#include <gmock/gmock.h>

namespace gustlab::diagnosis {
namespace indices_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(Indices, AreWhereEachStandsAmongTheOthers) {
  const std::vector<int> among = {9, 2, 5, 7};
  EXPECT_THAT(indices_of({7, 9, 2}, among), ElementsAre(3, 0, 1));
  EXPECT_THAT(indices_of({}, among), IsEmpty());
}

}  // namespace indices_test
}  // namespace gustlab::diagnosis
