#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/factors/imu_buffer.h>

#include "simulate/camera/exposure.h"
#include "simulate/camera/motion_blur.h"
#include "simulate/camera/renderer.h"
#include "simulate/camera/sensor.h"
#include "simulate/camera/stretch.h"
#include "simulate/materials/scene.h"
#include "simulate/motion/camera_path.h"
#include "simulate/motion/imu_simulator.h"
#include "simulate/motion/spline_trajectory.h"

namespace highwall::simulate {

// Covered lens, starting `begin` [s] after the first frame.
struct Blackout {
  double begin = 0.0;     // [s]
  double duration = 2.0;  // [s] > 0
};

// A depth camera beside the colour camera, whose images are not registered to colour.
struct DepthCamera {
  PinholeCamera camera{};
  Pose T_CD{};  // from its frame to that of the colour camera
};

struct SimulationOptions {
  std::uint64_t seed = 1;  // of the scene, the path and the noise
  double duration = 10.0;  // [s] > 0
  double fps = 30.0;       // [Hz] > 0
  double rest = 0.0;       // [s] >= 0; initial stationary time of the camera
  PinholeCamera camera{};  // of colour
  std::optional<DepthCamera> depth_camera{};  // empty: depth is registered to colour
  // Rolling shutters: row v of H is taken (v / H - 0.5) times the read-out [s] after the middle
  // row, which is taken at the stamp in the colour image and depth_delay [s] later in the depth
  // image.
  double readout = 0.0;        // [s] of colour, in [0, 1 / fps]
  double depth_readout = 0.0;  // [s] likewise
  double depth_delay = 0.0;    // [s] finite
  ExposureOptions exposure{};
  SensorOptions sensor{};
  std::vector<Blackout> blackouts{};
  bool traffic = false;  // dynamic objects, in scenes that have traffic
  // (0, 1]: contrast that remains in the stretches of low texture.
  double low_texture_contrast = 1.0;
  ImuSimulationOptions imu{};

  // Throws InvalidArgument naming the field.
  void Validate() const;
};

// Returns the difficult stretches of a sequence in order of their beginning: those of one period
// [s] of the camera path, repeated, and the blackouts, limited to the sequence.
std::vector<Stretch> LayOut(const std::vector<Stretch>& stretches, double period,
                            const SimulationOptions& options);

// Given IMU readings that replace simulated ones, with their biases.
struct GivenReadings {
  std::vector<ImuSample> samples;  // stamps of the camera's clock
  Stamp first_bias = 0;            // [ns] likewise
  double bias_interval = 0.0;      // [s] > 0
  std::vector<ImuBias> biases;     // not empty; interpolated linearly
};

// Dynamic objects at t [s] since the first frame; their vertices have looks.
using MovingScene = std::function<Scene(double t)>;

// Returns the options of the paper's field test, a RealSense D435i outdoors: its intrinsics at 640
// x 480, its noise, depth from 0.3 to 6 m, automatic exposure, one second at rest.
SimulationOptions FieldTestOptions();

// Returns a camera with `scale` times the pixels along each side, and the same view.
PinholeCamera Scaled(PinholeCamera camera, double scale);

// Stamp and pose are those of the middle of the exposure (of the middle row with a rolling
// shutter). Depth is of the same instant unless options specify otherwise: z in the camera frame
// when that row is taken.
struct SimulatedFrame {
  Stamp stamp = 0;      // [ns]
  cv::Mat bgr;          // CV_8UC3
  cv::Mat depth;        // CV_32FC1 [m], 0 = no measurement; as its own camera sees it, if any
  Pose T_WC;            // exact
  Exposure exposure{};  // of the image
};

// A camera that moves through a scene, with a rigidly attached IMU: frames on demand, each a pure
// function of the options and its index. Stamps are of the camera's clock unless stated otherwise;
// the IMU's clock is options().imu.time_offset ahead.
class Simulation {
 public:
  // intensity: of the vibration along the trajectory. stretches: of one period of the trajectory,
  // in its seconds. moving: rendered if options.traffic is set. readings: replace simulated IMU
  // readings. Throws InvalidArgument.
  Simulation(Scene scene, SplineTrajectory trajectory, const SimulationOptions& options,
             VibrationIntensity intensity = {}, const std::vector<Stretch>& stretches = {},
             MovingScene moving = {}, std::optional<GivenReadings> readings = {});

  const SimulationOptions& options() const { return options_; }
  const Scene& scene() const { return renderer_.scene(); }

  // [ns] of frame 0.
  static Stamp FirstStamp();
  // Returns the number of frames: duration times fps, rounded, at least one.
  int size() const;
  // Returns the stamp of frame i of [0, size()); whole microseconds from 1 s onwards.
  Stamp StampOf(int i) const;
  // Returns the true pose at any time.
  Pose T_WC(Stamp stamp) const;
  // Difficult stretches of this sequence in order of their beginning, including blackouts.
  const std::vector<Stretch>& stretches() const { return stretches_; }
  // threads: 0 = one per processor; the frame does not depend on it. Thread-safe. Throws
  // InvalidArgument if there is no frame i.
  SimulatedFrame Render(int i, int threads = 0) const;

  // Returns all readings of the IMU, with stamps of its own clock, from half a second before the
  // first frame until half a second after the last, or the given ones; empty if the IMU is
  // disabled.
  std::vector<ImuSample> ImuSamples() const;
  // Returns the true state of the body B that the IMU is fixed to.
  TrueState StateAt(Stamp stamp) const;

 private:
  // Renders the ideal image whose middle row is taken at t [s] since the first frame, by a camera
  // with the pose T_CV in the frame of the colour camera.
  Rendering RenderScene(const Renderer& renderer, const Pose& T_CV, double t, double readout,
                        int threads) const;
  // Returns the ideal depth image with the cosines, of the frame at t whose colour is `colour`.
  Rendering RenderDepth(const Rendering& colour, double t, int threads) const;
  // Applies the blur of an exposure time [s] to the same image.
  cv::Mat Blur(const Rendering& sharp, double t, double exposure_time, int threads) const;

  SimulationOptions options_;
  Renderer renderer_;
  std::optional<Renderer> depth_renderer_;  // of the depth camera, if there is one
  CameraPath path_;
  VibrationIntensity intensity_;
  std::vector<Stretch> stretches_;
  MovingScene moving_;
  MotionBlur blur_;
  Sensor sensor_;
  std::optional<Sensor> depth_sensor_;  // likewise
  ImuSimulator imu_;
  std::optional<GivenReadings> readings_;
};

}  // namespace highwall::simulate
