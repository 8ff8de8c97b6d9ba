#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// How a run corrected the depth of its recording, as run.json says, for a map that is made again of
// its images: by the pattern over the image, and by the times of the rows (docs/row_times.md).
class DepthOfRun {
 public:
  // run: a folder with run.json and trajectory.txt. What they do not say is not corrected. Throws
  // IoError where they cannot be read.
  explicit DepthOfRun(const std::filesystem::path& run);

  // camera: of the images. Without poses just before and after the image its rows stay.
  cv::Mat Correct(const RgbdImage& image, const PinholeCamera& camera) const;

 private:
  DepthPattern pattern_;
  FrameTiming timing_;
  Trajectory trajectory_;  // T_WC of all frames; empty: rows stay
};

}  // namespace highwall::apps
