#pragma once

#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/mapping/depth_camera.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

// Of MakeKeyframeCloud().
struct KeyframeCloudOptions {
  double min_depth = 0.05;         // [m] > 0; nearer measurements are dropped
  double max_depth = kDenseRange;  // [m] > min_depth
  int stride = 1;                  // [px] >= 1; every stride-th pixel of every stride-th row
  double edge_rejection = 0.05;    // >= 0; a pixel whose depth differs by more than this fraction
                                   // from one of its four neighbours is dropped (the sensor mixes
                                   // both sides of a depth edge); 0 keeps all
  double max_incidence = 80.0;     // [deg] (0, 90]; a surface seen under a larger angle between its
                                   // normal and the ray is dropped, and one too small or too steep
                                   // for a normal; 90 keeps all
  int normal_radius = 4;           // [px] >= 1; normals are taken from pixels that far to each side
  double voxel_size = 0.01;        // [m] > 0; one point a voxel

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The points of one depth image in its camera frame C (docs/equations.md, section 6), with colours
// and normals, voxel-filtered. depth: CV_32FC1 [m], of the size of the camera, 0 or NaN where
// nothing was measured; may be empty (no points). bgr: CV_8UC3 of the same size, or empty. Throws
// InvalidArgument otherwise.
std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const DepthUnprojector& unprojector,
                                            const KeyframeCloudOptions& options = {});
// The same for a single image; builds the ray table of the camera first.
std::vector<ColoredPoint> MakeKeyframeCloud(const cv::Mat& depth, const cv::Mat& bgr,
                                            const PinholeCamera& camera,
                                            const KeyframeCloudOptions& options = {});

// A depth image and where it was taken.
struct DepthView {
  cv::Mat depth;  // CV_32FC1 [m]
  Pose T_WC;
};

// Of KeepAgreedDepth().
struct DepthAgreementOptions {
  double absolute = 0.02;      // [m] >= 0; two depths z1, z2 agree if they differ by at most
  double relative = 0.02;      // >= 0; absolute + relative z
  bool needs_support = false;  // drop also what no neighbour confirms
  void Validate() const;       // throws InvalidArgument naming the field
};

// The depth image without the pixels that the neighbouring views speak against: more of them look
// through the point, at something farther away, than agree with it. A neighbour that sees something
// nearer (it is in the way) or nothing has no vote. All images of the camera's size; distortion is
// taken into account. Throws InvalidArgument for other images.
cv::Mat KeepAgreedDepth(const DepthView& view, std::span<const DepthView> neighbours,
                        const PinholeCamera& camera, const DepthUnprojector& unprojector,
                        const DepthAgreementOptions& options = {});

// One point per occupied voxel of a grid through the origin: the mean position, colour and normal
// of the points inside, in the order in which the voxels first occur. Points that are not finite,
// or further than 2^20 voxels from the origin along an axis, are dropped.
// voxel_size: [m] > 0, else InvalidArgument.
std::vector<ColoredPoint> FilterVoxels(std::span<const ColoredPoint> points, double voxel_size);

// Drops the points whose mean distance to their `neighbours` nearest ones exceeds the mean of these
// distances over all points by more than `sigmas` standard deviations (Rusu et al., "Towards 3D
// Point Cloud Based Object Maps for Household Environments", RAS 2008). Order is kept; points that
// are not finite are dropped. Throws InvalidArgument unless neighbours >= 1 and sigmas >= 0.
std::vector<ColoredPoint> RemoveOutliers(std::span<const ColoredPoint> points, int neighbours = 8,
                                         double sigmas = 2.0);

}  // namespace highwall
