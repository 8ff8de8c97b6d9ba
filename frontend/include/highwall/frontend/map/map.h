#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/camera.h>
#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/map/map_ids.h>
#include <highwall/frontend/map/own_factors.h>

namespace [[gnu::visibility("default")]] highwall {

class ImuPreintegration;  // highwall/factors/imu_preintegration.h
class KeyFrameIndex;

// 256-bit binary descriptor (of a point, whatever its extractor has, as bits; LBD of a line).
using BinaryDescriptor256 = std::array<std::uint8_t, 32>;

// Feature `index` of keyframe `keyframe` observes the landmark.
struct Observation {
  KeyFrameId keyframe = kNoId;
  int index = 0;
};

struct CornerPatch;  // internal

// A point in space.
struct MapPoint {
  PointId id = kNoId;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();       // [m]
  BinaryDescriptor256 descriptor{};                    // of the observation nearest to all others
  Eigen::Vector3d normal_W = Eigen::Vector3d::Zero();  // mean unit direction, camera -> point
  double min_distance = 0.0;                           // [m] scale-invariance range of the pyramid
  double max_distance = 0.0;                           // [m]
  std::vector<Observation> observations;               // ascending keyframes
  // What it looked like where it was seen first; null where it was loaded.
  std::shared_ptr<const CornerPatch> patch;
  std::int64_t first_frame = 0;  // frame index of its creation
  int visible = 1;               // frames in whose view it was predicted
  int found = 1;                 // frames in which it was an inlier
};

// A piece of a line in space.
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

// The body's motion at a keyframe, and the readings of the IMU since an earlier one.
struct KeyFrameMotion {
  Stamp stamp = 0;                                 // [ns] of the IMU's clock
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();  // [m/s]
  ImuBias bias = ImuBias::Zero();                  // [rad/s, m/s^2]
  Eigen::Matrix<double, 6, 1> bias_sigma = Eigen::Matrix<double, 6, 1>::Ones();
  KeyFrameId previous = kNoId;                             // kNoId: nothing ties it to one before
  std::shared_ptr<const ImuPreintegration> from_previous;  // null with it
  double weight = 1.0;  // of its IMU factor: the mean over the images in between
};

// A frame that is kept, with its pose and the landmarks that it observes.
struct KeyFrame {
  KeyFrameId id = kNoId;
  SubmapId submap = kFirstSubmap;  // that it was made in
  Frame frame;
  Pose T_WC;
  cv::Mat depth_grid;  // of its features, but 0 where something moved: what others are held against
  double found = 0.0;  // share of the landmarks in view that it saw when it was tracked; 0: unknown
  std::optional<KeyFrameMotion> motion;  // with an IMU that is initialized
  std::vector<PointId> points;           // per point feature, kNoId where unmatched
  std::vector<LineId> lines;             // per line feature
};

// Keyframes, points and lines, owned by id. Ids ascend and are never used again; what was removed
// answers nullptr. Not thread-safe: its owner guards it.
//
// Keyframes are made in submaps: where tracking is lost for good, the next one begins. Each has a
// world frame of its own until it is found to show a place of another; then both are joined: they
// share one frame, and are named by the older of them, their root. kFirstSubmap is there from the
// beginning.
class Map {
 public:
  Map();
  ~Map();
  Map(Map&&) noexcept;
  Map& operator=(Map&&) noexcept;

  // The same keyframes and landmarks under the same ids, features shared, without the index: a copy
  // to adjust and fuse in while this map goes on. No keyframe is to be removed from it.
  Map Clone() const;
  // The same of these live keyframes, the landmarks that they see, and nothing else.
  Map CloneOf(std::span<const KeyFrameId> keyframes) const;

  // submap: one of the map, also one that is joined.
  KeyFrame& AddKeyFrame(const Frame& frame, const Pose& T_WC, SubmapId submap = kFirstSubmap);
  MapPoint& AddPoint(const Eigen::Vector3d& p_W, std::int64_t frame_index);
  MapLine& AddLine(const Segment3& segment_W, std::int64_t frame_index);

  // nullptr where there is none (any more).
  KeyFrame* keyframe(KeyFrameId id);
  const KeyFrame* keyframe(KeyFrameId id) const;
  MapPoint* point(PointId id);
  const MapPoint* point(PointId id) const;
  MapLine* line(LineId id);
  const MapLine* line(LineId id) const;

  // Live ids, ascending.
  std::vector<KeyFrameId> keyframe_ids() const;
  std::vector<PointId> point_ids() const;
  std::vector<LineId> line_ids() const;
  std::size_t num_keyframes() const { return keyframes_.size(); }
  std::size_t num_points() const { return points_.size(); }
  std::size_t num_lines() const { return lines_.size(); }
  // Of the live keyframes.
  const KeyFrameIndex& index() const { return *index_; }

  // Feature `index` of the keyframe observes the landmark. A keyframe observes a landmark once:
  // where it does already, or where the feature is taken, nothing happens and false is returned.
  bool ObservePoint(KeyFrameId keyframe, int index, PointId point);
  bool ObserveLine(KeyFrameId keyframe, int index, LineId line);
  // A landmark left with no observation is removed.
  void ForgetPointObservation(KeyFrameId keyframe, PointId point);
  void ForgetLineObservation(KeyFrameId keyframe, LineId line);

  void RemovePoint(PointId id);
  void RemoveLine(LineId id);
  // Every observation of `from` goes to `into`, where its keyframe does not observe `into` yet.
  void MergePoints(PointId from, PointId into);
  void MergeLines(LineId from, LineId into);

  // Removes the keyframe and its observations. Frames that hang on it follow `T_parent` instead:
  // see ResolvePose. The keyframe whose motion follows from its motion is tied to the one before
  // instead. parent: a live keyframe.
  void RemoveKeyFrame(KeyFrameId id, KeyFrameId parent);
  // The present pose of a keyframe, also of a removed one (through its parent at that time). Throws
  // InvalidArgument where it never was, or went with its submap.
  Pose ResolvePose(KeyFrameId id) const;
  // The live keyframe that stands in for a removed one, and the pose of that one in it; of a live
  // one itself. Empty where ResolvePose throws.
  std::optional<std::pair<KeyFrameId, Pose>> LiveKeyFrameOf(KeyFrameId id) const;
  // The root of its submap, also of a removed keyframe; empty where ResolvePose throws.
  std::optional<SubmapId> RootOf(KeyFrameId id) const;
  // The live keyframe whose motion is tied to that of `id`; null where there is none.
  KeyFrame* Successor(KeyFrameId id);

  // Begins a submap, with a world frame of its own.
  SubmapId AddSubmap();
  // The submap itself, or the oldest of those that it is joined with. Throws InvalidArgument where
  // there is no such submap, as do all of these.
  SubmapId Root(SubmapId submap) const;
  // Those that are joined with no older one and have keyframes, ascending.
  std::vector<SubmapId> roots() const;
  // Live keyframes of the submaps that are joined with `submap`, ascending, and how many.
  std::vector<KeyFrameId> KeyFramesOf(SubmapId submap) const;
  std::size_t NumKeyFramesOf(SubmapId submap) const;
  // The first keyframe of its world frame: it holds the others in place, and is not to be moved by
  // an adjustment nor removed but with its submap.
  bool IsOrigin(KeyFrameId id) const;
  // From now on they share one world frame; the caller has moved one of them into that of the
  // other (Transform). What was the gravity of the root counts, or where it has none, that of the
  // other.
  void Join(SubmapId a, SubmapId b);
  // With all that is joined with it: keyframes and landmarks.
  void RemoveSubmap(SubmapId submap);

  // Moves everything: p_new = T_new_old p_old.
  void Transform(const Pose& T_new_old);
  // Moves a submap with all that is joined with it.
  void Transform(const Pose& T_new_old, SubmapId submap);
  // [m/s^2] in the world frame of a submap; empty where no IMU told.
  const std::optional<Eigen::Vector3d>& gravity_W(SubmapId submap = kFirstSubmap) const;
  void SetGravity(const std::optional<Eigen::Vector3d>& gravity_W, SubmapId submap = kFirstSubmap);

  // What its points are: only those of one kind are alike. ORB as by default unless told.
  const PointKind& point_kind() const { return point_kind_; }
  // Whether it was told: a map file before version 4 does not say, and may have another pyramid.
  bool knows_point_kind() const { return knows_point_kind_; }
  void SetPointKind(PointKind kind) {
    point_kind_ = std::move(kind);
    knows_point_kind_ = true;
  }

  // Factors of the user's, which follow keyframes and worlds.
  const OwnFactors& factors() const { return factors_; }
  OwnFactors& factors() { return factors_; }
  // poses: hang on keyframes that may have been removed, and then on their parents. False, and
  // nothing is added, where one went with its submap.
  bool AddFactor(MapFactor factor);

  // Descriptor, viewing direction and scale range of a point from its observations.
  void RefreshPoint(PointId id, const PyramidOptions& pyramid);

  // Keyframes that observe the given landmarks, with how many each does; most first, then by id.
  std::vector<std::pair<KeyFrameId, int>> Observers(std::span<const PointId> points,
                                                    std::span<const LineId> lines = {}) const;
  // Keyframes that share at least min_shared landmarks with `id`, most first.
  std::vector<std::pair<KeyFrameId, int>> Covisible(KeyFrameId id, int min_shared) const;

 private:
  struct Removed {
    KeyFrameId parent = kNoId;
    Pose T_parent;
  };
  struct Submap {
    SubmapId root = kFirstSubmap;
    KeyFrameId first = kNoId;                  // that was made in it
    std::size_t keyframes = 0;                 // live
    std::optional<Eigen::Vector3d> gravity_W;  // of a root
  };

  const Submap& submap(SubmapId id) const;
  // The live keyframe that a keyframe hangs on, itself where it lives; nullptr where there is none.
  // T: the transform to it is multiplied from the left.
  const KeyFrame* Resolve(KeyFrameId id, Pose* T) const;
  // Those keyframes that `takes` says, and the landmarks that they are the first to see.
  template <class Takes>
  void Move(const Pose& T_new_old, const Takes& takes);

  IdTable<KeyFrame> keyframes_;
  IdTable<MapPoint> points_;
  IdTable<MapLine> lines_;
  std::unordered_map<KeyFrameId, Removed> removed_;
  std::vector<Submap> submaps_ = std::vector<Submap>(1);
  PointKind point_kind_;
  bool knows_point_kind_ = false;
  OwnFactors factors_;
  std::unique_ptr<KeyFrameIndex> index_;
};

// The landmarks that live keyframes observe, each once, ascending, without those in `except` (in
// any order; kNoId is passed over).
std::vector<PointId> PointsSeenBy(const Map& map, std::span<const KeyFrameId> keyframes,
                                  std::span<const PointId> except);
std::vector<LineId> LinesSeenBy(const Map& map, std::span<const KeyFrameId> keyframes,
                                std::span<const LineId> except);

// Row `index` of a descriptor matrix (N x 32 CV_8U).
BinaryDescriptor256 DescriptorRow(const cv::Mat& descriptors, int index);

// A map and the camera whose images it is of.
struct SavedMap {
  PinholeCamera camera;  // without distortion: features are undistorted
  Map map;
};

// Writes keyframes with their features, points and lines: docs/map_file.md. The file appears whole
// or not at all. camera: as above; its distortion is not kept. Of the factors of the user's those
// of a PositionFactor are kept, where their loss is none or ceres::HuberLoss; returns how many of
// the others there are. Throws IoError.
std::size_t SaveMap(const std::filesystem::path& path, const PinholeCamera& camera, const Map& map);

// What SaveMap wrote; keyframes and landmarks get new ids, without gaps, in the old order. Throws
// IoError for a file that is missing, no map, of another version, cut short or damaged.
SavedMap LoadMap(const std::filesystem::path& path);

}  // namespace highwall
