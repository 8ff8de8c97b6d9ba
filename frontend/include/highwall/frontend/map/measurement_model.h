#pragma once

#include <array>
#include <cstddef>
#include <memory>

#include <ceres/cost_function.h>

#include <highwall/core/camera.h>
#include <highwall/factors/depth_noise.h>
#include <highwall/factors/line_reprojection.h>
#include <highwall/factors/point_reprojection.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/map/options.h>

namespace [[gnu::visibility("default")]] highwall {

// Measurement model of the features of one RGB-D camera: which of them may match, and how they are
// weighted. It is shared by tracking, mapping, loops and relocalization, where observations become
// residual rows. Rows are of T_WC; the factors are of T_WB, whose frame B is the camera's if there
// is no IMU.
class MeasurementModel {
 public:
  // pyramid: of the corners. Throws InvalidArgument for bad options.
  MeasurementModel(const RgbdSensor& sensor, const MeasurementOptions& options,
                   const Pose& T_BC = Pose(), const PyramidOptions& pyramid = {},
                   const MatchingOptions& matching = {});

  // Without distortion.
  const PinholeCamera& camera() const { return camera_; }
  // Whether an undistorted pixel lies in the image, as the lens bends it.
  bool Sees(const Eigen::Vector2d& uv) const;
  // By how much the lens is undone at an undistorted pixel: the size there, in undistorted pixels,
  // of a pixel of the image (geometric mean over both directions).
  double Stretch(const Eigen::Vector2d& uv) const;
  const DepthNoise& depth_noise() const { return noise_; }
  const RgbdProjection& projection() const { return projection_; }
  const Pose& T_BC() const { return T_BC_; }
  // Applies to factors created afterwards.
  void SetExtrinsics(const Pose& T_BC);
  const MeasurementOptions& options() const { return options_; }
  // With the mad_rule of options().
  const MatchingOptions& matching() const { return matching_; }
  const PyramidOptions& pyramid() const { return pyramid_; }
  // Size of a pixel of a level in pixels of the finest. octave: in [0, 16), the maximum number of
  // levels.
  double Scale(int octave) const { return scales_[static_cast<std::size_t>(octave)]; }

  // Prior [px] of u and v at the pyramid level.
  double PointSigma(int octave) const;
  // [px] of u and v of this feature, undistorted.
  double PointSigma(const PointFeature& feature) const {
    return PointSigma(feature.octave) * static_cast<double>(feature.noise.px) * Stretch(feature.uv);
  }
  // [px] of an end of this segment, across it.
  double LineSigma(const LineFeature& feature) const;
  // [px] of the virtual disparity at depth z [m] with standard deviation sigma_z [m].
  double DisparitySigma(double z, double sigma_z) const {
    return right_.fx * right_.baseline / (z * z) * sigma_z;
  }

  // Rows of a point; the third is zero where it has no depth (Dimension 2 instead of 3).
  ProjectionRows<3> Rows(const PointFeature& feature) const;
  static int Dimension(const PointFeature& feature) { return feature.depth > 0.0 ? 3 : 2; }
  // |r|^2 of a point's rows, p_W [m] seen from T_WC; infinite where it is nearer than min_depth.
  double Chi2(const PointFeature& feature, const Pose& T_WC, const Eigen::Vector3d& p_W) const;
  // Rows of a line's two ends in the end-point form; the second row of each is zero without depth,
  // and, with paper weighting, for a segment that the virtual right camera sees end-on.
  std::array<ProjectionRows<2>, 2> Rows(const LineFeature& feature) const;
  static int Dimension(const LineFeature& feature) { return feature.segment_C ? 4 : 2; }

  // Blocks: T_WB, p_W.
  std::shared_ptr<ceres::CostFunction> MakeFactor(const PointFeature& feature) const;
  // Blocks: T_WB, OrthonormalLine.
  std::shared_ptr<ceres::CostFunction> MakeFactor(const LineFeature& feature) const;
  // The same for this camera at T_BC on another body, such as a keyframe on the map.
  std::shared_ptr<ceres::CostFunction> MakeFactor(const PointFeature& feature,
                                                  const Pose& T_BC) const;
  std::shared_ptr<ceres::CostFunction> MakeFactor(const LineFeature& feature,
                                                  const Pose& T_BC) const;

 private:
  Eigen::Matrix3d SqrtInformation(const PointFeature& feature) const;  // for a feature with depth
  Eigen::Vector3d Measurement(const PointFeature& feature) const;
  RgbdSegment Measurement(const LineFeature& feature) const;
  SegmentNoise Noise(const LineFeature& feature) const;
  RgbdProjection ProjectionAt(const Pose& T_BC) const;
  std::shared_ptr<ceres::CostFunction> MakeFactor(const PointFeature& feature,
                                                  const RgbdProjection& projection) const;
  std::shared_ptr<ceres::CostFunction> MakeFactor(const LineFeature& feature,
                                                  const RgbdProjection& projection) const;

  MeasurementOptions options_;
  MatchingOptions matching_;
  PyramidOptions pyramid_;
  std::array<double, 16> scales_;  // by octave
  PinholeCamera lens_;             // with its distortion
  PinholeCamera camera_;           // without
  double reach_ = 0.0;  // squared distance from the axis at z = 1 of the image's farthest corner
  VirtualRightCamera right_;
  DepthNoise noise_;
  Pose T_BC_;
  RgbdProjection projection_, body_projection_;  // with T_WC, with T_WB
};

}  // namespace highwall
