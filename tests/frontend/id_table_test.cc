#include <highwall/frontend/map/id_table.h>

#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace highwall {
namespace {

struct Thing {
  std::int32_t id = -1;
  int value = 0;
};

TEST(IdTable, IdsAscendFromZeroAndAreNotGivenTwice) {
  IdTable<Thing> table;
  EXPECT_EQ(table.Add().id, 0);
  EXPECT_EQ(table.Add().id, 1);
  table.Remove(1);
  EXPECT_EQ(table.Add().id, 2);
  EXPECT_EQ(table.end_id(), 3);
  EXPECT_EQ(table.size(), 2u);
}

TEST(IdTable, FindsWhatLivesAndNothingElse) {
  IdTable<Thing> table;
  table.Add().value = 7;
  table.Add();
  table.Remove(1);
  ASSERT_NE(table.Find(0), nullptr);
  EXPECT_EQ(std::as_const(table).Find(0)->value, 7);
  for (const std::int32_t id : {-1, 1, 2}) {
    EXPECT_EQ(table.Find(id), nullptr) << id;
    EXPECT_EQ(std::as_const(table).Find(id), nullptr) << id;
  }
  table.Remove(5);  // nothing to remove
  EXPECT_EQ(table.size(), 1u);
}

TEST(IdTable, ValuesStayWhereTheyAreWhileOthersComeAndGo) {
  IdTable<Thing> table;
  const Thing* const first = &table.Add();
  for (std::int32_t i = 1; i < 5000; ++i) {
    table.Add();
    if (i % 2 == 0) table.Remove(i);
  }
  EXPECT_EQ(table.Find(0), first);
}

TEST(IdTable, ListsLiveIdsInAscendingOrder) {
  IdTable<Thing> table;
  for (int i = 0; i < 1000; ++i) table.Add();
  for (std::int32_t id = 0; id < 1000; ++id) {
    if (id % 3 != 0) table.Remove(id);
  }
  std::vector<std::int32_t> expected;
  for (std::int32_t id = 0; id < 1000; id += 3) expected.push_back(id);
  EXPECT_EQ(table.ids(), expected);
}

TEST(IdTable, ACopyGoesItsOwnWay) {
  IdTable<Thing> table;
  table.Add().value = 1;
  IdTable<Thing> copy = table;
  copy.Find(0)->value = 2;
  copy.Remove(0);
  EXPECT_EQ(copy.Add().id, 1);
  ASSERT_NE(table.Find(0), nullptr);
  EXPECT_EQ(table.Find(0)->value, 1);
}

}  // namespace
}  // namespace highwall
