// The same for every kind of landmark.

#include <highwall/frontend/map/landmark_table.h>

#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/map/map_ids.h>

namespace highwall::landmark_table_test {
namespace {

template <class Landmark>
class LandmarkTableOf : public ::testing::Test {
 public:
  using LandmarkId = Id<Landmark>;

  LandmarkTableOf() {
    for (int i = 0; i < 3; ++i) {
      KeyFrame& keyframe = keyframes_.Add();
      keyframe.points.assign(4, kNoId);
      keyframe.lines.assign(4, kNoId);
    }
  }

  LandmarkId Add() {
    const Landmark blank{};
    return table_.Add(LandmarkTraits<Landmark>::PositionOf(blank), 0).id;
  }
  KeyFrame* At(int keyframe) { return keyframes_.Find(KeyFrameId(keyframe)); }
  std::vector<LandmarkId> SeenBy(const std::vector<KeyFrameId>& keyframes,
                                 const std::vector<LandmarkId>& except = {}) {
    return LandmarkTable<Landmark>::SeenBy(keyframes_, keyframes, except);
  }

 protected:
  IdTable<KeyFrame> keyframes_;
  LandmarkTable<Landmark> table_;
};

using Kinds = ::testing::Types<MapPoint, MapLine>;
TYPED_TEST_SUITE(LandmarkTableOf, Kinds);

TEST(LandmarkKinds, PointsComeFirst) {
  std::string order;
  ForEachKind([&]<class Landmark>() { order += std::is_same_v<Landmark, MapPoint> ? "p" : "l"; });
  EXPECT_EQ(order, "pl");
}

TEST(LandmarkKinds, EachHasItsPartOfAStructure) {
  KeyFrame keyframe;
  const FrameFeatures features;
  PerKind<LandmarkIds> ids;
  EXPECT_EQ(&PartOf<MapPoint>(keyframe), &keyframe.points);
  EXPECT_EQ(&PartOf<MapLine>(keyframe), &keyframe.lines);
  EXPECT_EQ(&PartOf<MapPoint>(features), &features.points);
  EXPECT_EQ(&PartOf<MapLine>(ids), &ids.lines);
  static_assert(LandmarkKind<MapLine> && !LandmarkKind<KeyFrame>);
}

TYPED_TEST(LandmarkTableOf, KeepsBothRecordsOfAnObservationEqual) {
  const auto id = this->Add();
  EXPECT_TRUE(this->table_.Observe(this->At(1), 3, id));
  EXPECT_FALSE(this->table_.Observe(this->At(1), 2, id)) << "observed already";
  EXPECT_FALSE(this->table_.Observe(this->At(1), 3, this->Add())) << "feature assigned";
  EXPECT_TRUE(this->table_.Observe(this->At(0), 0, id));
  ASSERT_EQ(this->table_.Find(id)->observations.size(), 2u);
  EXPECT_EQ(this->table_.Find(id)->observations[0].keyframe, KeyFrameId(0)) << "ascending";
  EXPECT_EQ(PartOf<TypeParam>(*this->At(1))[3], id);
  this->table_.Forget(this->At(1), id);
  EXPECT_EQ(PartOf<TypeParam>(*this->At(1))[3], kNoId);
  this->table_.Forget(this->At(0), id);
  EXPECT_EQ(this->table_.Find(id), nullptr) << "none remains";
}

TYPED_TEST(LandmarkTableOf, RemovesAndMergesInKeyFramesToo) {
  const auto from = this->Add(), into = this->Add();
  this->table_.Observe(this->At(0), 0, from);
  this->table_.Observe(this->At(1), 0, from);
  this->table_.Observe(this->At(1), 1, into);
  this->table_.Merge(from, into, &this->keyframes_);
  EXPECT_EQ(this->table_.ids(), std::vector{into});
  EXPECT_EQ(PartOf<TypeParam>(*this->At(0))[0], into);
  EXPECT_EQ(PartOf<TypeParam>(*this->At(1))[0], kNoId);
  this->table_.Remove(into, &this->keyframes_);
  EXPECT_EQ(this->table_.size(), 0u);
  EXPECT_EQ(PartOf<TypeParam>(*this->At(0))[0], kNoId);
}

TYPED_TEST(LandmarkTableOf, ListsEachSeenOnceAscending) {
  const auto a = this->Add(), b = this->Add(), c = this->Add();
  this->Add();  // seen by none
  this->table_.Observe(this->At(0), 0, c);
  this->table_.Observe(this->At(0), 1, a);
  this->table_.Observe(this->At(1), 0, a);
  this->table_.Observe(this->At(2), 0, b);
  using Ids = std::vector<Id<TypeParam>>;
  EXPECT_EQ(this->SeenBy({KeyFrameId(0), KeyFrameId(1)}), (Ids{a, c}));
  EXPECT_EQ(this->SeenBy({KeyFrameId(2), KeyFrameId(0)}, {kNoId, c}), (Ids{a, b}));
  EXPECT_EQ(this->SeenBy({}), Ids{});
}

TYPED_TEST(LandmarkTableOf, CopiesWhatAKeyFrameObserves) {
  const auto seen = this->Add(), other = this->Add();
  for (int k = 0; k < 3; ++k) this->table_.Observe(this->At(k), 0, seen);
  this->table_.Observe(this->At(2), 1, other);
  IdTable<KeyFrame> some;
  some.Put(*this->At(0));
  some.Put(*this->At(1));
  LandmarkTable<TypeParam> copy;
  copy.Put(this->table_, *this->At(0), some);
  copy.Put(this->table_, *this->At(1), some);
  EXPECT_EQ(copy.ids(), std::vector{seen});
  EXPECT_EQ(copy.Find(seen)->observations.size(), 2u) << "those of the copied keyframes";
}

}  // namespace
}  // namespace highwall::landmark_table_test
