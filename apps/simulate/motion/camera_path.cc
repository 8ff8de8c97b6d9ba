#include "simulate/motion/camera_path.h"

#include <cmath>
#include <utility>

#include <highwall/core/error.h>

namespace highwall::simulate {
namespace {

constexpr double kStart = 1.0;  // [s] from rest to full speed

}  // namespace

CameraPath::CameraPath(SplineTrajectory spline, double rest)
    : spline_(std::move(spline)), rest_(rest) {
  HIGHWALL_REQUIRE(std::isfinite(rest) && rest >= 0.0, "CameraPath: rest must not be negative");
}

CameraPath::Progress CameraPath::ProgressAt(double t) const {
  if (rest_ == 0.0) return {t, 1.0, 0.0};
  const double x = (t - rest_) / kStart;
  if (x <= 0.0) return {0.0, 0.0, 0.0};
  if (x >= 1.0) return {t - rest_ - 0.5 * kStart, 1.0, 0.0};
  // The speed is the quintic step 10 x^3 - 15 x^4 + 6 x^5, whose integral over the start is 1/2.
  return {kStart * x * x * x * x * (2.5 + x * (x - 3.0)), x * x * x * (10.0 + x * (6.0 * x - 15.0)),
          30.0 * x * x * (1.0 - x) * (1.0 - x) / kStart};
}

Pose CameraPath::T_WC(double t) const {
  return spline_.T_WC(ProgressAt(t).s);
}

CameraMotion CameraPath::MotionAt(double t) const {
  const Progress progress = ProgressAt(t);
  CameraMotion motion = spline_.MotionAt(progress.s);
  const double ds2 = progress.ds * progress.ds;
  motion.a_WC = ds2 * motion.a_WC + progress.dds * motion.v_WC;
  motion.alpha_C = ds2 * motion.alpha_C + progress.dds * motion.w_C;
  motion.v_WC *= progress.ds;
  motion.w_C *= progress.ds;
  return motion;
}

double CameraPath::MovingTime(double duration, double rest) {
  return rest == 0.0 ? duration : duration - rest - 0.5 * kStart;
}

}  // namespace highwall::simulate
