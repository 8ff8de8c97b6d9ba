#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/pose.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/point_to_plane.h>

#include "features/depth_grid.h"

namespace highwall {

// A reading farther off its plane than this is rejected.
inline constexpr double kSurfaceGateSigmas = 4.0;
inline constexpr double kSurfaceGate = 0.03;  // [m] in addition, for the error of the pose

// A small planar piece of a surface.
struct SurfacePatch {
  Eigen::Vector3d a = Eigen::Vector3d::Zero();  // [m] centroid
  Eigen::Vector3d n = Eigen::Vector3d::Zero();  // unit normal, towards the camera
  double sigma = 0.0;  // [m] standard deviation of the distance of one reading to it
};

// Returns the planar patches of a depth grid (DepthGrid::Sample), in C: least squares over a
// window, without those at depth edges, on non-planar surfaces, at grazing incidence, or with an
// uncertain normal.
std::vector<SurfacePatch> FindPatches(const cv::Mat& depth, const DepthGrid& grid,
                                      const DepthNoise& noise);

// Returns rows for the pose of a camera whose depth grid is `depth`, against patches in W: each
// patch with the reading of the cell that it projects to from the rough pose T_WC (projective
// association), if that lies within the gate [m] and kSurfaceGateSigmas. moving: dynamic mask, may
// be empty. At most 300 rows, spread over the directions of the normals (SpreadOverNormals).
std::vector<PointToPlaneRow> MatchPatches(const std::vector<SurfacePatch>& patches_W,
                                          const cv::Mat& depth, const cv::Mat& moving,
                                          const Pose& T_WC, const DepthGrid& grid,
                                          const DepthNoise& noise, double gate = kSurfaceGate);

// Selects up to max_rows rows with numbers as equal as possible for all directions of normals
// (normal-space sampling: Rusinkiewicz, Levoy, "Efficient variants of the ICP algorithm", 3DIM
// 2001, section 3), and within a direction from all over the image. The order is kept.
std::vector<PointToPlaneRow> SpreadOverNormals(const std::vector<PointToPlaneRow>& rows,
                                               int max_rows);

}  // namespace highwall
