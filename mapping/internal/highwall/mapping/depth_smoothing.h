#pragma once

#include <opencv2/core/mat.hpp>

#include <highwall/mapping/depth_camera.h>

namespace [[gnu::visibility("default")]] highwall {

struct DepthSmoothingOptions {
  double target_sigma = 0.003;  // [m] > 0; noise that may stay
  double max_extent = 0.02;     // [m] > 0; half a window is at most that wide on the surface, or
                                // as wide as one sigma, which hides smaller things anyhow
  int max_radius = 6;           // [px] >= 0; half a window; 0: the image stays as it is
  double grain = 3.0;  // [px] > 0; distance at which the noise of two pixels is independent
  double gate = 2.5;   // [sigma] > 0; a mean of two opposite pixels that differs more from
                       // the one between them is of another surface

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Depth with less noise: a pixel becomes the mean inverse depth of a square window around it, of
// those pairs of opposite pixels that may lie on the same surface (Tomasi and Manduchi, "Bilateral
// Filtering", ICCV 1998, with a window in place of Gaussians). Inverse depth, since planes are
// linear in it: the mean of a whole window is the plane's own. The window is as wide as sigma(z)
// asks for, none where that is below the target. depth: CV_32FC1 [m], 0 or NaN where nothing was
// measured, which stays so; may be empty. focal: of the camera [px] > 0. Throws InvalidArgument for
// another image.
cv::Mat SmoothDepth(const cv::Mat& depth, double focal, const DepthSigma& sigma,
                    const DepthSmoothingOptions& options = {});

}  // namespace highwall
