#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

class DepthRegistration;

// One line of rgb.txt or depth.txt.
struct TumImageFile {
  Stamp stamp = 0;
  std::filesystem::path path;  // including the folder of the list
};

// Reads a list with "stamp path" per line and returns it sorted by stamp [s]; comments (#), blank
// lines, CRLF, a byte-order mark, UTF-16, back-slashes in paths and a comma or semicolon after the
// stamp are allowed. Adds one line to `warnings` if whole numbers are stamps in another unit, which
// are converted, if lines are not in order, and if a stamp occurs twice, of which the first line is
// kept. Throws IoError naming the line if it is malformed or more than a tenth of the stamps occur
// twice, and if no line is left.
std::vector<TumImageFile> ReadTumImageList(const std::filesystem::path& list,
                                           std::vector<std::string>* warnings = nullptr);

// Returns one-to-one pairs (index in a, index in b), in order, with stamps at most max_difference
// [ns] apart: the closest pair of all first, then the closest of the rest, and so on. Both lists
// must be sorted.
std::vector<std::pair<std::size_t, std::size_t>> AssociateNearest(
    const std::vector<TumImageFile>& a, const std::vector<TumImageFile>& b, Stamp max_difference);

// A folder in the layout of the TUM RGB-D benchmark: rgb.txt and depth.txt (or associations.txt
// instead of both: "stamp path stamp path" per line), the images they name, groundtruth.txt and the
// readings of an IMU (FindImuFile) where they exist. The stamp of a frame is that of its colour
// image. A frame without any depth cannot be used unless there is an IMU, which bridges it.
class TumDataset final : public Dataset {
 public:
  // Returns whether the folder contains one of the lists.
  static bool IsOne(const std::filesystem::path& directory);

  // sensor: converts the stored depth to metres, and its camera has the size of the images. Empty:
  // the depth factor of the benchmark, and any size.
  // Throws InvalidArgument for a bad sensor or bad options, and IoError if a list is missing or
  // malformed, if no colour image has a depth image in time, or if no frame at all can be used.
  // Warns about lists as ReadTumImageList() does, if a quarter of the colour images has no depth in
  // time, if the median depth of a few frames spread over the sequence is implausible, and about a
  // ground truth that cannot be read: the images do not need it.
  explicit TumDataset(const std::filesystem::path& directory,
                      const std::optional<RgbdSensor>& sensor = std::nullopt,
                      const DatasetOptions& options = {});

  std::size_t size() const override { return frames_.size(); }
  Stamp stamp(std::size_t index) const override { return colour_[frames_.at(index).first].stamp; }
  Stamp depth_stamp(std::size_t index) const override {
    return depth_[frames_.at(index).second].stamp;
  }
  const Trajectory* groundtruth() const override { return groundtruth_ ? &*groundtruth_ : nullptr; }

  std::vector<Stamp> stamps_without_depth() const override;
  std::optional<std::filesystem::path> imu_file() const override { return imu_file_; }

  const std::filesystem::path& directory() const { return directory_; }
  const std::vector<TumImageFile>& colour_files() const { return colour_; }
  const std::vector<TumImageFile>& depth_files() const { return depth_; }
  // [m] over the measured pixels of the sampled frames.
  double median_depth() const { return median_depth_; }
  // Whether it is registered as it is read, RgbdSensor::depth_camera.
  bool is_registered() const override { return registration_ != nullptr; }

 private:
  RgbdImage DoLoad(std::size_t index) const override;
  void ReadLists();
  void Pair();
  void ReadGroundTruth();
  void Probe();

  std::filesystem::path directory_;
  RgbdSensor sensor_;
  DatasetOptions options_;
  std::vector<TumImageFile> colour_, depth_;
  std::vector<std::pair<std::size_t, std::size_t>> frames_;  // indices in colour_ and depth_
  std::optional<std::filesystem::path> imu_file_;
  std::optional<Trajectory> groundtruth_;
  double median_depth_ = 0.0;
  std::shared_ptr<const DepthRegistration> registration_;  // null: depth has the pixels of colour
};

// Returns the common depth factor (1000: millimetres; 5000: TUM RGB-D) that makes a median depth
// [m] outside of 0.1 to 20 m plausible, since such a depth indicates a wrong factor; empty if it is
// plausible already, 0 if neither helps.
std::optional<double> LikelyDepthFactor(double median_depth, double depth_factor);

}  // namespace highwall
