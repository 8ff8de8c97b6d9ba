#include <highwall/frontend/input/tum_dataset.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <tuple>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/image_io.h>
#include <highwall/internal/median.h>
#include <highwall/internal/number_text.h>

#include "input/depth_registration.h"
#include "input/pair_advice.h"
#include "input/recording_folder.h"
#include "input/tum_associations.h"

namespace highwall {
namespace {

std::string FourDigits(double value) {
  return RoundedText(value, 4);
}

std::string Size(const cv::Mat& image) {
  return std::to_string(image.cols) + " x " + std::to_string(image.rows);
}

void RequireSizeOf(const cv::Mat& image, const std::filesystem::path& path,
                   const PinholeCamera& camera, const char* name) {
  if (image.cols == camera.width && image.rows == camera.height) return;
  const bool turned = image.cols == camera.height && image.rows == camera.width;
  throw IoError(path, "is " + Size(image) + ", but the " + name + " is set to " +
                          std::to_string(camera.width) + " x " + std::to_string(camera.height) +
                          (turned ? ": are width and height exchanged?" : ""));
}

// Collects a sample of the measured depths, dense enough for a median.
void CollectDepths(const cv::Mat& depth, std::vector<float>* depths) {
  constexpr int kStep = 8;
  for (int v = 0; v < depth.rows; v += kStep) {
    for (int u = 0; u < depth.cols; u += kStep) {
      if (depth.at<float>(v, u) > 0.0F) depths->push_back(depth.at<float>(v, u));
    }
  }
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> AssociateNearest(
    const std::vector<TumImageFile>& a, const std::vector<TumImageFile>& b, Stamp max_difference) {
  std::vector<std::tuple<Stamp, std::size_t, std::size_t>> candidates;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    while (begin < b.size() && b[begin].stamp < a[i].stamp - max_difference) ++begin;
    for (std::size_t j = begin; j < b.size() && b[j].stamp <= a[i].stamp + max_difference; ++j) {
      candidates.emplace_back(std::abs(a[i].stamp - b[j].stamp), i, j);
    }
  }
  std::sort(candidates.begin(), candidates.end());
  std::vector<bool> a_taken(a.size()), b_taken(b.size());
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (const auto& [difference, i, j] : candidates) {
    if (a_taken[i] || b_taken[j]) continue;
    a_taken[i] = b_taken[j] = true;
    pairs.emplace_back(i, j);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::optional<double> LikelyDepthFactor(double median_depth, double depth_factor) {
  constexpr double kMin = 0.1, kMax = 20.0, kTypical = 2.0;  // [m]
  if (median_depth >= kMin && median_depth <= kMax) return std::nullopt;
  double best = 0.0, best_distance = std::log(kMax / kMin);
  for (const double factor : {1000.0, 5000.0}) {
    const double depth = median_depth * depth_factor / factor;
    const double distance = std::abs(std::log(depth / kTypical));
    if (depth >= kMin && depth <= kMax && distance < best_distance) {
      best = factor;
      best_distance = distance;
    }
  }
  return best;
}

bool TumDataset::IsOne(const std::filesystem::path& directory) {
  std::error_code ignored;
  return std::filesystem::exists(directory / "rgb.txt", ignored) ||
         std::filesystem::exists(directory / "depth.txt", ignored) ||
         FindTumAssociations(directory).has_value();
}

TumDataset::TumDataset(const std::filesystem::path& directory,
                       const std::optional<RgbdSensor>& sensor, const DatasetOptions& options)
    : directory_(directory), sensor_(sensor.value_or(RgbdSensor())), options_(options) {
  sensor_.Validate();
  options_.Validate();
  if (!sensor) options_.any_size = true;
  if (sensor_.depth_camera) {
    registration_ = std::make_shared<DepthRegistration>(sensor_.camera, *sensor_.depth_camera);
  }
  RequireRecordingFolder(directory_);
  ReadLists();
  Pair();
  imu_file_ = FindImuFile(directory_);
  ReadGroundTruth();
  Probe();
}

void TumDataset::ReadLists() {
  std::vector<std::string> warnings;
  const std::filesystem::path rgb = directory_ / "rgb.txt", depth = directory_ / "depth.txt";
  const auto associations = FindTumAssociations(directory_);
  if (associations && !(std::filesystem::exists(rgb) && std::filesystem::exists(depth))) {
    TumAssociations lists = ReadTumAssociations(*associations, &warnings);
    colour_ = std::move(lists.colour);
    depth_ = std::move(lists.depth);
  } else {
    colour_ = ReadTumImageList(rgb, &warnings);
    depth_ = ReadTumImageList(depth, &warnings);
  }
  for (std::string& warning : warnings) AddWarning(std::move(warning));
}

void TumDataset::Pair() {
  frames_ = AssociateNearest(colour_, depth_, FromSeconds(options_.max_stamp_difference));
  const std::string limit = FourDigits(options_.max_stamp_difference) + " s";
  if (frames_.empty()) {
    throw IoError(directory_, "no stamp of rgb.txt has one of depth.txt within " + limit +
                                  AdviceOnPairs(colour_, depth_, frames_));
  }
  const std::size_t alone = colour_.size() - frames_.size();
  if (4 * alone < colour_.size()) return;
  AddWarning(directory_.string() + ": " + std::to_string(alone) + " of " +
             std::to_string(colour_.size()) + " colour images have no depth image within " + limit +
             AdviceOnPairs(colour_, depth_, frames_));
}

std::vector<Stamp> TumDataset::stamps_without_depth() const {
  std::vector<Stamp> stamps;
  auto frame = frames_.begin();
  for (std::size_t i = 0; i < colour_.size(); ++i) {
    const bool paired = frame != frames_.end() && frame->first == i;
    if (paired) {
      ++frame;
    } else {
      stamps.push_back(colour_[i].stamp);
    }
  }
  return stamps;
}

void TumDataset::ReadGroundTruth() {
  const std::filesystem::path path = directory_ / "groundtruth.txt";
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return;
  try {
    Trajectory trajectory = ReadTumTrajectory(path);
    if (trajectory.empty()) throw IoError(path, "holds no pose");
    groundtruth_ = std::move(trajectory);
  } catch (const IoError& broken) {
    AddWarning(WithoutGroundTruth(broken));
  }
}

// Loads a few frames spread over the sequence, and all of them as long as none can be used.
void TumDataset::Probe() {
  constexpr std::size_t kFrames = 5;
  std::vector<float> depths;
  const std::size_t stride = std::max<std::size_t>(1, size() / kFrames);
  const auto look = [&](std::size_t index) {
    if (const std::optional<RgbdImage> image = Load(index)) CollectDepths(image->depth, &depths);
  };
  for (std::size_t i = 0; i < size(); i += stride) look(i);
  for (std::size_t i = 0; i < size() && depths.empty(); ++i) look(i);
  if (depths.empty()) {
    const std::vector<Problem> found = problems();
    throw IoError(directory_, "none of its " + std::to_string(size()) + " frames can be used; " +
                                  (found.empty() ? "no depth image holds any depth"
                                                 : "the first: " + found.front().what));
  }
  median_depth_ = UpperMedian(std::move(depths));
  if (const auto factor = LikelyDepthFactor(median_depth_, sensor_.depth_factor)) {
    AddWarning(directory_.string() + ": the median depth is " + FourDigits(median_depth_) +
               " m with depth factor " + FourDigits(sensor_.depth_factor) +
               (*factor > 0.0 ? "; the factor is likely " + FourDigits(*factor)
                              : "; no usual factor makes it plausible"));
  }
}

RgbdImage TumDataset::DoLoad(std::size_t index) const {
  const TumImageFile& colour = colour_[frames_[index].first];
  const TumImageFile& depth = depth_[frames_[index].second];
  RgbdImage image{.stamp = colour.stamp,
                  .bgr = ReadColourImage(colour.path),
                  .depth = {},
                  .depth_stamp = depth.stamp};
  const cv::Mat raw = ReadDepthImage(depth.path);
  if (registration_) {
    RequireSizeOf(image.bgr, colour.path, sensor_.camera, "camera");
    RequireSizeOf(raw, depth.path, sensor_.depth_camera->camera, "depth camera");
  } else if (raw.size() != image.bgr.size()) {
    throw IoError(depth.path, "is " + Size(raw) + ", but its colour image is " + Size(image.bgr) +
                                  ": register it, or state its camera as depth_camera in "
                                  "calibration.yaml");
  } else if (!options_.any_size) {
    RequireSizeOf(raw, depth.path, sensor_.camera, "camera");
  }
  if (!imu_file_ && cv::countNonZero(raw) == 0) {
    throw IoError(depth.path, "holds no depth: all zero");
  }
  image.depth =
      MetricDepth(raw, sensor_.depth_factor, sensor_.inverse_depth_offset, sensor_.depth_pattern);
  if (registration_) image.depth = registration_->Register(image.depth);
  return image;
}

}  // namespace highwall
