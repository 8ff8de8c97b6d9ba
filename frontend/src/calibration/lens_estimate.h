#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>

namespace highwall {

// What a lens is estimated from: points and the images that see them.
struct LensViews {
  // A feature in image `image`, an index of T_CW, as rows of MeasurementModel.
  struct View {
    std::size_t image = 0;
    ProjectionRows<3> rows;
  };
  struct SeenPoint {
    Eigen::Vector3d p_W;
    std::vector<View> views;  // two or more, one of them with depth
  };

  std::vector<Pose> T_CW;         // of the images, estimated as well
  std::vector<std::size_t> held;  // images whose poses are fixed: one of each world
  std::vector<SeenPoint> points;
};

// Focal lengths, principal point and radial distortion as images tell them.
struct LensEstimate {
  Eigen::Vector4d intrinsics = Eigen::Vector4d::Zero();  // fx fy cx cy [px]
  // [px] Standard deviations by the scatter between groups of keyframes: they hold whatever the
  // noise of the observations is, and also where the map was made with a wrong lens.
  Eigen::Vector4d sigma = Eigen::Vector4d::Zero();
  // By how much the squared residuals would grow, relative to their sum, if one of these values
  // were that of the model and all others were adjusted. It hardly depends on how many views there
  // are.
  Eigen::Vector4d growth = Eigen::Vector4d::Zero();
  // Radial distortion of the undistorted pixels, x (1 + k1 (x^2 + y^2)): zero if the stated one is
  // right, otherwise about what is to be added to the stated k1. sigma, growth: as above.
  struct Distortion {
    double k1 = 0.0, sigma = 0.0, growth = 0.0;
  } distortion{};
  int keyframes = 0, points = 0;
};

// Solves for the lens together with poses, points and the offset of inverse depth, from the lens of
// the model on. The scatter is that of eight groups of successive images. Empty with less than a
// hundred points, and if the equations have no solution.
std::optional<LensEstimate> EstimateLens(LensViews views, const MeasurementModel& model);

// Does so for these keyframes, active and ascending, and the points that two or more of them see.
// The map is not changed. Takes a few milliseconds per keyframe. Empty with less than twelve
// keyframes too (docs/misconfiguration.md, Lens).
std::optional<LensEstimate> EstimateLens(const Map& map, const MeasurementModel& model,
                                         std::span<const KeyFrameId> keyframes);

}  // namespace highwall
