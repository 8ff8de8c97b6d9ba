#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <filesystem>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <highwall/factors/imu_buffer.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// What a TumRecorder has done.
struct RecordingCounts {
  std::size_t images = 0;    // recorded
  std::size_t readings = 0;  // of the IMU, recorded
  std::size_t missed = 0;    // images that were not recorded
  std::string failure;       // why recording ended early; empty: it did not
};

// Records what a camera delivers in the layout of TUM RGB-D, on a thread of its own: rgb/ and
// depth/ as PNG, rgb.txt, depth.txt, calibration.yaml, and imu.csv if there are readings. At every
// moment the folder is a valid recording, also if the process is killed: an image is complete
// before a list names it, and a list grows by whole lines. The stored values of depth are those of
// the sensor, so that the recording gives the same images, pixel by pixel.
class TumRecorder {
 public:
  static constexpr std::size_t kMostWaiting = 64;  // images

  // Creates the folder. calibration: of the images that come. Throws IoError if the folder has
  // content or cannot be written.
  TumRecorder(std::filesystem::path folder, const SensorCalibration& calibration);
  // As Finish().
  ~TumRecorder();
  TumRecorder(const TumRecorder&) = delete;
  TumRecorder& operator=(const TumRecorder&) = delete;

  // Never waits for the disk: an image that comes while very many wait is not recorded, and so are
  // all after a failure; its readings are. The image is copied.
  void Add(const RgbdImage& image, std::span<const ImuSample> readings);
  // Records what waits, and returns the final counts. Call on one thread.
  RecordingCounts Finish();

  const std::filesystem::path& folder() const { return folder_; }

 private:
  struct Entry {
    RgbdImage image;
    std::vector<ImuSample> readings;
  };

  void Record();
  // compression: of EncodePng().
  void Write(const Entry& entry, int compression) const;
  void WriteImage(const RgbdImage& image, int compression) const;
  void WriteReadings(const std::vector<ImuSample>& readings) const;

  const std::filesystem::path folder_;
  const RgbdSensor sensor_;
  std::mutex mutex_;  // of the following
  std::condition_variable changed_;
  std::deque<Entry> waiting_;
  RecordingCounts counts_;
  bool ended_ = false;
  std::thread thread_;  // last: it uses all of the above
};

// Returns the stored values CV_16UC1 of which MetricDepth() makes this depth [m]; 0 for depth that
// 16 bits do not hold.
cv::Mat StoredDepth(const cv::Mat& depth, const RgbdSensor& sensor);

}  // namespace highwall::apps
