#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// Applies the depth corrections of a run, as recorded in its run.json, when a map is rebuilt from
// its images: depth distortion and rolling-shutter compensation (docs/row_times.md).
class DepthOfRun {
 public:
  // run: a folder with run.json and trajectory.txt. Corrections that they do not record are not
  // applied. Throws IoError if they cannot be read.
  explicit DepthOfRun(const std::filesystem::path& run);

  // camera: of the images. Rows are not compensated without poses just before and after the image.
  cv::Mat Correct(const RgbdImage& image, const PinholeCamera& camera) const;

 private:
  DepthPattern pattern_;
  FrameTiming timing_;
  Trajectory trajectory_;  // T_WC of all frames; empty: no compensation
};

}  // namespace highwall::apps
