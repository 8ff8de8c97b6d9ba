#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

namespace highwall {

// Points p_W with up_W . p_W = height.
struct GroundPlane {
  Eigen::Vector3d up_W = Eigen::Vector3d::UnitZ();  // unit
  double height = 0.0;                              // [m]
};

struct GroundPlaneOptions {
  double max_tilt = 30.0;   // [deg] (0, 90) between the plane's normal and the direction expected
  double thickness = 0.05;  // [m] > 0; a point at most that far off belongs to the plane
  double min_share = 0.05;  // (0, 1] of the points that must belong to it
  int trials = 300;         // >= 1 planes through three random points

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// The ground where no IMU tells what is up: among the planes that are level within max_tilt of
// `expected_up_W` (not zero) and lie below `viewpoint_W`, from where they were seen (a wall ahead
// of a camera that looks down does not), the one with the most points, by RANSAC (Fischler and
// Bolles 1981) and a least-squares fit to its points. The same points give the same plane. Empty
// where there is none. Throws InvalidArgument for bad options or vectors that are not finite or no
// direction.
std::optional<GroundPlane> FitGroundPlane(std::span<const Eigen::Vector3f> points_W,
                                          const Eigen::Vector3d& expected_up_W,
                                          const Eigen::Vector3d& viewpoint_W,
                                          const GroundPlaneOptions& options = {});

}  // namespace highwall
