#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "input/depth_registration.h"
#include "input/video_frames.h"

namespace highwall {

// The files of one frame.
struct FrameFiles {
  Stamp stamp = 0;
  std::filesystem::path colour{};      // an image; empty: image `number` of the video
  std::size_t number = 0;              // of the image in the video
  std::filesystem::path depth{};       // 16 bits as they are, or .exr: metres, taken as millimetres
  std::filesystem::path confidence{};  // ARKit's, 8 bits; empty: none
  // Colour camera of this frame where the focus moves, of the size of FrameList::calibration.
  std::optional<PinholeCamera> camera{};
};

// A recording as the reader of its format finds it.
struct FrameList {
  std::vector<FrameFiles> frames{};         // in any order
  std::vector<Stamp> without_depth{};       // stamps of the other colour images
  std::shared_ptr<VideoFrames> video{};     // null: colour images are files
  std::optional<Trajectory> groundtruth{};  // T_WC, by ascending stamps
  std::optional<std::filesystem::path> imu_file{};
  // What the recording states, with the camera of the colour images in the size that it states;
  // 0 x 0: that of the images.
  std::optional<SensorCalibration> calibration{};
  std::filesystem::path calibration_file{};  // for messages
  // Whether the size of that camera is the usual one of the format: the file states none.
  bool assumed_size = false;
  // Whether depth is of the same view as colour, in any size; else its size is that of colour.
  bool shared_axis = false;
  std::vector<std::string> warnings{};
};

// Returns the warning for frames whose stamps are made from a rate [Hz].
std::string WithoutStamps(const std::filesystem::path& folder, double rate);

// Returns the warning for reference poses that cannot be read; images do not need them.
std::string WithoutReference(const IoError& error);

// A recording whose frames are files of known names: what the readers of such formats share.
class FrameListDataset : public Dataset {
 public:
  std::size_t size() const override { return list_.frames.size(); }
  Stamp stamp(std::size_t index) const override { return list_.frames.at(index).stamp; }
  const Trajectory* groundtruth() const override {
    return list_.groundtruth ? &*list_.groundtruth : nullptr;
  }
  std::vector<Stamp> stamps_without_depth() const override { return list_.without_depth; }
  std::optional<std::filesystem::path> imu_file() const override { return list_.imu_file; }
  bool is_registered() const override { return list_.shared_axis || registration_; }
  // For the size of the frames.
  const SensorCalibration* calibration() const override {
    return list_.calibration ? &*list_.calibration : nullptr;
  }

 protected:
  // sensor: converts the stored depth to metres, and its camera has the size of the frames; empty:
  // the one that the recording states, or that of the benchmark for images of any size.
  // Throws InvalidArgument for a bad sensor or bad options, and IoError if there is no frame, if
  // none can be used, and for a camera that is none.
  FrameListDataset(std::filesystem::path folder, FrameList list,
                   const std::optional<RgbdSensor>& sensor, const DatasetOptions& options);

 private:
  RgbdImage DoLoad(std::size_t index) const override;
  void Sort();
  void FindSizes();
  void AdaptCalibration();
  void CheckDepthFactor();
  cv::Mat ReadColour(const FrameFiles& frame) const;
  // noise_factor: RgbdImage's, in the size of the depth image; may be null.
  cv::Mat ReadDepth(const FrameFiles& frame, cv::Mat* noise_factor = nullptr) const;
  void RequireDepth(const FrameFiles& frame, const cv::Mat& depth) const;
  void RequireOneView(const FrameFiles& frame, const cv::Size& colour, const cv::Size& depth) const;
  void Resample(const FrameFiles& frame, RgbdImage* image) const;
  PinholeCamera CameraOfImages(const PinholeCamera& stated) const;

  std::filesystem::path folder_;
  FrameList list_;
  RgbdSensor sensor_;
  DatasetOptions options_;
  cv::Size colour_size_, frame_size_;
  std::unique_ptr<const DepthRegistration> registration_;  // null: depth has the view of colour
};

}  // namespace highwall
