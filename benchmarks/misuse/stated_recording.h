#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "run/slam_run.h"
#include "true_recording.h"

namespace highwall::bench {

// A frame as a recording states it: the images of the true recording that it holds, and its stamps.
struct StatedFrame {
  std::size_t colour = 0, depth = 0;
  Stamp stamp = 0;
  Stamp depth_delay = 0;  // of the stated stamp of the depth image
};

// Changes the stored values (CV_16UC1) of the depth image of a frame.
using StoredDepthChange = std::function<void(std::size_t frame, cv::Mat* stored)>;

// What a user states of a recording, which may be wrong.
struct StatedRecording {
  RgbdSensor sensor;
  std::optional<apps::ImuFeed> imu;
  std::vector<StatedFrame> frames;
  StoredDepthChange change_depth{};  // empty: none
  // Changes a colour image (CV_8UC3, of its own memory); empty: none.
  std::function<void(cv::Mat* bgr)> change_colour{};
};

// Returns what is true of a recording.
StatedRecording TruthOf(const TrueRecording& recording);

// A recording as it is stated. Images are changed when they are loaded; those of the true recording
// stay.
class StatedSequence final : public Dataset {
 public:
  // recording: must outlive this. stated: at least one frame.
  StatedSequence(const TrueRecording& recording, StatedRecording stated);

  std::size_t size() const override { return stated_.frames.size(); }
  Stamp stamp(std::size_t index) const override { return stated_.frames[index].stamp; }
  Stamp depth_stamp(std::size_t index) const override;
  const Trajectory* groundtruth() const override { return recording_.images->groundtruth(); }

  const StatedRecording& stated() const { return stated_; }
  // Returns the poses at the stamps of the true recording, for a comparison with its ground truth.
  Trajectory AtTrueStamps(const Trajectory& trajectory) const;

 private:
  RgbdImage DoLoad(std::size_t index) const override;

  const TrueRecording& recording_;
  StatedRecording stated_;
};

}  // namespace highwall::bench
