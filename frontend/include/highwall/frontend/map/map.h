#pragma once

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
#include <highwall/core/pose.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/map/keyframe.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/map/landmark_table.h>
#include <highwall/frontend/map/map_ids.h>
#include <highwall/frontend/map/user_factors.h>

namespace [[gnu::visibility("default")]] highwall {

class KeyFrameIndex;

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
  // Adds a landmark that no keyframe observes yet: Add<MapPoint>(p_W, frame_index),
  // Add<MapLine>(segment_W, frame_index).
  template <LandmarkKind Landmark>
  Landmark& Add(const typename LandmarkTraits<Landmark>::Geometry& geometry,
                std::int64_t frame_index) {
    return table<Landmark>().Add(geometry, frame_index);
  }

  // Returns nullptr where there is none or it was removed.
  KeyFrame* keyframe(KeyFrameId id);
  const KeyFrame* keyframe(KeyFrameId id) const;
  // The same for a landmark: a MapPoint for a PointId, a MapLine for a LineId.
  template <LandmarkKind Landmark>
  Landmark* Find(Id<Landmark> id) {
    return table<Landmark>().Find(id);
  }
  template <LandmarkKind Landmark>
  const Landmark* Find(Id<Landmark> id) const {
    return table<Landmark>().Find(id);
  }

  // Ids of the active keyframes and of the landmarks of one kind, such as ids<MapPoint>(),
  // ascending, and their number.
  std::vector<KeyFrameId> keyframe_ids() const { return keyframes_.ids(); }
  std::size_t num_keyframes() const { return keyframes_.size(); }
  template <LandmarkKind Landmark>
  std::vector<Id<Landmark>> ids() const {
    return table<Landmark>().ids();
  }
  template <LandmarkKind Landmark>
  std::size_t num() const {
    return table<Landmark>().size();
  }
  // Place recognition index of the active keyframes.
  const KeyFrameIndex& index() const { return *index_; }

  // Records that feature `index` of the keyframe observes the landmark. A keyframe observes a
  // landmark once: if it does already, or if the feature is assigned, nothing changes and false is
  // returned.
  template <LandmarkKind Landmark>
  bool Observe(KeyFrameId keyframe_id, int index, Id<Landmark> id) {
    KeyFrame* const observer = keyframe(keyframe_id);
    return observer != nullptr && table<Landmark>().Observe(observer, index, id);
  }
  // Removes an observation, and the landmark if no observation remains.
  template <LandmarkKind Landmark>
  void Forget(KeyFrameId keyframe_id, Id<Landmark> id) {
    KeyFrame* const observer = keyframe(keyframe_id);
    if (observer != nullptr) table<Landmark>().Forget(observer, id);
  }
  // Removes a landmark.
  template <LandmarkKind Landmark>
  void Remove(Id<Landmark> id) {
    table<Landmark>().Remove(id, &keyframes_);
  }
  // Moves every observation of `from` to `into`, unless its keyframe observes `into` already.
  template <LandmarkKind Landmark>
  void Merge(Id<Landmark> from, Id<Landmark> into) {
    table<Landmark>().Merge(from, into, &keyframes_);
  }

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
  // and adds nothing if one was removed with its submap. A motion within one keyframe is dropped
  // (UserFactors::Add).
  bool AddFactor(MapFactor factor);

  // Updates descriptor, viewing direction and scale range of a point from its observations.
  void RefreshPoint(PointId id, const PyramidOptions& pyramid);

  // Landmarks of one kind that active keyframes observe, such as SeenBy<MapPoint>(keyframes), each
  // once, ascending, without those in `except` (in any order; kNoId is skipped).
  template <LandmarkKind Landmark>
  std::vector<Id<Landmark>> SeenBy(std::span<const KeyFrameId> keyframes,
                                   std::span<const Id<Landmark>> except = {}) const {
    return LandmarkTable<Landmark>::SeenBy(keyframes_, keyframes, except);
  }
  // Keyframes that observe the given landmarks, with the number of them; most first, then by id.
  // landmarks: a structure with ids of each kind, such as a KeyFrame or PerKind<LandmarkIds>.
  template <class Holder>
  std::vector<std::pair<KeyFrameId, int>> Observers(const Holder& landmarks) const {
    std::vector<int> count(keyframes_.end_id().index());
    ForEachKind([&]<class Landmark>() {
      for (const Id<Landmark> id : PartOf<Landmark>(landmarks)) {
        const Landmark* const landmark = Find(id);
        if (landmark == nullptr) continue;
        for (const Observation& o : landmark->observations) ++count[o.keyframe.index()];
      }
    });
    return MostFirst(count);
  }
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

  template <class Landmark>
  LandmarkTable<Landmark>& table() {
    return PartOf<Landmark>(landmarks_);
  }
  template <class Landmark>
  const LandmarkTable<Landmark>& table() const {
    return PartOf<Landmark>(landmarks_);
  }
  static std::vector<std::pair<KeyFrameId, int>> MostFirst(const std::vector<int>& count);
  const Submap& submap(SubmapId id) const;
  // Returns the active keyframe that a keyframe is anchored to, itself if it is active; nullptr if
  // there is none. T: is multiplied from the left by the transform to it.
  const KeyFrame* Resolve(KeyFrameId id, Pose* T) const;
  // Transforms the keyframes for which `takes` is true, and the landmarks that they observe first.
  template <class Takes>
  void Move(const Pose& T_new_old, const Takes& takes);

  IdTable<KeyFrame> keyframes_;
  PerKind<LandmarkTable> landmarks_;
  std::unordered_map<KeyFrameId, Removed> removed_;
  std::vector<Submap> submaps_ = std::vector<Submap>(1);
  FeatureType feature_type_;
  bool knows_feature_type_ = false;
  UserFactors factors_;
  std::unique_ptr<KeyFrameIndex> index_;
};

// Row `index` of a descriptor matrix (N x 32 CV_8U).
BinaryDescriptor256 DescriptorRow(const cv::Mat& descriptors, int index);

// A map and the camera of its images.
struct SavedMap {
  PinholeCamera camera;  // without distortion: features are undistorted
  Map map;
};

// Writes keyframes with their features, points and lines: docs/map_file.md. The file is written
// completely or not at all. camera: as above; its distortion is not stored. Of the user factors
// those with a PositionFactor or a RelativePose are stored if their loss is none or
// ceres::HuberLoss, without their source; returns the number of the others. Throws IoError.
std::size_t SaveMap(const std::filesystem::path& path, const PinholeCamera& camera, const Map& map);

// Reads a file written by SaveMap; keyframes and landmarks get new ids, without gaps, in the old
// order. Throws IoError for a file that is missing, no map, of another version, truncated or
// damaged.
SavedMap LoadMap(const std::filesystem::path& path);

}  // namespace highwall
