// SLAM with a RealSense camera while it runs: realsense TRAJECTORY.txt; Enter ends it.
#include <atomic>
#include <cstdio>
#include <thread>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/live_camera.h>
#include <highwall/frontend/system/slam_system.h>
#include <librealsense2/rs.hpp>

class RealSense final : public highwall::ImageSource {
 public:
  RealSense() {
    rs2::config config;
    config.enable_stream(RS2_STREAM_COLOR, 640, 480, RS2_FORMAT_BGR8, 30);
    config.enable_stream(RS2_STREAM_DEPTH, 640, 480, RS2_FORMAT_Z16, 30);
    const rs2::pipeline_profile started = pipeline_.start(config);
    const auto colour = started.get_stream(RS2_STREAM_COLOR).as<rs2::video_stream_profile>();
    const rs2_intrinsics lens = colour.get_intrinsics();
    highwall::RgbdSensor& sensor = calibration_.sensor;
    sensor.camera = {lens.width, lens.height, lens.fx, lens.fy, lens.ppx, lens.ppy};
    sensor.depth_factor = 1.0 / started.get_device().first<rs2::depth_sensor>().get_depth_scale();
    sensor.depth_noise = highwall::DepthNoise::Stereo();
  }
  std::optional<highwall::RgbdImage> Next() override {
    rs2::frameset frames;
    for (int i = 0; !stopped_ && !pipeline_.try_wait_for_frames(&frames, 100); ++i) {
      if (i == 50) throw highwall::IoError("RealSense", "is silent: is it still plugged in?");
    }
    if (stopped_) return std::nullopt;
    frames = align_.process(frames);  // depth to colour
    const rs2::video_frame colour = frames.get_color_frame();
    const cv::Size size(colour.get_width(), colour.get_height());
    const cv::Mat bgr(size, CV_8UC3, const_cast<void*>(colour.get_data()));
    const cv::Mat z(size, CV_16UC1, const_cast<void*>(frames.get_depth_frame().get_data()));
    return highwall::RgbdImage{highwall::FromSeconds(1e-3 * colour.get_timestamp()), bgr.clone(),
                               highwall::MetricDepth(z, calibration_.sensor.depth_factor)};
  }
  void Stop() override { stopped_ = true; }
  const highwall::SensorCalibration* calibration() const override { return &calibration_; }

 private:
  rs2::pipeline pipeline_;
  rs2::align align_{RS2_STREAM_COLOR};
  highwall::SensorCalibration calibration_;
  std::atomic<bool> stopped_ = false;
};

int main(int argc, char** argv) try {
  RealSense device;
  highwall::LiveCamera camera(device);
  highwall::SlamSystem slam(camera.calibration()->sensor, {.mapper = {.wait = false}});
  std::thread([&] { std::getchar(), camera.Stop(); }).detach();
  while (const auto image = camera.Next()) slam.SetBacklog(camera.waiting()), slam.Track(*image);
  slam.Finish();
  highwall::WriteTumTrajectory(argc > 1 ? argv[1] : "trajectory.txt", slam.trajectory());
} catch (const std::exception& error) {
  return std::fprintf(stderr, "realsense: %s\n", error.what()), 3;
}
