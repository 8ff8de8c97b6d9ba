#include <highwall/frontend/map/map_ids.h>

#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace highwall::id_table_test {
namespace {

using ThingId = Id<struct Thing>;

struct Thing {
  ThingId id;
  int value = 0;
};

TEST(IdTable, IdsAscendFromZeroAndAreNotGivenTwice) {
  IdTable<Thing> table;
  EXPECT_EQ(table.Add().id, ThingId(0));
  EXPECT_EQ(table.Add().id, ThingId(1));
  table.Remove(ThingId(1));
  EXPECT_EQ(table.Add().id, ThingId(2));
  EXPECT_EQ(table.end_id(), ThingId(3));
  EXPECT_EQ(table.size(), 2u);
}

TEST(IdTable, FindsExistingIdsOnly) {
  IdTable<Thing> table;
  table.Add().value = 7;
  table.Add();
  table.Remove(ThingId(1));
  ASSERT_NE(table.Find(ThingId(0)), nullptr);
  EXPECT_EQ(std::as_const(table).Find(ThingId(0))->value, 7);
  for (const ThingId id : {ThingId(), ThingId(1), ThingId(2)}) {
    EXPECT_EQ(table.Find(id), nullptr) << id;
    EXPECT_EQ(std::as_const(table).Find(id), nullptr) << id;
  }
  table.Remove(ThingId(5));  // nothing to remove
  EXPECT_EQ(table.size(), 1u);
}

TEST(IdTable, ValuesStayWhereTheyAreWhileOthersComeAndGo) {
  IdTable<Thing> table;
  const Thing* const first = &table.Add();
  for (int i = 1; i < 5000; ++i) {
    table.Add();
    if (i % 2 == 0) table.Remove(ThingId(i));
  }
  EXPECT_EQ(table.Find(ThingId(0)), first);
}

TEST(IdTable, ListsLiveIdsInAscendingOrder) {
  IdTable<Thing> table;
  for (int i = 0; i < 1000; ++i) table.Add();
  std::vector<ThingId> expected;
  for (int i = 0; i < 1000; ++i) {
    const ThingId id(i);
    if (i % 3 != 0) {
      table.Remove(id);
    } else {
      expected.push_back(id);
    }
  }
  EXPECT_EQ(table.ids(), expected);
}

TEST(IdTable, ACopyIsIndependent) {
  IdTable<Thing> table;
  table.Add().value = 1;
  IdTable<Thing> copy = table;
  copy.Find(ThingId(0))->value = 2;
  copy.Remove(ThingId(0));
  EXPECT_EQ(copy.Add().id, ThingId(1));
  ASSERT_NE(table.Find(ThingId(0)), nullptr);
  EXPECT_EQ(table.Find(ThingId(0))->value, 1);
}

}  // namespace
}  // namespace highwall::id_table_test
