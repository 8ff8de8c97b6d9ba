#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/factors/imu_preintegration.h>
#include <highwall/frontend/map/map.h>

namespace [[gnu::visibility("default")]] highwall {

// The pose of a camera anchored to a keyframe, which it follows when the map is adjusted.
struct AnchoredPose {
  KeyFrameId reference = kNoId;
  Pose T_reference_C;

  // Anchors the current pose T_WC. reference: a keyframe of the map, also one that was removed.
  static AnchoredPose At(const Map& map, KeyFrameId reference, const Pose& T_WC) {
    return {reference, map.ResolvePose(reference).Inverse() * T_WC};
  }
  Pose T_WC(const Map& map) const { return map.ResolvePose(reference) * T_reference_C; }
};

// What an image states about the pose of its camera: the information in [1/m^2, 1/rad^2] of a
// translation and a rotation, both in C, so that it holds however the map moves.
using ImageInformation = Eigen::Matrix<float, 6, 6>;

// Converts information in the tangent space of PoseManifold, whose translations are in A, to
// translations in B.
inline Eigen::Matrix<double, 6, 6> RotatedInformation(Eigen::Matrix<double, 6, 6> information,
                                                      const Eigen::Matrix3d& R_BA) {
  information.topRows<3>() = (R_BA * information.topRows<3>()).eval();
  information.leftCols<3>() = (information.leftCols<3>() * R_BA.transpose()).eval();
  return information;
}

// The same for that of a pose T_WC, to translations in C.
inline ImageInformation InformationInCamera(const Eigen::Matrix<double, 6, 6>& information,
                                            const Pose& T_WC) {
  return RotatedInformation(information, T_WC.R().transpose()).cast<float>();
}

// Readings of an IMU from a frame to the next one with a pose.
struct ReadingsBetween {
  Stamp before = 0;                // of the frame at their start
  std::vector<ImuSample> samples;  // from there to the frame at their end, in the IMU's clock
  ImuNoise noise{};                // of these readings
  double weight = 1.0;             // > 0, of their factor
  bool contradicted = false;       // by the image at their end, as it was tracked
  ImuBias bias = ImuBias::Zero(), bias_sigma = ImuBias::Ones();  // at their end
};

// A frame with a pose.
struct PosedFrame {
  Stamp stamp = 0;
  AnchoredPose pose;
  // Of `by_image` where there is one, else of `pose`. Zero where the image states nothing; empty at
  // the beginning of a map, which the pose defines.
  std::optional<ImageInformation> information{};
  // Where `pose` is fused with an IMU, or its image was taken before the stamp: that of the image
  // alone, if it has one.
  std::optional<AnchoredPose> by_image{};
  std::shared_ptr<const ReadingsBetween> readings{};  // since the frame before
  Stamp delay = 0;  // of the colour: `by_image` is the pose so long before the stamp

  // Returns the pose that its image alone states, where there is one.
  AnchoredPose& measured() { return by_image ? *by_image : pose; }
  const AnchoredPose& measured() const { return by_image ? *by_image : pose; }
  // Returns its time.
  Stamp measured_at() const { return stamp - delay; }
};

}  // namespace highwall
