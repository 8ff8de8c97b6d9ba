#include <vector>

#include <gtest/gtest.h>

#include "local/local_mapper.h"
#include "local_mapper_fixture.h"
#include "support/id_literals.h"
#include "system/map_worker.h"

namespace highwall::map_worker_test {
namespace {

using testing::LocalMapperTest;
using testing::operator""_kf;

// A stage whose work is a submap; it counts calls.
class Stage final : public MapStage {
 public:
  explicit Stage(SubmapId submap = kNoId) : submap_(submap) {}
  bool IsIdle() const override { return submap_ == kNoId; }
  SubmapId submap() const override { return submap_; }
  void Drop() override {
    submap_ = kNoId;
    ++drops;
  }
  void Forget() override { ++forgets; }
  int drops = 0, forgets = 0;

 private:
  SubmapId submap_;
};

class MapWorkerTest : public LocalMapperTest {};

TEST_F(MapWorkerTest, IsFreeUnlessAStageWorksOnAWorld) {
  LocalMapper mapper(model, {});
  InsertWrongly(mapper);
  Stage idle, other;
  EXPECT_TRUE(MapWorker(mapper, {&idle, &other}).IsFree()) << "local adjustment is no such stage";
  Stage busy(kFirstSubmap);
  EXPECT_FALSE(MapWorker(mapper, {&idle, &busy}).IsFree());
}

TEST_F(MapWorkerTest, ALoopDiscardsTheWorkOfTheOtherStagesOnly) {
  LocalMapper mapper(model, {});
  InsertWrongly(mapper);
  Stage loop(kFirstSubmap), factors(kFirstSubmap), depth(kFirstSubmap);
  MapWorker worker(mapper, {&loop, &factors, &depth});
  worker.Preempt(loop);
  EXPECT_EQ(loop.drops, 0);
  EXPECT_EQ(factors.drops, 1);
  EXPECT_EQ(depth.drops, 1);
  EXPECT_FALSE(mapper.IsIdle()) << "local adjustment continues until the loop's result";
}

TEST_F(MapWorkerTest, AChangedWorldDiscardsWorkOnItAndTheStateOfAllStages) {
  LocalMapper mapper(model, {});
  const Pose wrong = InsertWrongly(mapper);
  const SubmapId second = map.AddSubmap();
  Stage here(kFirstSubmap), there(second), idle;
  MapWorker worker(mapper, {&here, &there, &idle});
  EXPECT_EQ(mapper.submap(), kFirstSubmap);
  worker.Drop(map, kFirstSubmap);
  EXPECT_EQ(here.drops, 1);
  EXPECT_EQ(there.drops, 0);
  EXPECT_EQ(idle.drops, 0);
  for (const Stage* stage : {&here, &there, &idle}) EXPECT_EQ(stage->forgets, 1);
  EXPECT_TRUE(mapper.IsIdle());
  EXPECT_FALSE(mapper.Finish(&map));
  EXPECT_EQ(map.keyframe(1_kf)->T_WC.Matrix(), wrong.Matrix()) << "nothing was applied";
}

TEST_F(MapWorkerTest, AnotherWorldLeavesLocalAdjustmentAsItIs) {
  LocalMapper mapper(model, {});
  InsertWrongly(mapper);
  MapWorker worker(mapper, {});
  worker.Drop(map, map.AddSubmap());
  EXPECT_FALSE(mapper.IsIdle());
}

TEST_F(MapWorkerTest, CompletesLocalAdjustmentBeforeAWorldIsEdited) {
  LocalMapper mapper(model, {});
  const Pose wrong = InsertWrongly(mapper);
  MapWorker worker(mapper, {});
  Pose at_edit;
  const auto report = worker.Edit(&map, [&] { at_edit = map.keyframe(1_kf)->T_WC; });
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->usable);
  EXPECT_NE(at_edit.Matrix(), wrong.Matrix()) << "it was adjusted by then";
  EXPECT_FALSE(worker.Edit(&map, [] {})) << "no adjustment was in progress";
}

}  // namespace
}  // namespace highwall::map_worker_test
