#pragma once

#include <highwall/core/pose.h>

#include <highwall/frontend/features/twist.h>

namespace highwall {

// Constant-velocity motion model of the camera: a twist in the camera frame, per second, so that
// images may be missing, late, or of any rate.
class ConstantVelocity {
 public:
  // [s] Within this time a hand-held camera may have reversed its motion.
  static constexpr double kLongestPrediction = 0.5;

  // Measures the velocity from the motion of the camera from pose A to pose B within dt [s]. A step
  // that is backwards in time, or too short for a velocity above the error of the two poses, is
  // ignored.
  void Measure(const Pose& T_AB, double dt);
  // Resets the model to a stationary camera.
  void Reset() { *this = {}; }
  // Returns the motion predicted for the next dt [s], T_(now, now + dt). A velocity is valid only
  // briefly: it is extrapolated for at most half a second, or over the step that it was measured
  // over if images are slower than that. Returns the identity if dt is negative.
  Pose Predict(double dt) const;
  // Mean twist of the last step.
  const Twist& twist() const { return twist_; }
  // Returns the twist at the beginning of this step, interpolated between its mean and that of the
  // preceding step `before`.
  Twist AtBeginning(const ConstantVelocity& before) const;

 private:
  Twist twist_;
  double step_ = 0.0;  // [s] duration of the step it was measured over
};

}  // namespace highwall
