#include <highwall/factors/rgbd_projection.h>

#include <cmath>
#include <string>

#include <highwall/core/error.h>

namespace highwall {

RgbdProjection::RgbdProjection(const PinholeCamera& camera, const Pose& T_BC,
                               const VirtualRightCamera& right, double min_depth)
    : fx_(camera.fx),
      fy_(camera.fy),
      cx_(camera.cx),
      cy_(camera.cy),
      fxb_(right.fx * right.baseline),
      min_depth_(min_depth),
      R_CB_(T_BC.Inverse().R()),
      p_CB_(T_BC.Inverse().p()) {
  camera.Validate();
  HIGHWALL_REQUIRE(!camera.HasDistortion(),
                   "RgbdProjection works in undistorted pixels: pass camera.WithoutDistortion()");
  HIGHWALL_REQUIRE(T_BC.IsFinite(), "RgbdProjection: non-finite T_BC");
  HIGHWALL_REQUIRE(right.fx == camera.fx, "VirtualRightCamera::fx must equal the camera's, is " +
                                              std::to_string(right.fx));
  HIGHWALL_REQUIRE(
      std::isfinite(right.baseline) && right.baseline > 0.0,
      "VirtualRightCamera::baseline must be positive, is " + std::to_string(right.baseline));
  HIGHWALL_REQUIRE(std::isfinite(min_depth) && min_depth > 0.0,
                   "RgbdProjection: min_depth must be positive, is " + std::to_string(min_depth));
}

}  // namespace highwall
