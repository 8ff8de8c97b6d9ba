#include "cameras/openni2_camera.h"

#include <OpenNI.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>

#include <fmt/core.h>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/image_pairer.h>
#include <highwall/frontend/input/sensor_profile.h>

#include "cameras/device_clock.h"
#include "cameras/no_camera.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kPoll(100);               // between two looks at Stop()
constexpr milliseconds kCameraSilence(5000);     // after which a camera has failed
constexpr milliseconds kRecordingSilence(2500);  // after which a damaged recording has ended
constexpr int kWidth = 640, kHeight = 480;       // [px] unless the calibration has another size
constexpr int kMostFps = 30;
constexpr const char* kNoDevice =
    "OpenNI 2 finds no camera: plug one in; where lsusb lists it, its driver "
    "(/usr/lib/*/OpenNI2/Drivers) or the right to use it (/lib/udev/rules.d/60-libopenni2-0.rules, "
    "then plug it in again) is missing";

std::string Reason() {
  std::string text = openni::OpenNI::getExtendedError();
  for (char& c : text) {
    if (c == '\n' || c == '\t') c = ' ';
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text.empty() ? "OpenNI 2 names no reason" : text;
}

std::string NameOf(openni::SensorType sensor) {
  return sensor == openni::SENSOR_COLOR ? "colour" : "depth";
}

// OpenNI as long as something uses it.
class Session {
 public:
  Session() {
    if (openni::OpenNI::initialize() != openni::STATUS_OK) {
      throw NoCamera("OpenNI 2 cannot start: " + Reason());
    }
  }
  ~Session() { openni::OpenNI::shutdown(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

// OpenNI itself trusts the content of the file.
void RequireRecording(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 4> magic{};
  if (!stream.read(magic.data(), magic.size()) || std::memcmp(magic.data(), "NI10", 4) != 0) {
    throw IoError(file, "is no recording of OpenNI 2 (.oni) that can be read");
  }
}

// Images of a device, paired by their stamps.
class OpenNi2Camera final : public ImageSource {
 public:
  OpenNi2Camera(const std::string& uri, const CameraCalibrationSource& calibration)
      : name_(uri.empty() ? "openni2" : uri), pairer_(DatasetOptions().max_stamp_difference) {
    Open(uri);
    Create(openni::SENSOR_COLOR, &colour_);
    Create(openni::SENSOR_DEPTH, &depth_);
    cv::Size size = UsualSize();
    if (calibration) {
      calibration_ = calibration(size);
      size = {calibration_.sensor.camera.width, calibration_.sensor.camera.height};
    }
    SetMode(openni::PIXEL_FORMAT_RGB888, size, &colour_);
    SetMode(openni::PIXEL_FORMAT_DEPTH_1_MM, size, &depth_);
    Synchronize();
    if (!calibration) calibration_ = StatedCalibration();
    calibration_.imu.reset();  // no such device has one
    calibration_.sensor.depth_factor =
        depth_.getVideoMode().getPixelFormat() == openni::PIXEL_FORMAT_DEPTH_100_UM ? 10'000.0
                                                                                    : 1000.0;
    RequireSizes();
    for (openni::VideoStream* const stream : {&colour_, &depth_}) {
      if (stream->start() != openni::STATUS_OK) throw IoError(name_, "does not start: " + Reason());
    }
    heard_ = steady_clock::now();
  }

  ~OpenNi2Camera() override { Close(); }

  std::optional<RgbdImage> Next() override {
    while (ready_.empty() && !stopped_ && !ended_) Receive();
    if (ready_.empty()) {
      Close();
      return std::nullopt;
    }
    RgbdImage image = std::move(ready_.front());
    ready_.pop_front();
    return image;
  }

  void Stop() override { stopped_ = true; }
  const SensorCalibration* calibration() const override { return &calibration_; }

 private:
  void Open(const std::string& uri);
  void Create(openni::SensorType sensor, openni::VideoStream* stream);
  // Of a recording the size that it has.
  cv::Size UsualSize() const;
  void SetMode(openni::PixelFormat format, const cv::Size& size, openni::VideoStream* stream);
  void Synchronize();
  SensorCalibration StatedCalibration() const;
  void RequireSizes() const;
  void Receive();
  void Take(const openni::VideoFrameRef& frame);
  void Close();

  const std::string name_;
  Session session_;
  openni::Device device_;
  openni::VideoStream colour_, depth_;
  SensorCalibration calibration_;
  ImagePairer pairer_;
  std::optional<DeviceClock> clock_;
  std::deque<RgbdImage> ready_;
  steady_clock::time_point heard_{};                   // the last image
  bool colour_played_ = false, depth_played_ = false;  // of a recording, to the end
  std::atomic<bool> stopped_ = false;
  bool ended_ = false;  // the recording
};

void OpenNi2Camera::Open(const std::string& uri) {
  const bool is_file = fs::path(uri).extension() == ".oni" || fs::is_regular_file(uri);
  if (is_file) RequireRecording(uri);
  if (device_.open(uri.empty() ? openni::ANY_DEVICE : uri.c_str()) == openni::STATUS_OK) return;
  if (is_file) throw IoError(uri, "cannot be played: " + Reason());
  openni::Array<openni::DeviceInfo> connected;
  openni::OpenNI::enumerateDevices(&connected);
  if (connected.getSize() == 0) throw NoCamera(kNoDevice);
  throw NoCamera(fmt::format("{} cannot be opened: {} (highwall live --list names the cameras)",
                             name_, Reason()));
}

// Returns the fastest mode of the format and the size, up to 30 images a second.
const openni::VideoMode* BestMode(const openni::SensorInfo& sensor, openni::PixelFormat format,
                                  const cv::Size& size) {
  const openni::VideoMode* best = nullptr;
  const openni::Array<openni::VideoMode>& modes = sensor.getSupportedVideoModes();
  for (int i = 0; i < modes.getSize(); ++i) {
    const openni::VideoMode& mode = modes[i];
    if (mode.getPixelFormat() != format || mode.getResolutionX() != size.width ||
        mode.getResolutionY() != size.height || mode.getFps() > kMostFps) {
      continue;
    }
    if (best == nullptr || mode.getFps() > best->getFps()) best = &mode;
  }
  return best;
}

void OpenNi2Camera::Create(openni::SensorType sensor, openni::VideoStream* stream) {
  if (device_.hasSensor(sensor) && stream->create(device_, sensor) == openni::STATUS_OK) return;
  throw IoError(name_, fmt::format("has no {} images", NameOf(sensor)));
}

cv::Size OpenNi2Camera::UsualSize() const {
  if (!device_.isFile()) return {kWidth, kHeight};
  const openni::VideoMode mode = colour_.getVideoMode();
  return {mode.getResolutionX(), mode.getResolutionY()};
}

void OpenNi2Camera::SetMode(openni::PixelFormat format, const cv::Size& size,
                            openni::VideoStream* stream) {
  if (device_.isFile()) return;  // which plays as it was recorded
  const openni::VideoMode* const mode = BestMode(stream->getSensorInfo(), format, size);
  if (mode == nullptr || stream->setVideoMode(*mode) != openni::STATUS_OK) {
    throw IoError(name_, fmt::format("has no {} images of {} x {} pixels: give --config of a size "
                                     "that it has",
                                     NameOf(stream->getSensorInfo().getSensorType()), size.width,
                                     size.height));
  }
  stream->setMirroringEnabled(false);  // what cannot mirror does not
}

void OpenNi2Camera::Synchronize() {
  if (device_.isFile()) {
    openni::PlaybackControl* const playback = device_.getPlaybackControl();
    playback->setRepeatEnabled(false);
    playback->setSpeed(1.0F);
    return;
  }
  constexpr auto kRegistered = openni::IMAGE_REGISTRATION_DEPTH_TO_COLOR;
  if (!device_.isImageRegistrationModeSupported(kRegistered) ||
      device_.setImageRegistrationMode(kRegistered) != openni::STATUS_OK) {
    throw IoError(name_, "does not register its depth to its colour images, as Highwall needs it");
  }
  device_.setDepthColorSyncEnabled(true);  // images are paired by their stamps in any case
}

SensorCalibration OpenNi2Camera::StatedCalibration() const {
  const openni::VideoMode mode = colour_.getVideoMode();
  const int width = mode.getResolutionX(), height = mode.getResolutionY();
  const auto focal = [&](int pixels, float field_of_view) {
    if (!(field_of_view > 0.0F && field_of_view < 3.1F)) {
      throw IoError(name_, "states no field of view: give its calibration by --config");
    }
    return 0.5 * pixels / std::tan(0.5 * static_cast<double>(field_of_view));
  };
  const PinholeCamera camera{.width = width,
                             .height = height,
                             .fx = focal(width, colour_.getHorizontalFieldOfView()),
                             .fy = focal(height, colour_.getVerticalFieldOfView()),
                             .cx = 0.5 * (width - 1),
                             .cy = 0.5 * (height - 1)};
  // The noise of all cameras by PrimeSense, and of those built after them.
  return {.sensor = FindSensorProfile("kinect1")->SensorFor(camera)};
}

void OpenNi2Camera::RequireSizes() const {
  const PinholeCamera& camera = calibration_.sensor.camera;
  for (const openni::VideoStream* const stream : {&colour_, &depth_}) {
    const openni::VideoMode mode = stream->getVideoMode();
    if (mode.getResolutionX() == camera.width && mode.getResolutionY() == camera.height) continue;
    throw IoError(name_, fmt::format("has {} images of {} x {} pixels, and the camera {} x {}",
                                     stream == &colour_ ? "colour" : "depth", mode.getResolutionX(),
                                     mode.getResolutionY(), camera.width, camera.height));
  }
  if (calibration_.sensor.depth_camera) {
    throw IoError(name_, "registers depth itself: leave depth_camera out of its calibration");
  }
}

void OpenNi2Camera::Receive() {
  std::array<openni::VideoStream*, 2> streams = {&colour_, &depth_};
  int which = 0;
  const openni::Status status = openni::OpenNI::waitForAnyStream(
      streams.data(), streams.size(), &which, static_cast<int>(kPoll.count()));
  openni::VideoFrameRef frame;
  if (status == openni::STATUS_OK &&
      streams.at(static_cast<std::size_t>(which))->readFrame(&frame) == openni::STATUS_OK) {
    heard_ = steady_clock::now();
    Take(frame);
    return;
  }
  const auto silence = steady_clock::now() - heard_;
  if (device_.isFile()) {
    ended_ = silence > kRecordingSilence;
  } else if (silence > kCameraSilence) {
    throw IoError(name_, "has delivered no image for 5 s: is it still plugged in?");
  }
}

void OpenNi2Camera::Take(const openni::VideoFrameRef& frame) {
  const bool is_colour = frame.getSensorType() == openni::SENSOR_COLOR;
  const int bytes = is_colour ? 3 : 2;
  const openni::PixelFormat format = frame.getVideoMode().getPixelFormat();
  const bool is_known = is_colour ? format == openni::PIXEL_FORMAT_RGB888
                                  : format == openni::PIXEL_FORMAT_DEPTH_1_MM ||
                                        format == openni::PIXEL_FORMAT_DEPTH_100_UM;
  const PinholeCamera& camera = calibration_.sensor.camera;
  if (!is_known || frame.getWidth() != camera.width || frame.getHeight() != camera.height ||
      frame.getStrideInBytes() < bytes * camera.width ||
      frame.getDataSize() < frame.getStrideInBytes() * camera.height) {
    throw IoError(name_, "has images that are neither RGB888 nor depth of the size of the camera");
  }
  if (!clock_) {
    clock_.emplace(std::chrono::duration_cast<std::chrono::nanoseconds>(
                       std::chrono::system_clock::now().time_since_epoch())
                       .count());
  }
  const Stamp stamp = clock_->At(frame.getTimestamp(), heard_);
  // OpenCV does not write to its input.
  const cv::Mat wrapped(camera.height, camera.width, is_colour ? CV_8UC3 : CV_16UC1,
                        const_cast<void*>(frame.getData()),
                        static_cast<std::size_t>(frame.getStrideInBytes()));
  std::vector<RgbdImage> pairs;
  if (is_colour) {
    cv::Mat bgr;
    cv::cvtColor(wrapped, bgr, cv::COLOR_RGB2BGR);
    pairs = pairer_.AddColour(stamp, bgr);
  } else {
    const RgbdSensor& sensor = calibration_.sensor;
    pairs = pairer_.AddDepth(stamp, MetricDepth(wrapped, sensor.depth_factor,
                                                sensor.inverse_depth_offset, sensor.depth_pattern));
  }
  for (RgbdImage& pair : pairs) ready_.push_back(std::move(pair));
  if (!device_.isFile()) return;
  const int last = device_.getPlaybackControl()->getNumberOfFrames(is_colour ? colour_ : depth_);
  (is_colour ? colour_played_ : depth_played_) = frame.getFrameIndex() >= last;
  ended_ = colour_played_ && depth_played_;
}

// Closes a recording at its end too, since its player would keep a processor busy. The player walks
// through the streams without a lock, which must not be destroyed meanwhile: it rests for 10 ms
// between two looks when none of them is started.
void OpenNi2Camera::Close() {
  for (openni::VideoStream* const stream : {&colour_, &depth_}) {
    if (stream->isValid()) stream->stop();
  }
  if (colour_.isValid() && device_.isFile()) std::this_thread::sleep_for(milliseconds(50));
  for (openni::VideoStream* const stream : {&colour_, &depth_}) {
    if (stream->isValid()) stream->destroy();
  }
  device_.close();
  ended_ = true;
}

}  // namespace

std::vector<ConnectedCamera> ListOpenNi2Cameras() {
  const Session session;
  openni::Array<openni::DeviceInfo> connected;
  openni::OpenNI::enumerateDevices(&connected);
  std::vector<ConnectedCamera> cameras;
  for (int i = 0; i < connected.getSize(); ++i) {
    cameras.push_back({connected[i].getUri(),
                       fmt::format("{} {}", connected[i].getVendor(), connected[i].getName())});
  }
  if (cameras.empty()) throw NoCamera(kNoDevice);
  return cameras;
}

std::unique_ptr<ImageSource> OpenOpenNi2Camera(const std::string& uri,
                                               const CameraCalibrationSource& calibration) {
  return std::make_unique<OpenNi2Camera>(uri, calibration);
}

}  // namespace highwall::apps
