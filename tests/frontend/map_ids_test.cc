// Ids of one kind do not compile as ids of another, nor numbers as ids.

#include <highwall/frontend/map/map_ids.h>

#include <array>
#include <concepts>
#include <cstdint>
#include <sstream>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/map/map.h>

namespace highwall::map_ids_test {
namespace {

template <class To, class From>
constexpr bool kConverts = std::is_convertible_v<From, To> || std::is_assignable_v<To&, From>;

template <class A, class B>
concept Compares = requires(A a, B b) {
  a == b;
}
|| requires(A a, B b) {
  a < b;
};

template <class T>
concept NamesAKeyFrame = requires(Map map, T id) {
  map.keyframe(id);
}
|| requires(Map map, T id) {
  map.ResolvePose(id);
}
|| requires(Map map, T id) {
  map.Successor(id);
};

// A landmark of the kind, and none of another: the type of the id says which.
template <class T, class Landmark>
concept NamesA = requires(Map map, T id, Id<Landmark> into) {
  { map.Find(id) } -> std::same_as<Landmark*>;
  map.Remove(id);
  map.Merge(id, into);
};

template <class T>
concept NamesASubmap = requires(Map map, T id) {
  map.Root(id);
}
|| requires(Map map, T id) {
  map.KeyFramesOf(id);
}
|| requires(Map map, T id) {
  map.gravity_W(id);
};

template <class K, class L>
concept CanObserve = requires(Map map, K keyframe, L landmark) {
  map.Observe(keyframe, 0, landmark);
};

// Indicates which of the four, keyframe, point, line and submap, a T can represent.
template <class T>
constexpr std::array<bool, 4> kNames = {NamesAKeyFrame<T>, NamesA<T, MapPoint>, NamesA<T, MapLine>,
                                        NamesASubmap<T>};

TEST(MapIds, OneKindDoesNotCompileAsAnother) {
  static_assert(!kConverts<LineId, PointId> && !kConverts<PointId, LineId>);
  static_assert(!kConverts<KeyFrameId, SubmapId> && !kConverts<SubmapId, KeyFrameId>);
  static_assert(!std::is_constructible_v<KeyFrameId, PointId>, "not even explicitly");
  static_assert(Compares<PointId, PointId> && !Compares<PointId, LineId>);
  static_assert(!Compares<KeyFrameId, SubmapId> && !Compares<KeyFrameId, PointId>);
  static_assert(!std::equality_comparable_with<PointId, LineId>);
}

TEST(MapIds, ANumberIsAnIdOnlyWhereItSaysSo) {
  static_assert(!kConverts<KeyFrameId, int> && !kConverts<KeyFrameId, std::int64_t>);
  static_assert(!kConverts<int, KeyFrameId> && !kConverts<std::size_t, PointId>);
  static_assert(!Compares<KeyFrameId, int> && !Compares<int, SubmapId>);
  static_assert(std::is_constructible_v<KeyFrameId, int>);
  static_assert(!std::is_constructible_v<KeyFrameId, double>);
}

TEST(MapIds, AMapIsAskedByIdsOfTheRightKind) {
  using Four = std::array<bool, 4>;
  static_assert(kNames<KeyFrameId> == Four{true, false, false, false});
  static_assert(kNames<PointId> == Four{false, true, false, false});
  static_assert(kNames<LineId> == Four{false, false, true, false});
  static_assert(kNames<SubmapId> == Four{false, false, false, true});
  static_assert(kNames<NoId> == Four{true, false, false, true}, "no landmark of no kind");
  static_assert(kNames<int> == Four{false, false, false, false});
  static_assert(CanObserve<KeyFrameId, LineId> && CanObserve<KeyFrameId, PointId>);
  static_assert(!CanObserve<KeyFrameId, KeyFrameId> && !CanObserve<KeyFrameId, SubmapId>);
  static_assert(!CanObserve<LineId, KeyFrameId> && !CanObserve<int, LineId>);
}

TEST(MapIds, AnswersOfAMapAreOfTheRightKind) {
  static_assert(!kConverts<std::vector<PointId>, std::vector<LineId>>);
  static_assert(std::is_same_v<decltype(IdTable<MapPoint>().ids()), std::vector<PointId>>);
  static_assert(std::is_same_v<decltype(IdTable<KeyFrame>().end_id()), KeyFrameId>);
}

TEST(MapIds, CostNoMoreThanANumber) {
  static_assert(sizeof(KeyFrameId) == sizeof(std::int32_t));
  static_assert(std::is_trivially_copyable_v<PointId>);
  static_assert(std::is_nothrow_default_constructible_v<LineId>);
}

TEST(MapIds, NoneIsBelowAllThatAreGiven) {
  EXPECT_EQ(PointId(), kNoId);
  EXPECT_NE(PointId(0), kNoId);
  EXPECT_LT(PointId(kNoId), PointId(0));
  EXPECT_LT(PointId(0), PointId(1));
  EXPECT_GE(PointId().index(), 1'000'000U) << "beyond any array";
}

TEST(MapIds, AreCountedHashedAndPrintedAsTheirNumbers) {
  KeyFrameId id(6);
  EXPECT_EQ(++id, KeyFrameId(7));
  EXPECT_EQ(id.value(), 7);
  EXPECT_EQ(id.index(), 7U);
  const std::unordered_map<KeyFrameId, int> values{{KeyFrameId(7), 1}, {kNoId, 2}};
  EXPECT_EQ(values.at(id), 1);
  EXPECT_EQ(values.at(kNoId), 2);
  std::ostringstream text;
  text << id << ' ' << LineId();
  EXPECT_EQ(text.str(), "7 -1");
}

}  // namespace
}  // namespace highwall::map_ids_test
