#include <highwall/factors/rgbd_projection.h>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/require.h>

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
  HIGHWALL_REQUIRE(T_BC.IsFinite(), "RgbdProjection: T_BC must be finite");
  HIGHWALL_REQUIRE(right.fx == camera.fx,
                   "VirtualRightCamera::fx must equal the camera's, is " + FixedText(right.fx));
  RequirePositiveFinite(right.baseline, "VirtualRightCamera::baseline");
  RequirePositiveFinite(min_depth, "RgbdProjection: min_depth");
}

}  // namespace highwall
