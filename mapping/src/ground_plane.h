#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

namespace highwall {

// Plane of the points p_W with up_W . p_W = height.
struct GroundPlane {
  Eigen::Vector3d up_W = Eigen::Vector3d::UnitZ();  // unit
  double height = 0.0;                              // [m]
};

struct GroundPlaneOptions {
  double max_tilt = 30.0;   // [deg] (0, 90) between the plane's normal and the expected one
  double thickness = 0.05;  // [m] > 0; maximum distance of a point that belongs to the plane
  double min_share = 0.05;  // (0, 1] of the points that must belong to the plane
  int trials = 300;         // >= 1; number of planes through three random points

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Estimates the ground plane where no IMU gives the up direction. Candidates are the planes that
// are level within max_tilt of `expected_up_W` (not zero) and lie below `viewpoint_W`, the point
// from which they were observed (a wall in front of a camera that looks down does not). Returns the
// one with the most points, by RANSAC (Fischler and Bolles 1981) and a least-squares fit to its
// points. The same points give the same plane. Empty if there is none. Throws InvalidArgument for
// bad options, vectors that are not finite, or a zero direction.
std::optional<GroundPlane> FitGroundPlane(std::span<const Eigen::Vector3f> points_W,
                                          const Eigen::Vector3d& expected_up_W,
                                          const Eigen::Vector3d& viewpoint_W,
                                          const GroundPlaneOptions& options = {});

}  // namespace highwall
