#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/point_to_plane.h>
#include <highwall/frontend/features/depth_grid.h>

namespace highwall {

struct SurfaceMatcherOptions {
  int stride = 2;              // [cells] >= 1, between the middles of patches
  int radius = 4;              // [cells] >= 1: a patch has 2 radius + 1 cells to a side
  double link = 0.1;           // > 0: a patch ends where depth departs by this share of itself
  double min_share = 0.7;      // (0, 1]: cells of a patch that must be of its surface
  double planar_sigmas = 2.0;  // > 0: most depart from the plane by no more than depth noise, or by
  double roughness = 0.01;     // [m] >= 0, whichever is more
  double max_incidence = 1.3;  // [rad] (0, pi/2): between the ray and the normal
  // [rad] > 0: standard deviation of a normal. Normals that are less certain hold a pose in
  // directions of which the surface says nothing.
  double max_tilt = 0.05;
  double gate_sigmas = 4.0;  // > 0: a point farther off the plane is of something else, plus
  double gate = 0.03;        // [m] >= 0, the error of the pose
  int max_rows = 300;        // >= 1

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// A small piece of a surface that is flat.
struct SurfacePatch {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();  // [m] its middle
  Eigen::Vector3d n = Eigen::Vector3d::Zero();  // unit normal, towards the camera
  double sigma = 0.0;  // [m] standard deviation of the distance of one reading to it
};

// The flat patches of a depth grid (DepthGrid::Sample), in C: least squares over a window, without
// those at depth edges, on what is not flat, seen too much from the side, or with an uncertain
// normal.
std::vector<SurfacePatch> FindPatches(const cv::Mat& depth, const DepthGrid& grid,
                                      const DepthNoise& noise,
                                      const SurfaceMatcherOptions& options);

// Rows for the pose of a camera whose depth grid is `depth`, against patches in W: each patch and
// the reading of the cell that sees it from the rough pose T_WC (projective association), where
// that lies within the gate. moving: cells to leave out, may be empty. No more than max_rows of
// them, spread over the directions of the normals (SpreadOverNormals).
std::vector<PointToPlaneRow> MatchPatches(const std::vector<SurfacePatch>& patches_W,
                                          const cv::Mat& depth, const cv::Mat& moving,
                                          const Pose& T_WC, const DepthGrid& grid,
                                          const DepthNoise& noise,
                                          const SurfaceMatcherOptions& options);

// As many as max_rows, from each direction of normals as equal a number as there are
// (normal-space sampling: Rusinkiewicz, Levoy, "Efficient variants of the ICP algorithm", 3DIM
// 2001, section 3), and within a direction from all over the image. The order stays.
std::vector<PointToPlaneRow> SpreadOverNormals(const std::vector<PointToPlaneRow>& rows,
                                               int max_rows);

}  // namespace highwall
