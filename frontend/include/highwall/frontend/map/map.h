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
#include <highwall/frontend/map/user_factors.h>

namespace [[gnu::visibility("default")]] highwall {

class ImuPreintegration;  // highwall/factors/imu_preintegration.h
class KeyFrameIndex;

// 256-bit binary descriptor (of a point: the descriptor of its extractor, as bits; of a line: LBD).
using BinaryDescriptor256 = std::array<std::uint8_t, 32>;

// Feature `index` of keyframe `keyframe` observes the landmark.
struct Observation {
  KeyFrameId keyframe = kNoId;
  int index = 0;
};

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

// The body's motion at a keyframe, and the IMU readings since an earlier one.
struct InertialState {
  Stamp stamp = 0;                                 // [ns] of the IMU's clock
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();  // [m/s]
  ImuBias bias = ImuBias::Zero();                  // [rad/s, m/s^2]
  Eigen::Matrix<double, 6, 1> bias_sigma = Eigen::Matrix<double, 6, 1>::Ones();
  KeyFrameId previous = kNoId;                             // kNoId: no IMU factor to an earlier one
  std::shared_ptr<const ImuPreintegration> from_previous;  // null without `previous`
  double weight = 1.0;  // of its IMU factor: the mean over the images in between
};

// A keyframe with its pose and the landmarks that it observes.
struct KeyFrame {
  KeyFrameId id = kNoId;
  SubmapId submap = kFirstSubmap;  // in which it was created
  Frame frame;
  Pose T_WC;
  cv::Mat depth_grid;  // of its features, but 0 on dynamic objects: reference for other frames
  // match ratio when it was tracked: share of the landmarks in view; 0: unknown
  double found = 0.0;
  std::optional<InertialState> motion;  // with an initialized IMU
  std::vector<PointId> points;          // per point feature, kNoId where unmatched
  std::vector<LineId> lines;            // per line feature
};

// Keyframes, points and lines, owned by id. Ids ascend and are never reused; the lookup of a
// removed one returns nullptr. Not thread-safe: the owner must synchronize access.
//
// Keyframes belong to submaps: a new submap begins when tracking stays lost. Each has a world frame
// of its own until it is recognized to overlap another; then both are merged: they share one frame,
// and are named by the older of them, their root. kFirstSubmap always exists.
class Map {
 public:
  Map();
  ~Map();
  Map(Map&&) noexcept;
  Map& operator=(Map&&) noexcept;

  // Copies keyframes and landmarks under the same ids, sharing the features, without the index: a
  // copy for adjustment and fusion while this map continues to change. No keyframe may be removed
  // from it.
  Map Clone() const;
  // Copies only these active keyframes and the landmarks that they observe.
  Map CloneOf(std::span<const KeyFrameId> keyframes) const;

  // submap: of this map; it may be a merged one.
  KeyFrame& AddKeyFrame(const Frame& frame, const Pose& T_WC, SubmapId submap = kFirstSubmap);
  MapPoint& AddPoint(const Eigen::Vector3d& p_W, std::int64_t frame_index);
  MapLine& AddLine(const Segment3& segment_W, std::int64_t frame_index);

  // Returns nullptr where there is none or it was removed.
  KeyFrame* keyframe(KeyFrameId id);
  const KeyFrame* keyframe(KeyFrameId id) const;
  MapPoint* point(PointId id);
  const MapPoint* point(PointId id) const;
  MapLine* line(LineId id);
  const MapLine* line(LineId id) const;

  // Ids of the active keyframes and of the landmarks, ascending.
  std::vector<KeyFrameId> keyframe_ids() const;
  std::vector<PointId> point_ids() const;
  std::vector<LineId> line_ids() const;
  std::size_t num_keyframes() const { return keyframes_.size(); }
  std::size_t num_points() const { return points_.size(); }
  std::size_t num_lines() const { return lines_.size(); }
  // Place recognition index of the active keyframes.
  const KeyFrameIndex& index() const { return *index_; }

  // Records that feature `index` of the keyframe observes the landmark. A keyframe observes a
  // landmark once: if it does already, or if the feature is assigned, nothing changes and false is
  // returned.
  bool ObservePoint(KeyFrameId keyframe, int index, PointId point);
  bool ObserveLine(KeyFrameId keyframe, int index, LineId line);
  // Removes an observation, and the landmark if no observation remains.
  void ForgetPointObservation(KeyFrameId keyframe, PointId point);
  void ForgetLineObservation(KeyFrameId keyframe, LineId line);

  void RemovePoint(PointId id);
  void RemoveLine(LineId id);
  // Moves every observation of `from` to `into`, unless its keyframe observes `into` already.
  void MergePoints(PointId from, PointId into);
  void MergeLines(LineId from, LineId into);

  // Removes the keyframe and its observations. Frames anchored to it are anchored to `parent`
  // instead: see ResolvePose. The keyframe that follows it in the chain of IMU factors is connected
  // to the one before it instead. parent: an active keyframe.
  void RemoveKeyFrame(KeyFrameId id, KeyFrameId parent);
  // Returns the current pose of a keyframe, also of a removed one (through its parent at that
  // time). Throws InvalidArgument if it never existed or was removed with its submap.
  Pose ResolvePose(KeyFrameId id) const;
  // Returns the active keyframe that replaces a removed one, and the pose of the removed one in it;
  // for an active one, itself. Empty where ResolvePose throws.
  std::optional<std::pair<KeyFrameId, Pose>> ActiveKeyFrameOf(KeyFrameId id) const;
  // Returns the root of its submap, also for a removed keyframe; empty where ResolvePose throws.
  std::optional<SubmapId> RootOf(KeyFrameId id) const;
  // Returns the active keyframe whose IMU factor starts at `id`; null if there is none.
  KeyFrame* Successor(KeyFrameId id);

  // Begins a submap, with a world frame of its own.
  SubmapId AddSubmap();
  // Returns the submap itself, or the oldest of those merged with it. Throws InvalidArgument if
  // there is no such submap, as do all of the following.
  SubmapId Root(SubmapId submap) const;
  // Submaps that are merged into no older one and have keyframes, ascending.
  std::vector<SubmapId> roots() const;
  // Active keyframes of the submaps merged with `submap`, ascending, and their number.
  std::vector<KeyFrameId> KeyFramesOf(SubmapId submap) const;
  std::size_t NumKeyFramesOf(SubmapId submap) const;
  // Returns whether this is the first keyframe of its world frame: it fixes the gauge, must not be
  // moved by an adjustment, and is removed only with its submap.
  bool IsOrigin(KeyFrameId id) const;
  // Merges two submaps into one world frame; the caller has transformed one of them into that of
  // the other (Transform). The gravity of the root is kept, or, if it has none, that of the other.
  void Join(SubmapId a, SubmapId b);
  // Removes the submap and all merged with it: keyframes and landmarks.
  void RemoveSubmap(SubmapId submap);

  // Transforms everything: p_new = T_new_old p_old.
  void Transform(const Pose& T_new_old);
  // Transforms a submap and all merged with it.
  void Transform(const Pose& T_new_old, SubmapId submap);
  // [m/s^2] in the world frame of a submap; empty as long as no IMU has estimated it.
  const std::optional<Eigen::Vector3d>& gravity_W(SubmapId submap = kFirstSubmap) const;
  void SetGravity(const std::optional<Eigen::Vector3d>& gravity_W, SubmapId submap = kFirstSubmap);

  // Feature type of its points; only points of one type are comparable. ORB unless it was set.
  const FeatureType& feature_type() const { return feature_type_; }
  // Whether it was set: map files before version 4 do not store it, and may have another pyramid.
  bool knows_feature_type() const { return knows_feature_type_; }
  void SetFeatureType(FeatureType kind) {
    feature_type_ = std::move(kind);
    knows_feature_type_ = true;
  }

  // User factors, which are anchored to keyframes and worlds.
  const UserFactors& factors() const { return factors_; }
  UserFactors& factors() { return factors_; }
  // poses: anchored to keyframes that may have been removed, then to their parents. Returns false
  // and adds nothing if one was removed with its submap.
  bool AddFactor(MapFactor factor);

  // Updates descriptor, viewing direction and scale range of a point from its observations.
  void RefreshPoint(PointId id, const PyramidOptions& pyramid);

  // Keyframes that observe the given landmarks, with the number of them; most first, then by id.
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
    KeyFrameId first = kNoId;                  // created in it
    std::size_t keyframes = 0;                 // active
    std::optional<Eigen::Vector3d> gravity_W;  // of a root
  };

  const Submap& submap(SubmapId id) const;
  // Returns the active keyframe that a keyframe is anchored to, itself if it is active; nullptr if
  // there is none. T: is multiplied from the left by the transform to it.
  const KeyFrame* Resolve(KeyFrameId id, Pose* T) const;
  // Transforms the keyframes for which `takes` is true, and the landmarks that they observe first.
  template <class Takes>
  void Move(const Pose& T_new_old, const Takes& takes);

  IdTable<KeyFrame> keyframes_;
  IdTable<MapPoint> points_;
  IdTable<MapLine> lines_;
  std::unordered_map<KeyFrameId, Removed> removed_;
  std::vector<Submap> submaps_ = std::vector<Submap>(1);
  FeatureType feature_type_;
  bool knows_feature_type_ = false;
  UserFactors factors_;
  std::unique_ptr<KeyFrameIndex> index_;
};

// Landmarks that active keyframes observe, each once, ascending, without those in `except` (in any
// order; kNoId is skipped).
std::vector<PointId> PointsSeenBy(const Map& map, std::span<const KeyFrameId> keyframes,
                                  std::span<const PointId> except);
std::vector<LineId> LinesSeenBy(const Map& map, std::span<const KeyFrameId> keyframes,
                                std::span<const LineId> except);

// Row `index` of a descriptor matrix (N x 32 CV_8U).
BinaryDescriptor256 DescriptorRow(const cv::Mat& descriptors, int index);

// A map and the camera of its images.
struct SavedMap {
  PinholeCamera camera;  // without distortion: features are undistorted
  Map map;
};

// Writes keyframes with their features, points and lines: docs/map_file.md. The file is written
// completely or not at all. camera: as above; its distortion is not stored. Of the user factors
// those with a PositionFactor are stored if their loss is none or ceres::HuberLoss; returns the
// number of the others. Throws IoError.
std::size_t SaveMap(const std::filesystem::path& path, const PinholeCamera& camera, const Map& map);

// Reads a file written by SaveMap; keyframes and landmarks get new ids, without gaps, in the old
// order. Throws IoError for a file that is missing, no map, of another version, truncated or
// damaged.
SavedMap LoadMap(const std::filesystem::path& path);

}  // namespace highwall
