#include "input/bag_dataset.h"

#include <algorithm>
#include <numeric>
#include <string>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

#include "input/bag_readings.h"
#include "input/depth_unit.h"
#include "input/message_reader.h"
#include "input/pair_advice.h"
#include "input/ros_image.h"

namespace highwall {
namespace {

std::string SizeOf(const cv::Mat& image) {
  return std::to_string(image.cols) + " x " + std::to_string(image.rows);
}

// [Hz] of the median step between the stamps of a topic; 0 for fewer than two.
double RateOf(const BagFile& bag, std::uint32_t topic) {
  std::vector<Stamp> steps;
  const BagMessage* before = nullptr;
  for (const BagMessage& message : bag.messages()) {
    if (message.topic != topic) continue;
    const auto stamp = [&](const BagMessage& of) { return HeaderStamp(bag, of); };
    if (before != nullptr && stamp(message) > stamp(*before)) {
      steps.push_back(stamp(message) - stamp(*before));
    }
    before = &message;
  }
  return steps.empty() ? 0.0 : 1.0 / ToSeconds(UpperMedian(std::move(steps)));
}

}  // namespace

BagDataset::BagDataset(const std::filesystem::path& path, const std::optional<RgbdSensor>& sensor,
                       const DatasetOptions& options)
    : bag_(OpenBag(path)), options_(options) {
  options_.Validate();
  if (sensor) sensor->Validate();
  images_ = ChooseImages(*bag_, options_.topics);
  imu_ = ChooseImu(*bag_, options_.topics, bag_->topics()[images_.colour.topic].name);
  std::vector<std::uint32_t> topics{images_.colour.topic, images_.depth.topic};
  if (imu_) topics.insert(topics.end(), {imu_->gyroscope, imu_->accelerometer});
  use_recorded_ = LackStamps(*bag_, topics);
  if (use_recorded_) {
    AddWarning(bag_->path().string() +
               ": the headers of its messages have no stamps; the times of recording are used");
  }
  colour_ = ListImages(images_.colour.topic);
  depth_ = ListImages(images_.depth.topic);
  if (const std::size_t left_out = colour_.without_stamp + depth_.without_stamp; left_out > 0) {
    AddWarning(bag_->path().string() + ": " + std::to_string(left_out) +
               " images have no stamp and are not used");
  }
  Pair();
  Calibrate(!sensor);
  UseSensor(sensor);
  CheckDepthFactor();
}

BagDataset::Stream BagDataset::ListImages(std::uint32_t topic) {
  Stream stream;
  std::vector<std::pair<Stamp, std::size_t>> list;
  const std::vector<BagMessage>& messages = bag_->messages();
  for (std::size_t i = 0; i < messages.size(); ++i) {
    if (messages[i].topic != topic) continue;
    const Stamp stamp = use_recorded_ ? messages[i].recorded : HeaderStamp(*bag_, messages[i]);
    if (stamp == 0) {
      ++stream.without_stamp;
    } else {
      list.emplace_back(stamp, i);
    }
  }
  if (list.empty()) {
    throw IoError(bag_->path(), "no image of " + bag_->topics()[topic].name +
                                    " has a stamp, and none a time of recording");
  }
  std::ranges::sort(list);
  for (const auto& [stamp, message] : list) {
    if (!stream.stamps.empty() && stream.stamps.back().stamp == stamp) continue;
    stream.stamps.push_back({stamp, {}});
    stream.messages.push_back(message);
  }
  if (stream.stamps.size() < list.size()) {
    AddWarning(bag_->path().string() + ": " + std::to_string(list.size() - stream.stamps.size()) +
               " images of " + bag_->topics()[topic].name +
               " have the stamp of another one and are not used");
  }
  return stream;
}

void BagDataset::Pair() {
  frames_ =
      AssociateNearest(colour_.stamps, depth_.stamps, FromSeconds(options_.max_stamp_difference));
  const std::string limit = RoundedText(options_.max_stamp_difference, 4) + " s";
  const std::string advice = AdviceOnPairs(colour_.stamps, depth_.stamps, frames_);
  if (frames_.empty()) {
    throw IoError(bag_->path(), "no image of " + bag_->topics()[images_.colour.topic].name +
                                    " has one of " + bag_->topics()[images_.depth.topic].name +
                                    " within " + limit + advice);
  }
  const std::size_t alone = colour_.stamps.size() - frames_.size();
  if (4 * alone < colour_.stamps.size()) return;
  AddWarning(bag_->path().string() + ": " + std::to_string(alone) + " of " +
             std::to_string(colour_.stamps.size()) + " colour images have no depth image within " +
             limit + advice);
}

// Returns the sizes of colour and depth: those of the first frame that can be read hold for all.
std::pair<cv::Size, cv::Size> BagDataset::FindSizes() const {
  constexpr std::size_t kMostTried = 30;
  std::string first_problem;
  for (std::size_t i = 0; i < std::min(size(), kMostTried); ++i) {
    try {
      return {ReadColour(i).size(), ReadDepth(i).size()};
    } catch (const IoError& error) {
      if (first_problem.empty()) first_problem = error.what();
    }
  }
  throw IoError(bag_->path(), "its first images cannot be used; the first: " + first_problem);
}

// is_needed: no configuration replaces what the bag states.
void BagDataset::Calibrate(bool is_needed) {
  const auto [colour, depth] = FindSizes();
  try {
    calibration_ = ReadBagCalibration(*bag_, images_, imu_, colour, depth);
  } catch (const IoError& error) {
    if (is_needed) throw;
    AddWarning(std::string(error.what()) + "; the configuration is used alone");
    return;
  }
  for (const std::string& warning : calibration_.warnings) AddWarning(warning);
  if (!calibration_.calibration || !calibration_.calibration->imu) return;
  const double rate = RateOf(*bag_, imu_->gyroscope);
  if (rate > 0.0) calibration_.calibration->imu->rate = rate;
}

void BagDataset::UseSensor(const std::optional<RgbdSensor>& sensor) {
  const SensorCalibration* const stated = calibration();
  if (sensor) {
    sensor_ = *sensor;
    if (stated != nullptr && !sensor_.depth_camera) {
      sensor_.depth_camera = stated->sensor.depth_camera;
    }
    // Whoever takes images of any size does not state the camera.
    if (stated != nullptr && options_.any_size) sensor_.camera = stated->sensor.camera;
  } else {
    if (stated != nullptr) sensor_ = stated->sensor;
    sensor_.depth_factor = DepthFactorOf(*bag_, images_.depth);
    options_.any_size = true;
  }
  if (!sensor_.depth_camera) return;
  registration_ = std::make_unique<DepthRegistration>(sensor_.camera, *sensor_.depth_camera);
}

// Looks at a few depth images spread over the recording.
void BagDataset::CheckDepthFactor() {
  if (images_.depth.first.in_metres) return;
  const auto doubt = DoubtOfDepthFactor(size(), sensor_.depth_factor,
                                        [this](std::size_t i) { return Metric(ReadDepth(i)); });
  if (doubt) AddWarning(bag_->path().string() + ": " + *doubt);
}

std::vector<Stamp> BagDataset::stamps_without_depth() const {
  std::vector<Stamp> stamps;
  auto frame = frames_.begin();
  for (std::size_t i = 0; i < colour_.stamps.size(); ++i) {
    if (frame != frames_.end() && frame->first == i) {
      ++frame;
    } else {
      stamps.push_back(colour_.stamps[i].stamp);
    }
  }
  return stamps;
}

std::optional<std::filesystem::path> BagDataset::imu_file() const {
  if (!imu_) return std::nullopt;
  return bag_->path();
}

ImuRecording BagDataset::ReadImu(const VideoSpan&) const {
  HIGHWALL_REQUIRE(imu_.has_value(), "Dataset::ReadImu: the recording has no IMU");
  return ReadBagReadings(*bag_, *imu_, use_recorded_);
}

BagTopics BagDataset::topics() const {
  const auto name = [&](std::uint32_t topic) { return bag_->topics()[topic].name; };
  BagTopics topics{.colour = name(images_.colour.topic), .depth = name(images_.depth.topic)};
  if (!imu_) return topics;
  if (imu_->IsOne()) {
    topics.imu = name(imu_->gyroscope);
  } else {
    topics.gyroscope = name(imu_->gyroscope);
    topics.accelerometer = name(imu_->accelerometer);
  }
  return topics;
}

cv::Mat BagDataset::ReadColour(std::size_t frame) const {
  const BagMessage& message = bag_->messages()[colour_.messages[frames_[frame].first]];
  const std::vector<std::uint8_t> bytes = bag_->Read(message);
  const std::string name = bag_->NameOf(message);
  return DecodeRosColour({bag_->path(), name, bag_->topics()[message.topic], bytes});
}

cv::Mat BagDataset::ReadDepth(std::size_t frame) const {
  const BagMessage& message = bag_->messages()[depth_.messages[frames_[frame].second]];
  const std::vector<std::uint8_t> bytes = bag_->Read(message);
  const std::string name = bag_->NameOf(message);
  return DecodeRosDepth({bag_->path(), name, bag_->topics()[message.topic], bytes});
}

// Images of floating-point numbers are in metres, whatever the sensor says.
cv::Mat BagDataset::Metric(const cv::Mat& stored) const {
  return MetricDepth(stored, stored.type() == CV_32FC1 ? 1.0 : sensor_.depth_factor,
                     sensor_.inverse_depth_offset, sensor_.depth_pattern);
}

void BagDataset::RequireOneView(std::size_t frame, const cv::Mat& colour,
                                const cv::Mat& depth) const {
  const auto refuse = [&](const Stream& stream, std::size_t image, const std::string& what) {
    throw IoError(bag_->path(),
                  bag_->NameOf(bag_->messages()[stream.messages[image]]) + " " + what);
  };
  const auto require = [&](const cv::Mat& image, const PinholeCamera& camera, const char* name,
                           const Stream& stream, std::size_t at) {
    if (image.cols == camera.width && image.rows == camera.height) return;
    refuse(stream, at,
           "is " + SizeOf(image) + ", but the " + name + " is set to " +
               std::to_string(camera.width) + " x " + std::to_string(camera.height));
  };
  const auto& [of_colour, of_depth] = frames_[frame];
  if (registration_) {
    require(colour, sensor_.camera, "camera", colour_, of_colour);
    require(depth, sensor_.depth_camera->camera, "depth camera", depth_, of_depth);
    return;
  }
  if (depth.size() != colour.size()) {
    refuse(depth_, of_depth,
           "is " + SizeOf(depth) + ", but its colour image is " + SizeOf(colour) +
               ": record depth aligned to colour, or state its camera as "
               "depth_camera in a file for --config");
  }
  if (!options_.any_size) require(colour, sensor_.camera, "camera", colour_, of_colour);
}

RgbdImage BagDataset::DoLoad(std::size_t index) const {
  RgbdImage image{.stamp = stamp(index),
                  .bgr = ReadColour(index),
                  .depth = {},
                  .depth_stamp = depth_stamp(index)};
  const cv::Mat stored = ReadDepth(index);
  RequireOneView(index, image.bgr, stored);
  if (!imu_ && cv::countNonZero(stored) == 0) {
    throw IoError(bag_->path(),
                  bag_->NameOf(bag_->messages()[depth_.messages[frames_[index].second]]) +
                      " holds no depth: all zero");
  }
  image.depth = Metric(stored);
  if (registration_) image.depth = registration_->Register(image.depth);
  return image;
}

}  // namespace highwall
