#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/camera.h>

// Colour and depth of different sizes that share one optical axis, as on phones, brought to one
// pinhole camera (docs/recordings.md).
namespace highwall {

// Returns the size of the frames of a recording: that of the colour images if it is the one of the
// depth images or has at most 640 x 480 pixels, else the largest integer fraction of it that has.
cv::Size FrameSize(const cv::Size& colour, const cv::Size& depth);

// Returns the same camera for images of another size of the same view; a pixel centre u maps to
// (u + 0.5) s - 0.5. camera: with its size, and without distortion.
PinholeCamera ResizedCamera(const PinholeCamera& camera, const cv::Size& size);

// Returns the image of `from` as the camera `to` sees it, CV_8UC3: pixels are averaged over areas;
// where the cameras differ by more than the size (a focus that moved), resampled linearly as well.
cv::Mat ResampleColour(const cv::Mat& colour, const PinholeCamera& from, const PinholeCamera& to);

// Returns the depth of `from` as the camera `to` sees it, in the type of `depth`: each pixel has
// the value of the pixel of `depth` that its centre lies in, of the next one if it lies between
// two. Nothing is interpolated, so that no depth between two surfaces appears, and a pixel without
// depth (0) stays one.
cv::Mat ResampleDepth(const cv::Mat& depth, const PinholeCamera& from, const PinholeCamera& to);

}  // namespace highwall
