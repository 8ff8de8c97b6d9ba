#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/factors/depth_pattern.h>
#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/sensor.h>

namespace [[gnu::visibility("default")]] highwall {

// One frame of an RGB-D camera; both images have the same size.
struct RgbdImage {
  Stamp stamp = 0;
  cv::Mat bgr;                         // CV_8UC3
  cv::Mat depth;                       // CV_32FC1 [m], 0 where nothing was measured
  std::optional<Stamp> depth_stamp{};  // where depth has a different one
  // CV_32FC1 of the size of depth, where the sensor states its confidence: the noise of each
  // reading over that of RgbdSensor::depth_noise, > 0 where there is depth; empty: 1.
  cv::Mat noise_factor{};
};

// Returns the depth [m], CV_32FC1, of the stored sensor values (CV_16UC1 or CV_32FC1; 0: none), by
// RgbdSensor::depth_factor, RgbdSensor::inverse_depth_offset and RgbdSensor::depth_pattern:
// 1/z = factor / value - offset - pattern. A depth at infinity or beyond becomes 0. Throws
// InvalidArgument for other images, a factor that is not positive, and an offset or a pattern that
// is not finite. See docs/sensors.md.
cv::Mat MetricDepth(const cv::Mat& stored, double depth_factor, double inverse_depth_offset = 0.0,
                    const DepthPattern& pattern = {});

// The topics of a bag that are read, as ToText() and ReadBagTopics() write them:
// "colour=/a,depth=/b,imu=/c". One that is empty is guessed by name, type and what fits together
// (docs/recordings.md).
struct BagTopics {
  std::string colour{}, depth{};
  std::string imu{};                         // with both sensors; or one topic for each of them,
  std::string gyroscope{}, accelerometer{};  // which are joined at the stamps of the gyroscope

  bool operator==(const BagTopics&) const = default;
};

// Throws InvalidArgument for an unknown name, an empty topic, a name that occurs twice, and for a
// topic of the IMU beside one of its sensors, or of one of these without the other.
BagTopics ReadBagTopics(std::string_view text);
// Names the topics that are not empty.
std::string ToText(const BagTopics& topics);

// Options of the readers of recordings, each of which uses those that apply to its format.
struct DatasetOptions {
  // [s] > 0, between colour and depth of a frame, where each has a stamp of its own
  double max_stamp_difference = 0.02;
  // Whether images may have another size than the camera; otherwise they cannot be used.
  bool any_size = false;
  // [Hz] > 0, of recordings whose frames have no stamps.
  double frame_rate = 30.0;
  BagTopics topics{};  // of bags

  void Validate() const;  // throws InvalidArgument naming the field and its value
};

// The stamps [ns] of the first and the last frame of a video, begin <= end.
struct VideoSpan {
  Stamp begin = 0, end = 0;
};

// Readings of an IMU as they are recorded.
struct ImuRecording {
  // As in the file: not sorted, with duplicates and NaN, for CheckImu() to find.
  std::vector<ImuSample> samples;
  std::vector<std::int64_t> lines;  // of the file, from 1, one per sample; empty: it has no lines
  std::string warning;              // one line if stamps or signs had to be converted, else empty
};

// A recorded RGB-D sequence, frames in the order of their stamps. A frame that cannot be used is
// not fatal: Load() returns nothing and the reason is added to problems(). Load() and problems()
// may be called from several threads at the same time.
class Dataset {
 public:
  // A frame that cannot be used, and the reason.
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
  // Stamp of the depth image, where it has one of its own; else that of the frame.
  virtual Stamp depth_stamp(std::size_t index) const { return stamp(index); }
  // T_WC of the reference trajectory, null where the dataset has none.
  virtual const Trajectory* groundtruth() const = 0;
  // Stamps of the colour images that belong to no frame for lack of a depth image in time, in
  // order.
  virtual std::vector<Stamp> stamps_without_depth() const { return {}; }
  // The file with the readings of an IMU; empty where the dataset has none.
  virtual std::optional<std::filesystem::path> imu_file() const { return std::nullopt; }
  // Returns these readings. video: in their clock. Throws as ReadImu(), which reads the file unless
  // a format has its own way, and InvalidArgument where there is no IMU.
  virtual ImuRecording ReadImu(const VideoSpan& video) const;
  // The topics that are read; all empty unless the recording is a bag.
  virtual BagTopics topics() const { return {}; }

  // Whether the format guarantees that depth is registered to colour; false where it is unknown.
  virtual bool is_registered() const { return false; }

  // Calibration that the recording itself states; null where another source has to.
  virtual const SensorCalibration* calibration() const { return nullptr; }

  std::optional<RgbdImage> Load(std::size_t index) const;
  // The frames that Load() could not use so far, by index, each once.
  std::vector<Problem> problems() const;
  // Peculiarities of the whole dataset that do not prevent its use.
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  Dataset() = default;
  void AddWarning(std::string warning) { warnings_.push_back(std::move(warning)); }
  // Returns the warning for a ground truth that cannot be read; images do not need it.
  static std::string WithoutGroundTruth(const IoError& error);

 private:
  // Throws IoError if the frame cannot be used.
  virtual RgbdImage DoLoad(std::size_t index) const = 0;

  std::vector<std::string> warnings_;
  mutable std::mutex mutex_;
  mutable std::map<std::size_t, std::string> problems_;
};

// Returns the IMU file in the folder of a dataset, the first that exists of imu.csv, imu.txt
// (ETH3D), imu0/data.csv and mav0/imu0/data.csv (EuRoC).
std::optional<std::filesystem::path> FindImuFile(const std::filesystem::path& dataset);

// Reads lines "stamp, gyroscope x y z [rad/s], accelerometer x y z [m/s^2]", separated by commas,
// semicolons or blanks, or any columns of which a heading names these seven (wx or gyro_x, ax or
// acc_x and the like; with # or without); under the heading of Stray Scanner, a_x and alpha_x, the
// accelerometer has the sign of iOS, which is reversed with a warning; lines that begin with #,
// empty lines, CRLF and one heading are allowed, and so are nan and inf. An empty field is NaN.
// Whole numbers are stamps in nanoseconds, decimal ones in seconds; if these are far from the
// video, the unit (s, ms, us, ns) that fits is used instead, with a warning. Throws IoError
// "path:line: what; what to do" for a line of another form, "path: ..." for a file that cannot be
// read or holds no reading, and for stamps that do not overlap the video in any unit: those of
// another clock. Source of the columns: Burri et al., "The EuRoC micro aerial vehicle datasets",
// IJRR 35(10), 2016; https://www.eth3d.net/slam_documentation
ImuRecording ReadImu(const std::filesystem::path& path, const VideoSpan& video);

}  // namespace highwall
