#pragma once

#include <array>
#include <optional>
#include <span>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/orb_matcher.h>
#include <highwall/frontend/input/sensor_verdict.h>
#include <highwall/frontend/map/measurement_model.h>

#include "features/depth_grid.h"

namespace highwall {

// Tests by pairs of images whether depth belongs to what the images show: points of one depth move
// as the camera moves, and with the depth of other places they do not (docs/misconfiguration.md,
// Depth). The depth image is tried as it is, flipped, as its inverse, and as a constant.
class DepthMotion {
 public:
  // model: must outlive this object.
  explicit DepthMotion(const MeasurementModel& model) : model_(model), grid_(model.camera()) {}

  // Adds the matches (query: of the first image, train: of the second) of a pair that agree with an
  // epipolar geometry.
  void Add(const FrameFeatures& first, const FrameFeatures& second,
           std::span<const FeatureMatch> matches);
  // Returns a finding if depth that is read otherwise explains the motion; empty where the motion
  // does not tell.
  std::optional<SensorFinding> Misread() const;

 private:
  enum Depth { kAsItIs, kLeftRight, kUpsideDown, kHalfTurn, kInverse, kConstant, kCount };
  static constexpr int kFlips = kInverse;  // the first of them, by the bits of their values

  // Share of the matches.
  double Unexplained(Depth depth) const;

  const MeasurementModel& model_;
  DepthGrid grid_;
  int matches_ = 0;
  std::array<int, kCount> explained_{};  // matches
};

}  // namespace highwall
