#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <highwall/frontend/features/frame.h>

#include "features/image_gradient.h"

namespace highwall::internal {

// Detects line segments by edge drawing: chains of pixels are drawn along the ridges of the
// gradient's magnitude from anchors, its clear maxima (Topal, Akinlar, "Edge Drawing: a combined
// real-time edge and segment detector", 2012), and divided into straight pieces by least squares
// (Akinlar, Topal, "EDLines: a real-time line segment detector with a false detection control",
// 2011). Unlike theirs, a chain is drawn so that the bright side is to its left, and ends where the
// direction of the gradient changes fast: it has no branches, turns at no corner, and gives the
// segments their direction.
//
// An object holds memory that is used again for the next image; the segments depend on nothing but
// the image and the length.
class EdgeLines {
 public:
  // Returns the segments of at least min_length [px], 3 or more, within the image. Their ends have
  // the order that LineSegment states. gradient: of an image of one pixel or more.
  std::vector<LineSegment> Detect(const ImageGradient& gradient, float min_length);

 private:
  struct Pixel {
    int x, y;
  };
  // Sums over the first pixels of a chain, in whole numbers: a difference of two is exact.
  struct Sums {
    std::int64_t x, y, xx, xy, yy;
  };
  struct Line;

  std::int16_t& MagnitudeAt(Pixel pixel) {
    return magnitude_[static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(width_) +
                      static_cast<std::size_t>(pixel.x)];
  }

  void FindMagnitudes(const ImageGradient& gradient);
  void FindAnchors(const ImageGradient& gradient);
  // Replaces the chain by that through an anchor.
  void Draw(const ImageGradient& gradient, Pixel anchor);
  // Appends the pixels that are ahead of one (sign 1) or behind it (sign -1) to the chain.
  void Follow(const ImageGradient& gradient, Pixel pixel, int sign);
  // Appends the straight pieces of the chain to `lines`.
  void Divide(const ImageGradient& gradient, float min_length, std::vector<LineSegment>* lines);
  void SumChain();
  // Fits a line to pixels begin ... end - 1 of the chain, two or more.
  Line Fit(std::size_t begin, std::size_t end) const;
  // Extends a line, fitted to pixels begin ... end - 1, as far as the chain follows it; returns the
  // new end.
  std::size_t Extend(std::size_t begin, std::size_t end, Line* line) const;
  // Returns whether so many of the pixels begin ... end - 1 have a gradient normal to the segment
  // that noise would hardly look like it.
  bool IsMeaningful(const ImageGradient& gradient, const LineSegment& segment, std::size_t begin,
                    std::size_t end) const;

  int width_ = 0, height_ = 0;
  // Row by row, |d/dx| + |d/dy| with the lowest bit cleared; 0 below the threshold and at the
  // border. The lowest bit is set for a pixel of a chain.
  std::vector<std::int16_t> magnitude_;
  std::vector<std::uint8_t> is_maximum_;  // for each pixel of a row: 1 or 0
  std::vector<Pixel> anchors_;
  std::vector<Pixel> chain_;
  std::vector<Sums> sums_;                // one more than pixels in the chain
  std::vector<std::size_t> min_aligned_;  // by the number of pixels of a segment
};

}  // namespace highwall::internal
