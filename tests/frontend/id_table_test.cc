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

TEST(IdTable, VisitsTheValuesInAscendingOrder) {
  IdTable<Thing> table;
  for (int i = 0; i < 1000; ++i) table.Add();
  // The first page, one in the middle and the last keep no value.
  for (int i = 0; i < 1000; ++i) {
    if (i < 64 || (i >= 300 && i < 500) || i >= 950) table.Remove(ThingId(i));
  }
  for (Thing& thing : table) thing.value = 1;
  std::vector<ThingId> visited;
  for (const Thing& thing : std::as_const(table)) {
    EXPECT_EQ(thing.value, 1);
    visited.push_back(thing.id);
  }
  EXPECT_EQ(visited, table.ids());
  EXPECT_EQ(visited.size(), 686u);
}

TEST(IdTable, AddsAfterAllValuesWereRemoved) {
  IdTable<Thing> table;
  for (int i = 0; i < 200; ++i) table.Remove(table.Add().id);
  EXPECT_EQ(table.size(), 0u);
  EXPECT_TRUE(table.ids().empty());
  EXPECT_EQ(table.Add().id, ThingId(200));
  EXPECT_EQ(table.ids(), std::vector<ThingId>{ThingId(200)});
}

TEST(IdTable, PutKeepsTheIdAndTheNextIsAboveIt) {
  IdTable<Thing> table;
  EXPECT_EQ(table.Put({ThingId(130), 5}).value, 5);
  EXPECT_EQ(table.Put({ThingId(130), 6}).value, 6);  // replaces it
  EXPECT_EQ(table.Put({ThingId(2), 7}).value, 7);
  EXPECT_EQ(table.size(), 2u);
  EXPECT_EQ(table.Add().id, ThingId(131));
  EXPECT_EQ(table.ids(), (std::vector{ThingId(2), ThingId(130), ThingId(131)}));
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
