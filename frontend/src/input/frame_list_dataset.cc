#include "input/frame_list_dataset.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/image_io.h>
#include <highwall/frontend/input/tum_dataset.h>
#include <highwall/internal/number_text.h>

#include "input/colour_to_depth.h"
#include "input/depth_unit.h"
#include "input/exr_depth.h"
#include "input/phone_recording.h"
#include "input/recording_folder.h"

namespace highwall {
namespace {

constexpr double kMillimetres = 1000.0;  // in a metre

std::string SizeText(const cv::Size& size) {
  return std::to_string(size.width) + " x " + std::to_string(size.height);
}

// Whether one is the other, reduced: sides are rounded to pixels.
bool HaveOneShape(const cv::Size& a, const cv::Size& b) {
  const double ratio = static_cast<double>(a.width) * b.height / (a.height * double(b.width));
  return std::abs(ratio - 1.0) < 0.02;
}

void RequireSize(const cv::Mat& image, const std::filesystem::path& path,
                 const PinholeCamera& camera) {
  const cv::Size size(camera.width, camera.height);
  if (image.size() == size) return;
  throw IoError(path,
                "is " + SizeText(image.size()) + ", but its camera is set to " + SizeText(size));
}

cv::Mat ReadConfidence(const std::filesystem::path& path) {
  const cv::Mat image = ReadStoredImage(path);
  if (image.type() != CV_8UC1) throw IoError(path, "is not a confidence image of 8 bits");
  return image;
}

// Returns RgbdImage::noise_factor; empty if it is 1 everywhere.
cv::Mat NoiseFactorOf(const cv::Mat& confidence) {
  const cv::Mat medium = confidence == kMediumConfidence;
  if (cv::countNonZero(medium) == 0) return {};
  cv::Mat factor(confidence.size(), CV_32FC1, cv::Scalar(1.0));
  factor.setTo(kMediumConfidenceNoise, medium);
  return factor;
}

// [relative] how far the principal point lies from the middle of an image of this size.
double OffCentre(const PinholeCamera& camera, const cv::Size& size) {
  return std::max(std::abs((camera.cx + 0.5) / size.width - 0.5),
                  std::abs((camera.cy + 0.5) / size.height - 0.5));
}

}  // namespace

std::string WithoutStamps(const std::filesystem::path& folder, double rate) {
  return folder.string() + ": the recording has no stamps: " + RoundedText(rate, 4) +
         " frames a second are assumed; state the rate with --fps";
}

std::string WithoutReference(const IoError& error) {
  return std::string(error.what()) + "; the reference poses are not used";
}

FrameListDataset::FrameListDataset(std::filesystem::path folder, FrameList list,
                                   const std::optional<RgbdSensor>& sensor,
                                   const DatasetOptions& options)
    : folder_(std::move(folder)), list_(std::move(list)), options_(options) {
  options_.Validate();
  if (list_.frames.empty()) {
    throw IoError(folder_, "holds no colour image with a depth image of the same number");
  }
  if (sensor && sensor->depth_camera) {
    sensor->Validate();
    registration_ = std::make_unique<DepthRegistration>(sensor->camera, *sensor->depth_camera);
    list_.shared_axis = false;
  }
  for (std::string& warning : list_.warnings) AddWarning(std::move(warning));
  Sort();
  FindSizes();
  AdaptCalibration();
  if (sensor) {
    sensor->Validate();
    sensor_ = *sensor;
  } else {
    if (list_.calibration) sensor_ = list_.calibration->sensor;
    options_.any_size = true;
  }
  CheckDepthFactor();
}

void FrameListDataset::Sort() {
  std::vector<FrameFiles>& frames = list_.frames;
  std::ranges::stable_sort(frames, {}, &FrameFiles::stamp);
  // Not std::ranges::unique: clang 14 does not compile its range with this standard library.
  const auto doubles =
      std::unique(frames.begin(), frames.end(),
                  [](const FrameFiles& a, const FrameFiles& b) { return a.stamp == b.stamp; });
  if (doubles != frames.end()) {
    AddWarning(folder_.string() + ": " + std::to_string(frames.end() - doubles) +
               " frames have the stamp of another one and are not used");
    frames.erase(doubles, frames.end());
  }
  std::ranges::sort(list_.without_depth);
}

// The sizes are those of the first frame that can be read, and hold for all.
void FrameListDataset::FindSizes() {
  std::string first_problem;
  for (const FrameFiles& frame : list_.frames) {
    try {
      const cv::Mat measured = ReadDepth(frame);
      RequireDepth(frame, measured);
      const cv::Size depth = measured.size(), colour = ReadColour(frame).size();
      RequireOneView(frame, colour, depth);
      colour_size_ = colour;
      frame_size_ = list_.shared_axis ? FrameSize(colour, depth) : colour;
      return;
    } catch (const IoError& error) {
      if (first_problem.empty()) first_problem = error.what();
    }
  }
  throw IoError(folder_, "none of its " + std::to_string(list_.frames.size()) +
                             " frames can be used; the first: " + first_problem);
}

// Returns the camera of the colour images. A matrix whose principal point is rather in the middle
// of the images than in that of the size that the format states was written for the images.
PinholeCamera FrameListDataset::CameraOfImages(const PinholeCamera& stated) const {
  const cv::Size size(stated.width, stated.height);
  PinholeCamera camera = stated;
  if (size.area() == 0 || size == colour_size_ ||
      (list_.assumed_size && OffCentre(stated, colour_size_) < OffCentre(stated, size))) {
    camera.width = colour_size_.width;
    camera.height = colour_size_.height;
    return camera;
  }
  if (!HaveOneShape(size, colour_size_)) {
    throw IoError(list_.calibration_file, "is for images of " + SizeText(size) +
                                              ", but the colour images are " +
                                              SizeText(colour_size_));
  }
  return ResizedCamera(stated, colour_size_);
}

void FrameListDataset::AdaptCalibration() {
  if (!list_.calibration) return;
  RgbdSensor& sensor = list_.calibration->sensor;
  sensor.camera = ResizedCamera(CameraOfImages(sensor.camera), frame_size_);
  try {
    sensor.Validate();
  } catch (const InvalidArgument& error) {  // the file's fault, which IoError reports
    throw IoError(list_.calibration_file, error.what());
  }
}

// Looks at a few depth images spread over the recording.
void FrameListDataset::CheckDepthFactor() {
  const auto doubt = DoubtOfDepthFactor(size(), sensor_.depth_factor, [this](std::size_t i) {
    return MetricDepth(ReadDepth(list_.frames[i]), sensor_.depth_factor);
  });
  if (doubt) AddWarning(folder_.string() + ": " + *doubt);
}

cv::Mat FrameListDataset::ReadColour(const FrameFiles& frame) const {
  return frame.colour.empty() ? list_.video->Read(frame.number) : ReadColourImage(frame.colour);
}

// Returns the stored values; 0 where nothing was measured.
cv::Mat FrameListDataset::ReadDepth(const FrameFiles& frame, cv::Mat* noise_factor) const {
  cv::Mat depth;
  if (frame.depth.extension() == ".exr") {
    depth = ReadExrDepth(frame.depth) * kMillimetres;
  } else {
    depth = ReadDepthImage(frame.depth);
    depth.setTo(0, depth == UINT16_MAX);  // how 7-Scenes and full sensors mark a hole
  }
  if (frame.confidence.empty()) return depth;
  const cv::Mat confidence = ReadConfidence(frame.confidence);
  if (confidence.size() != depth.size()) {
    throw IoError(frame.confidence, "is " + SizeText(confidence.size()) +
                                        ", but its depth image is " + SizeText(depth.size()));
  }
  depth.setTo(0, confidence == kLowConfidence);
  if (noise_factor != nullptr) *noise_factor = NoiseFactorOf(confidence);
  return depth;
}

// Throws IoError for a frame without any depth, unless an IMU can bridge it.
void FrameListDataset::RequireDepth(const FrameFiles& frame, const cv::Mat& depth) const {
  if (list_.imu_file || cv::countNonZero(depth) > 0) return;
  throw IoError(frame.depth, "holds no depth: all zero");
}

// Throws IoError unless depth has the size of colour or, with one axis, its shape.
void FrameListDataset::RequireOneView(const FrameFiles& frame, const cv::Size& colour,
                                      const cv::Size& depth) const {
  if (registration_) return;  // which has a size for each
  if (list_.shared_axis ? HaveOneShape(depth, colour) : depth == colour) return;
  throw IoError(frame.depth, "is " + SizeText(depth) + ", but its colour image is " +
                                 SizeText(colour) + (list_.shared_axis ? ": another shape" : "") +
                                 "; depth must be registered to colour");
}

void FrameListDataset::Resample(const FrameFiles& frame, RgbdImage* image) const {
  const PinholeCamera& to = list_.calibration->sensor.camera;
  const PinholeCamera from = frame.camera ? CameraOfImages(*frame.camera) : to;
  image->bgr = ResampleColour(image->bgr, from, to);
  image->depth = ResampleDepth(image->depth, from, to);
  cv::Mat& factor = image->noise_factor;
  if (!factor.empty()) factor = ResampleDepth(factor, from, to);
}

RgbdImage FrameListDataset::DoLoad(std::size_t index) const {
  const FrameFiles& frame = list_.frames[index];
  RgbdImage image{.stamp = frame.stamp, .bgr = ReadColour(frame), .depth = {}};
  image.depth = ReadDepth(frame, &image.noise_factor);
  cv::Mat &colour = image.bgr, &depth = image.depth;
  RequireOneView(frame, colour.size(), depth.size());
  if (list_.shared_axis) {
    if (colour.size() != colour_size_) {
      throw IoError(
          frame.colour.empty() ? list_.video->path() : frame.colour,
          "is " + SizeText(colour.size()) + ", but the first image is " + SizeText(colour_size_));
    }
    Resample(frame, &image);
  }
  const PinholeCamera& camera = sensor_.camera;
  if (registration_) {
    RequireSize(colour, frame.colour.empty() ? list_.video->path() : frame.colour, camera);
    RequireSize(depth, frame.depth, sensor_.depth_camera->camera);
  } else if (!options_.any_size && (depth.cols != camera.width || depth.rows != camera.height)) {
    throw IoError(frame.depth, "gives a frame of " + SizeText(depth.size()) +
                                   ", but the camera is set to " +
                                   SizeText({camera.width, camera.height}));
  }
  RequireDepth(frame, depth);
  depth =
      MetricDepth(depth, sensor_.depth_factor, sensor_.inverse_depth_offset, sensor_.depth_pattern);
  if (registration_) depth = registration_->Register(depth, &image.noise_factor);
  return image;
}

}  // namespace highwall
