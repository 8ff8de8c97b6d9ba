#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/map_ids.h>

// Landmarks of a map, and what distinguishes one kind of them from another.
namespace [[gnu::visibility("default")]] highwall {

// 256-bit binary descriptor (of a point: the descriptor of its extractor, as bits; of a line: LBD).
using BinaryDescriptor256 = std::array<std::uint8_t, 32>;

// Feature `index` of keyframe `keyframe` observes the landmark.
struct Observation {
  KeyFrameId keyframe = kNoId;
  int index = 0;
};

struct MapPoint;
struct MapLine;
// Identifiers of points and lines. The tag of a landmark is its type, so a function template
// deduces the kind of landmark from its id.
using PointId = Id<MapPoint>;
using LineId = Id<MapLine>;

struct CornerPatch;  // internal

// A point landmark.
struct MapPoint {
  PointId id = kNoId;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();       // [m]
  BinaryDescriptor256 descriptor{};                    // of the observation nearest to all others
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // mean unit direction, camera -> point
  double min_distance = 0.0;                           // [m] scale-invariance range of the pyramid
  double max_distance = 0.0;                           // [m]
  std::vector<Observation> observations;               // ascending keyframes
  // Its appearance in the first observation; null if it was loaded.
  std::shared_ptr<const CornerPatch> patch;
  std::int64_t first_frame = 0;  // frame index of its creation
  int visible = 1;               // frames in whose view it was predicted
  int found = 1;                 // frames in which it was an inlier
};

// A line landmark: a segment of a line in space.
struct MapLine {
  LineId id = kNoId;
  Segment3 segment_W;  // [m]
  BinaryDescriptor256 descriptor{};
  bool has_descriptor = false;
  std::vector<Observation> observations;
  std::int64_t first_frame = 0;
  int visible = 1;
  int found = 1;
};

// What differs between the kinds of landmarks; everything else is written once for all of them.
// Each specialization has
//   Geometry, PositionOf(landmark): where the landmark is, in W,
//   VariableType, VariableAt(geometry): its block in an optimization,
//   Feature: an observation of it in an image,
//   PartOf(holder): the member about this kind of any structure with one member for each kind, such
//     as `points` of KeyFrame, of FrameFeatures and of PerKind,
//   Rotate(R, landmark): rotates what has a direction besides the geometry,
//   Shift(by_W, landmark): moves it by a vector [m],
//   kInInertialWindow: whether the tightly coupled smoother of InertialOdometry observes it.
template <class Landmark>
struct LandmarkTraits;

// Points: members are named `points`.
template <>
struct LandmarkTraits<MapPoint> {
  using Geometry = Eigen::Vector3d;  // [m]
  using VariableType = Eigen::Vector3d;
  using Feature = PointFeature;
  static constexpr bool kInInertialWindow = true;

  template <class AnyPoint>
  static auto& PositionOf(AnyPoint& point) {
    return point.p_W;
  }
  static VariableType VariableAt(const Geometry& p_W) { return p_W; }
  template <class Holder>
  static auto& PartOf(Holder& holder) {
    return holder.points;
  }
  template <class Rotation>
  static void Rotate(const Rotation& R, MapPoint& point) {
    point.normal_W = R * point.normal_W;
  }
  static void Shift(const Eigen::Vector3d& by_W, MapPoint& point) { point.p_W += by_W; }
};

// Lines: members are named `lines`.
template <>
struct LandmarkTraits<MapLine> {
  using Geometry = Segment3;  // [m]
  using VariableType = OrthonormalLine;
  using Feature = LineFeature;
  static constexpr bool kInInertialWindow = true;

  template <class AnyLine>
  static auto& PositionOf(AnyLine& line) {
    return line.segment_W;
  }
  static VariableType VariableAt(const Geometry& segment_W) {
    return OrthonormalLine(PluckerLine::FromPoints(segment_W.p(), segment_W.q()));
  }
  template <class Holder>
  static auto& PartOf(Holder& holder) {
    return holder.lines;
  }
  template <class Rotation>
  static void Rotate(const Rotation&, MapLine&) {}
  static void Shift(const Eigen::Vector3d& by_W, MapLine& line) {
    line.segment_W = Segment3(line.segment_W.p() + by_W, line.segment_W.q() + by_W);
  }
};

// A kind of landmark: MapPoint or MapLine.
template <class Landmark>
concept LandmarkKind = requires {
  typename LandmarkTraits<Landmark>::Geometry;
};

// One value for each kind of landmark.
template <template <class Landmark> class Value>
struct PerKind {
  Value<MapPoint> points;
  Value<MapLine> lines;
};
// A value for one kind of landmark, whichever it is.
template <template <class Landmark> class Value>
using AnyKind = std::variant<Value<MapPoint>, Value<MapLine>>;
// Ids of landmarks of one kind: PerKind<LandmarkIds> are ids of all kinds.
template <class Landmark>
using LandmarkIds = std::vector<Id<Landmark>>;
// Matches of one kind, from the index of a feature to the landmark.
template <class Landmark>
using LandmarkMatches = std::vector<std::pair<int, Id<Landmark>>>;

// Returns the member of a structure about one kind of landmark: PartOf<MapLine>(keyframe) is
// keyframe.lines.
template <LandmarkKind Landmark, class Holder>
auto& PartOf(Holder& holder) {
  return LandmarkTraits<Landmark>::PartOf(holder);
}

// Calls f.operator()<Landmark>() for each kind, points first.
template <class F>
void ForEachKind(F&& f) {
  f.template operator()<MapPoint>();
  f.template operator()<MapLine>();
}

}  // namespace highwall
