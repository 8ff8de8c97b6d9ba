#pragma once

#include <highwall/core/pose.h>

#include <highwall/frontend/features/twist.h>

namespace highwall {

// Motion of a camera that goes on as it last did: a twist in the camera's own frame, per second, so
// that images may be missing, late, or of any rate.
class ConstantVelocity {
 public:
  // [s] By hand a camera has turned round by then.
  static constexpr double kLongestPrediction = 0.5;

  // The camera came from pose A to pose B within dt [s]. A step too short to tell a velocity, which
  // the error of the two poses would drown, or backwards in time, leaves it as it was.
  void Measure(const Pose& T_AB, double dt);
  // Standing still.
  void Reset() { *this = {}; }
  // The motion expected within the next dt [s]: T_(now, now + dt). A velocity is news of the
  // moment: it is carried on no longer than half a second, or the step that it was measured over
  // where images are slower than that. Backwards in time there is none.
  Pose Predict(double dt) const;
  // The mean one of the last step.
  const Twist& twist() const { return twist_; }
  // At the beginning of this step, which followed the step of `before`: between both means.
  Twist AtBeginning(const ConstantVelocity& before) const;

 private:
  Twist twist_;
  double step_ = 0.0;  // [s] it was measured over
};

}  // namespace highwall
