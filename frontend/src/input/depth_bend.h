#pragma once

#include <opencv2/core/mat.hpp>

namespace highwall {

// Tells depth from inverse depth by the images of planes. Along a row or a column the inverse depth
// of a plane is affine, so that 1 / value = c0 + c1 t + c2 t^2 has c2 = 0 where the values are
// depths. Where they are disparities, 1 / value is the depth up to a factor, and c2 = c1^2 / c0.
// The bend c0 c2 / c1^2 is then 0 or 1, whatever the slope (docs/misconfiguration.md).
class DepthBend {
 public:
  // raw: CV_16UC1, 0 where nothing was measured.
  void Add(const cv::Mat& raw);
  // Number of images with slanted planes of depth, bend 0, and of inverse depth, bend 1: a third of
  // the surfaces bend less, a third more, and both thirds begin near this value. Curved surfaces
  // bend by anything, each differently along itself.
  int depth() const { return depth_; }
  int inverse() const { return inverse_; }

 private:
  int depth_ = 0, inverse_ = 0;
};

}  // namespace highwall
