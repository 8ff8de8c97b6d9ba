#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>

namespace highwall {

// One frame of an RGB-D camera; both images have one size.
struct RgbdImage {
  Stamp stamp = 0;
  cv::Mat bgr;    // CV_8UC3
  cv::Mat depth;  // CV_32FC1 [m], 0 where nothing was measured
};

// A recorded RGB-D sequence, frames in the order of their stamps. A frame that cannot be used is
// not fatal: Load() returns nothing and the reason joins problems(). Load() and problems() may be
// called from several threads at once.
class Dataset {
 public:
  struct Problem {
    std::size_t frame = 0;
    std::string what;  // names the file
  };

  virtual ~Dataset() = default;
  Dataset(const Dataset&) = delete;
  Dataset& operator=(const Dataset&) = delete;

  virtual std::size_t size() const = 0;
  // index: below size(), as in Load().
  virtual Stamp stamp(std::size_t index) const = 0;
  // T_WC of the reference, null where the dataset has none.
  virtual const Trajectory* groundtruth() const = 0;
  // The readings of an IMU, for ReadImu(); empty where the dataset has none.
  virtual std::optional<std::filesystem::path> imu_file() const { return std::nullopt; }

  std::optional<RgbdImage> Load(std::size_t index) const;
  // The frames that Load() has found unusable so far, by index, each once.
  std::vector<Problem> problems() const;
  // What is odd about the whole dataset and yet no reason to refuse it.
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  Dataset() = default;
  void AddWarning(std::string warning) { warnings_.push_back(std::move(warning)); }

 private:
  // Throws IoError if the frame cannot be used.
  virtual RgbdImage DoLoad(std::size_t index) const = 0;

  std::vector<std::string> warnings_;
  mutable std::mutex mutex_;
  mutable std::map<std::size_t, std::string> problems_;
};

}  // namespace highwall
