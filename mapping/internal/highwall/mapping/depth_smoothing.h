#pragma once

#include <opencv2/core/mat.hpp>

#include <highwall/mapping/depth_camera.h>

namespace [[gnu::visibility("default")]] highwall {

struct DepthSmoothingOptions {
  double target_sigma = 0.003;  // [m] > 0; noise that is tolerated
  double max_extent = 0.02;     // [m] > 0; bound of half a window on the surface, or one sigma if
                                // that is larger, since it hides smaller structures anyway
  int max_radius = 6;           // [px] >= 0; half a window; 0 leaves the image unchanged
  double grain = 3.0;  // [px] > 0; distance at which the noise of two pixels is independent
  double gate = 2.5;   // [sigma] > 0; if the mean of two opposite pixels differs by more from
                       // the pixel between them, they are on another surface

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Returns depth with reduced noise: each pixel is replaced by the mean inverse depth of a square
// window around it, over those pairs of opposite pixels that may lie on the same surface (Tomasi
// and Manduchi, "Bilateral Filtering", ICCV 1998, with a window in place of Gaussians). Inverse
// depth is used since planes are linear in it: the mean over a whole window lies on the plane. The
// window size follows from sigma(z); there is no window where sigma(z) is below the target. depth:
// CV_32FC1 [m], 0 or NaN where not measured, which is kept; may be empty. focal: of the camera [px]
// > 0. noise_factor: as that of KeyframeImage. Throws InvalidArgument for other images.
cv::Mat SmoothDepth(const cv::Mat& depth, double focal, const DepthSigma& sigma,
                    const DepthSmoothingOptions& options = {}, const cv::Mat& noise_factor = {});

}  // namespace highwall
