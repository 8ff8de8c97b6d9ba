#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/options.h>
#include <highwall/frontend/map/map_ids.h>

namespace highwall {

// Image pyramid, each level resized from the previous one, as for corner detection.
class ImageLevels {
 public:
  // gray: CV_8UC1.
  ImageLevels(const cv::Mat& gray, const PyramidOptions& pyramid);

  const cv::Mat& level(int octave) const { return images_[static_cast<std::size_t>(octave)]; }
  int size() const { return static_cast<int>(images_.size()); }
  // Size of a pixel of that level [px of the image].
  double Scale(int octave) const { return static_cast<double>(level(0).cols) / level(octave).cols; }
  // Converts between pixels of the image and of that level, (0, 0) being the centre of the first
  // pixel.
  Eigen::Vector2d ToLevel(const Eigen::Vector2d& pixel, int octave) const;
  Eigen::Vector2d FromLevel(const Eigen::Vector2d& place, int octave) const;

 private:
  std::vector<cv::Mat> images_;
};

// Appearance of a landmark in the keyframe that observed it first, at the pyramid level of its
// corner.
struct CornerPatch {
  static constexpr int kRadius = 9;
  static constexpr int kSide = 2 * kRadius + 1;
  // Half the side of the compared part: 9 x 9 pixels of the other image.
  static constexpr double kCompared = 4.5;

  KeyFrameId keyframe = kNoId;
  double scale = 1.0;  // size of a pixel of that level [px of the image]
  // [px of the level] from the centre of the middle pixel to the corner, within half a pixel.
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  std::array<std::uint8_t, kSide * kSide> pixels{};  // row by row
};

// Returns the patch around a corner; empty if it exceeds the level. pixel: [px] of the image.
std::optional<CornerPatch> CutPatch(const ImageLevels& image, int octave,
                                    const Eigen::Vector2d& pixel, KeyFrameId keyframe);

// Returns the position of the patch in another image, starting from `pixel` at level `octave`:
// least squares of grey levels up to a gain and an offset over 9 x 9 pixels (ceres::TinySolver;
// Lucas, Kanade, IJCAI 1981; Baker, Matthews, IJCV 56(3), 2004). A: from offsets [px] in this image
// to offsets in that of the patch. Empty if the position is outside of either, is farther than two
// pixels of the level, or correlates with the patch by less than 0.9.
std::optional<Eigen::Vector2d> AlignPatch(const CornerPatch& patch, const Eigen::Matrix2d& A,
                                          const ImageLevels& image, int octave,
                                          const Eigen::Vector2d& pixel);

}  // namespace highwall
