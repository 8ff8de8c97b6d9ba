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

// An image at the sizes of a pyramid, each made of the one before, as corners are found in it.
class ImageLevels {
 public:
  // gray: CV_8UC1.
  ImageLevels(const cv::Mat& gray, const PyramidOptions& pyramid);

  const cv::Mat& level(int octave) const { return images_[static_cast<std::size_t>(octave)]; }
  int size() const { return static_cast<int>(images_.size()); }
  // Size of a pixel of that level [px of the image].
  double Scale(int octave) const {
    return static_cast<double>(level(0).cols) / level(octave).cols;
  }
  // Between pixels of the image and of that level, (0, 0) being the middle of the first.
  Eigen::Vector2d ToLevel(const Eigen::Vector2d& pixel, int octave) const;
  Eigen::Vector2d FromLevel(const Eigen::Vector2d& place, int octave) const;

 private:
  std::vector<cv::Mat> images_;
};

// What a landmark looks like in the keyframe that saw it first, at the level where its corner was
// found.
struct CornerPatch {
  static constexpr int kRadius = 9;
  static constexpr int kSide = 2 * kRadius + 1;
  // Of what is compared, half its side: 9 x 9 pixels as the other image sees them.
  static constexpr double kCompared = 4.5;

  KeyFrameId keyframe = kNoId;
  double scale = 1.0;  // size of a pixel of that level [px of the image]
  // [px of the level] of the corner from the middle of the middle pixel, within half a pixel.
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();
  std::array<std::uint8_t, kSide * kSide> pixels{};  // row by row
};

// The patch about a corner; none where the level ends. pixel: [px] of the image.
std::optional<CornerPatch> CutPatch(const ImageLevels& image, int octave,
                                    const Eigen::Vector2d& pixel, KeyFrameId keyframe);

// Where in another image the patch is, found from `pixel` on at level `octave`: least squares of
// grey levels up to a gain and an offset over 9 x 9 pixels (ceres::TinySolver; Lucas, Kanade,
// IJCAI 1981; Baker, Matthews, IJCV 56(3), 2004). A: from offsets [px] in this image to offsets in
// that of the patch. Nothing where either ends, it is farther than two pixels of the level, or
// what is there correlates with the patch by less than 0.9.
std::optional<Eigen::Vector2d> AlignPatch(const CornerPatch& patch, const Eigen::Matrix2d& A,
                                          const ImageLevels& image, int octave,
                                          const Eigen::Vector2d& pixel);

}  // namespace highwall
