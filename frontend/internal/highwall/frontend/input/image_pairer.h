#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>

namespace [[gnu::visibility("default")]] highwall {

// Pairs colour and depth images that arrive separately, each in the order of its stamps: a colour
// image with the nearest depth image. Not thread-safe.
class ImagePairer {
 public:
  static constexpr std::size_t kMostWaiting = 30;  // images of each kind

  // max_difference: [s] > 0 between the stamps of a pair.
  explicit ImagePairer(double max_difference) : max_difference_(FromSeconds(max_difference)) {}

  // Return the pairs that are decided by this image, in order; an image that is not later than the
  // last one of its kind is left out.
  std::vector<RgbdImage> AddColour(Stamp stamp, cv::Mat bgr);
  std::vector<RgbdImage> AddDepth(Stamp stamp, cv::Mat depth);

  // Number of colour images without a depth image in time.
  std::size_t unpaired() const { return unpaired_; }
  // Number of images that were left out because of their stamps.
  std::size_t out_of_order() const { return out_of_order_; }

 private:
  struct Waiting {
    Stamp stamp = 0;
    cv::Mat image;
  };

  // Returns false if the image is left out.
  bool Add(Stamp stamp, cv::Mat image, std::optional<Stamp>* last, std::deque<Waiting>* waiting);
  std::vector<RgbdImage> Pair();

  const Stamp max_difference_;
  std::deque<Waiting> colours_, depths_;
  std::optional<Stamp> last_colour_, last_depth_;
  std::size_t unpaired_ = 0, out_of_order_ = 0;
};

}  // namespace highwall
