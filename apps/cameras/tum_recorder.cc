#include "cameras/tum_recorder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <system_error>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/internal/number_text.h>
#include <highwall/internal/run_profile.h>

#include "images/encode.h"
#include "run/calibration_file.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

// Compression of the images: quick, and none while many wait, since a busy processor is slower than
// a disk.
constexpr int kQuick = 1, kNone = 0;

// Appends by a single call, which neither a signal nor the end of the process cuts.
void Append(const fs::path& file, const std::string& text) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666);
  const auto size = static_cast<ssize_t>(text.size());
  const ssize_t written = descriptor < 0 ? -1 : ::write(descriptor, text.data(), text.size());
  const int error = written < 0 ? errno : ENOSPC;
  // Of a full disk, half a line may remain: a list without it is still valid.
  if (written > 0 && written < size) {
    const off_t end = ::lseek(descriptor, 0, SEEK_END);
    if (end >= written) static_cast<void>(::ftruncate(descriptor, end - written) == 0);
  }
  if (descriptor >= 0) ::close(descriptor);
  if (written != size) {
    throw IoError(file, std::string("cannot be written: ") + std::strerror(error));
  }
}

void WritePng(const fs::path& file, const cv::Mat& image, int compression) {
  const std::vector<std::uint8_t> bytes = EncodePng(image, compression);
  AtomicFile png(file);
  png.stream().write(reinterpret_cast<const char*>(bytes.data()),
                     static_cast<std::streamsize>(bytes.size()));
  png.Commit();
}

void MakeRecordingFolder(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder, error) &&
      !(fs::is_directory(folder, error) && fs::is_empty(folder, error))) {
    throw IoError(folder, "has content already: record to a new folder");
  }
  for (const char* const name : {"rgb", "depth"}) {
    fs::create_directories(folder / name, error);
    if (error) throw IoError(folder / name, "cannot be made: " + error.message());
  }
}

}  // namespace

TumRecorder::TumRecorder(fs::path folder, const SensorCalibration& calibration)
    : folder_(std::move(folder)), sensor_(calibration.sensor) {
  MakeRecordingFolder(folder_);
  WriteConfig(folder_ / "calibration.yaml", calibration);
  Append(folder_ / "depth.txt", "# depth images\n# timestamp filename\n");
  Append(folder_ / "rgb.txt", "# color images\n# timestamp filename\n");
  thread_ = std::thread([this] {
    SetUpThread({"recording"});
    Record();
  });
}

TumRecorder::~TumRecorder() {
  Finish();
}

void TumRecorder::Add(const RgbdImage& image, std::span<const ImuSample> readings) {
  // Its own, so that no thread frees what another reads.
  RgbdImage copy = image;
  copy.bgr = image.bgr.clone();
  copy.depth = image.depth.clone();
  const std::lock_guard lock(mutex_);
  const bool is_taken = waiting_.size() < kMostWaiting && counts_.failure.empty() && !ended_;
  if (!is_taken) ++counts_.missed;
  if (!counts_.failure.empty() || ended_ || (!is_taken && readings.empty())) return;
  if (is_taken) {
    waiting_.push_back({std::move(copy), {readings.begin(), readings.end()}});
  } else {
    std::vector<ImuSample>& last = waiting_.back().readings;
    last.insert(last.end(), readings.begin(), readings.end());
  }
  changed_.notify_all();
}

RecordingCounts TumRecorder::Finish() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  if (thread_.joinable()) thread_.join();
  return counts_;
}

void TumRecorder::Record() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ended_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Entry entry = std::move(waiting_.front());
    waiting_.pop_front();
    const int compression = waiting_.size() < kMostWaiting / 16 ? kQuick : kNone;
    lock.unlock();
    std::string failure;
    try {
      Write(entry, compression);
    } catch (const std::exception& error) {
      failure = error.what();
    }
    lock.lock();
    if (failure.empty()) {
      ++counts_.images;
      counts_.readings += entry.readings.size();
      continue;
    }
    counts_.failure = failure;
    counts_.missed += 1 + waiting_.size();
    waiting_.clear();
  }
}

// An image that a list names is there, and so is its depth; no reading follows a later image.
void TumRecorder::Write(const Entry& entry, int compression) const {
  WriteReadings(entry.readings);
  WriteImage(entry.image, compression);
}

void TumRecorder::WriteImage(const RgbdImage& image, int compression) const {
  const auto line = [](const std::string& stamp, const std::string& file) {
    return stamp + " " + file + "\n";
  };
  const std::string colour_stamp = FormatStamp(image.stamp);
  const std::string depth_stamp = FormatStamp(image.depth_stamp.value_or(image.stamp));
  const std::string colour = "rgb/" + colour_stamp + ".png";
  const std::string depth = "depth/" + depth_stamp + ".png";
  WritePng(folder_ / depth, StoredDepth(image.depth, sensor_), compression);
  WritePng(folder_ / colour, image.bgr, compression);
  Append(folder_ / "depth.txt", line(depth_stamp, depth));
  Append(folder_ / "rgb.txt", line(colour_stamp, colour));
}

void TumRecorder::WriteReadings(const std::vector<ImuSample>& readings) const {
  if (readings.empty()) return;
  const fs::path file = folder_ / "imu.csv";
  std::string text;
  std::error_code error;
  if (!fs::exists(file, error)) text = "#timestamp [ns],wx [rad/s],wy,wz,ax [m/s^2],ay,az\n";
  for (const ImuSample& sample : readings) {
    text += std::to_string(sample.stamp);
    for (int i = 0; i < 3; ++i) text += "," + NumberText(sample.gyroscope(i));
    for (int i = 0; i < 3; ++i) text += "," + NumberText(sample.accelerometer(i));
    text += "\n";
  }
  Append(file, text);
}

cv::Mat StoredDepth(const cv::Mat& depth, const RgbdSensor& sensor) {
  if (sensor.depth_pattern.IsZero() && sensor.inverse_depth_offset == 0.0) {
    cv::Mat stored;
    depth.convertTo(stored, CV_16UC1, sensor.depth_factor);  // rounds
    stored.setTo(0, depth >= (UINT16_MAX + 0.5) / sensor.depth_factor);
    return stored;
  }
  cv::Mat stored(depth.size(), CV_16UC1, cv::Scalar(0));
  for (int v = 0; v < depth.rows; ++v) {
    const auto* const z = depth.ptr<float>(v);
    auto* const values = stored.ptr<std::uint16_t>(v);
    for (int u = 0; u < depth.cols; ++u) {
      if (!(z[u] > 0.0F)) continue;
      const double distortion = sensor.depth_pattern.At(u, v, depth.cols, depth.rows);
      const double inverse =
          1.0 / static_cast<double>(z[u]) + sensor.inverse_depth_offset + distortion;
      const double value = std::round(sensor.depth_factor / inverse);
      if (value > 0.0 && value <= UINT16_MAX) values[u] = static_cast<std::uint16_t>(value);
    }
  }
  return stored;
}

}  // namespace highwall::apps
