#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

// Options of MakeKeyframeCloud().
struct KeyframeCloudOptions {
  double min_depth = 0.05;         // [m] > 0; nearer measurements are dropped
  double max_depth = kDenseRange;  // [m] > min_depth
  int stride = 1;                  // [px] >= 1; every stride-th pixel of every stride-th row
  double edge_rejection = 0.05;    // >= 0; a pixel whose depth differs by more than this fraction
                                   // from one of its four neighbours is dropped (the sensor mixes
                                   // both sides of a depth edge); 0 keeps all
  double max_incidence = 80.0;     // [deg] (0, 90]; a point with a larger angle between its normal
                                   // and the ray is dropped, as is one whose surface is too small
                                   // or too steep for a normal; 90 keeps all
  int normal_radius = 4;           // [px] >= 1; distance of the pixels used for a normal
  double voxel_size = 0.01;        // [m] > 0; one point per voxel

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Computes the points of one depth image in its camera frame C (docs/equations.md, section 6), with
// colours and normals, voxel-filtered. depth: CV_32FC1 [m], of the size of the camera, 0 or NaN
// where not measured; may be empty (no points). bgr: CV_8UC3 of the same size, or empty. Throws
// InvalidArgument otherwise.
std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const DepthUnprojector& unprojector,
                                            const KeyframeCloudOptions& options = {});
// Overload for a single image; builds the ray table of the camera first.
std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const PinholeCamera& camera,
                                            const KeyframeCloudOptions& options = {});

// Depth image with its pose.
struct DepthView {
  cv::Mat depth;  // CV_32FC1 [m]
  Pose T_WC;
};

// Options of KeepAgreedDepth().
struct DepthAgreementOptions {
  double absolute = 0.02;      // [m] >= 0; depths z1 and z2 agree if they differ by at most
  double relative = 0.02;      // >= 0; absolute + relative z
  bool needs_support = false;  // drop also pixels that no neighbour confirms
  void Validate() const;       // throws InvalidArgument naming the field
};

// Returns the depth image without the pixels that are inconsistent with the neighbouring views:
// more views observe a farther surface behind the point than agree with it. A view in which the
// point is occluded or has no depth has no vote. All images have the size of the camera; distortion
// is taken into account. Throws InvalidArgument for other images.
cv::Mat KeepAgreedDepth(const DepthView& view, std::span<const DepthView> neighbours,
                        const PinholeCamera& camera, const DepthUnprojector& unprojector,
                        const DepthAgreementOptions& options = {});

// Returns one point per occupied voxel of a grid through the origin: the mean position, colour and
// normal of the points inside, in the order in which the voxels first occur. Points that are not
// finite, or farther than 2^20 voxels from the origin along an axis, are dropped. Throws
// InvalidArgument unless voxel_size [m] is positive.
std::vector<ColoredPoint> FilterVoxels(std::span<const ColoredPoint> points, double voxel_size);

// Drops the points whose mean distance to their `neighbours` nearest neighbours exceeds the mean of
// these distances over all points by more than `sigmas` standard deviations (Rusu et al., "Towards
// 3D Point Cloud Based Object Maps for Household Environments", RAS 2008). The order is kept;
// points that are not finite are dropped. Throws InvalidArgument unless neighbours >= 1 and sigmas
// >= 0.
std::vector<ColoredPoint> RemoveOutliers(std::span<const ColoredPoint> points, int neighbours = 8,
                                         double sigmas = 2.0);

}  // namespace highwall
