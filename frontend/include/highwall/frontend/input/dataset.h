#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/factors/imu_buffer.h>

namespace [[gnu::visibility("default")]] highwall {

// One frame of an RGB-D camera; both images have one size.
struct RgbdImage {
  Stamp stamp = 0;
  cv::Mat bgr;                         // CV_8UC3
  cv::Mat depth;                       // CV_32FC1 [m], 0 where nothing was measured
  std::optional<Stamp> depth_stamp{};  // where depth has another one
};

// Depth [m], CV_32FC1, of the values that a sensor stores (CV_16UC1 or CV_32FC1; 0: none), by
// RgbdSensor::depth_factor, RgbdSensor::inverse_depth_offset and RgbdSensor::depth_pattern:
// 1/z = factor / value - offset - pattern. What would be at infinity or beyond is none. Throws
// InvalidArgument for other images, a factor that is not positive, and an offset or a pattern that
// is not finite.                                                  docs/sensors.md
cv::Mat MetricDepth(const cv::Mat& stored, double depth_factor, double inverse_depth_offset = 0.0,
                    const DepthPattern& pattern = {});

// A recorded RGB-D sequence, frames in the order of their stamps. A frame that cannot be used is
// not fatal: Load() returns nothing and the reason joins problems(). Load() and problems() may be
// called from several threads at once.
class Dataset {
 public:
  // A frame that cannot be used, and why.
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
  // The colour images that are in no frame for lack of a depth image in time, in order.
  virtual std::vector<Stamp> stamps_without_depth() const { return {}; }
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
  // The warning for a ground truth that cannot be read, which images do not need.
  static std::string WithoutGroundTruth(const IoError& error);

 private:
  // Throws IoError if the frame cannot be used.
  virtual RgbdImage DoLoad(std::size_t index) const = 0;

  std::vector<std::string> warnings_;
  mutable std::mutex mutex_;
  mutable std::map<std::size_t, std::string> problems_;
};

// The stamps [ns] of the first and the last frame of a video, begin <= end.
struct VideoSpan {
  Stamp begin = 0, end = 0;
};

// What ReadImu() found in a file.
struct ImuRecording {
  // As the file holds them: not sorted, duplicates and NaN in place, for CheckImu() to find.
  std::vector<ImuSample> samples;
  std::vector<std::int64_t> lines;  // of the file, from 1, one a sample
  std::string warning;              // one line where stamps had to be converted, else empty
};

// The file with the readings of the IMU in the folder of a dataset: imu.csv, imu.txt (ETH3D),
// imu0/data.csv or mav0/imu0/data.csv (EuRoC), the first that is there.
std::optional<std::filesystem::path> FindImuFile(const std::filesystem::path& dataset);

// Lines "stamp, gyroscope x y z [rad/s], accelerometer x y z [m/s^2]", separated by commas, by
// semicolons or by blanks, or any columns of which a heading names these seven (wx or gyro_x, ax or
// acc_x and the like; with # or without); lines that begin with #, empty lines, CRLF and one
// heading are allowed, and so are nan and inf. An empty field is NaN. Whole numbers are stamps in
// nanoseconds, decimal ones in seconds; where that is far from the video, the unit (s, ms, us, ns)
// that is not takes its place, with a warning. Throws IoError "path:line: what; what to do" for a
// line of another form, "path: ..." for a file that cannot be read or holds no reading, and for
// stamps that do not meet the video in any unit: those of another clock. Source of the columns:
// Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 35(10), 2016;
// https://www.eth3d.net/slam_documentation
ImuRecording ReadImu(const std::filesystem::path& path, const VideoSpan& video);

}  // namespace highwall
