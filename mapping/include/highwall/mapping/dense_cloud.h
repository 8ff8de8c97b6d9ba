#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/mapping/depth_unprojector.h>

namespace highwall {

struct ColoredPoint {
  Eigen::Vector3f p = Eigen::Vector3f::Zero();     // [m]
  std::array<std::uint8_t, 3> rgb{255, 255, 255};  // white where there is no colour image
};

struct DenseCloudOptions {
  double min_depth = 0.3;        // [m] > 0; nearer measurements are dropped
  double max_depth = 3.0;        // [m] > min_depth; D435i 3, Kinect (TUM RGB-D) 4
  int stride = 1;                // [px] >= 1; every stride-th pixel of every stride-th row
  double edge_rejection = 0.05;  // >= 0; a pixel whose depth differs by more than this fraction
                                 // from one of its four neighbours is dropped (the sensor mixes
                                 // both sides of a depth edge); 0 keeps all
  double voxel_size = 0.01;      // [m] > 0; one point a voxel

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The points of one depth image in its camera frame C (METHOD.md, section 6), voxel-filtered.
// depth: CV_32FC1 [m], of the size of the camera, 0 or NaN where nothing was measured; may be empty
// (no points). bgr: CV_8UC3 of the same size, or empty. Throws InvalidArgument otherwise.
std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const DepthUnprojector& unprojector,
                                            const DenseCloudOptions& options = {});
// The same for a single image; builds the ray table of the camera first.
std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const PinholeCamera& camera,
                                            const DenseCloudOptions& options = {});

// One point per occupied voxel of a grid through the origin: the mean position and colour of the
// points inside, in the order in which the voxels first occur. Points that are not finite, or
// further than 2^20 voxels from the origin along an axis, are dropped.
// voxel_size: [m] > 0, else InvalidArgument.
std::vector<ColoredPoint> FilterVoxels(std::span<const ColoredPoint> points, double voxel_size);

// The dense map: a cloud per keyframe in its own camera frame, and the poses to put them together.
// Keyframes that move (loop closure, bundle adjustment) take their points with them; nothing is
// baked in before Merged().
class DenseCloud {
 public:
  // voxel_size: [m] > 0, of the merged cloud. Throws InvalidArgument otherwise.
  explicit DenseCloud(double voxel_size = DenseCloudOptions{}.voxel_size);

  // Adds keyframe `id`, or replaces its cloud and keeps its pose.
  void SetKeyframe(std::int64_t id, std::vector<ColoredPoint> cloud_C);
  // Throws InvalidArgument if `id` has no cloud or T_WC is not finite.
  void SetPose(std::int64_t id, const Pose& T_WC);
  // Does nothing where there is no such keyframe.
  void RemoveKeyframe(std::int64_t id);

  bool Contains(std::int64_t id) const { return keyframes_.contains(id); }
  // In its camera frame. Throws InvalidArgument if `id` has no cloud.
  const std::vector<ColoredPoint>& Cloud(std::int64_t id) const;
  std::size_t KeyframeCount() const { return keyframes_.size(); }
  // Points of all keyframes before merging.
  std::size_t PointCount() const;

  // The union of the clouds of all keyframes that have a pose, in W, voxel-filtered. A function of
  // the content alone: keyframes are taken in the order of their ids.
  std::vector<ColoredPoint> Merged() const;

 private:
  struct Keyframe {
    std::vector<ColoredPoint> cloud_C;
    std::optional<Pose> T_WC;
  };

  double voxel_size_;
  std::map<std::int64_t, Keyframe> keyframes_;
};

}  // namespace highwall
