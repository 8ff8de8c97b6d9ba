#include "simulate/camera/simulation.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "simulate/camera/haze.h"

namespace highwall::simulate {
namespace {

constexpr Stamp kFirstStamp = 1'000'000'000;  // [ns] not 0, which some tools treat as "no stamp"
constexpr double kMaxFrames = 1e6;

// Stamp of frame i at `fps` frames per second.
Stamp StampOfFrame(int i, double fps) {
  return kFirstStamp + 1000 * static_cast<Stamp>(std::llround(i * 1e6 / fps));
}

int NumberOfFrames(const SimulationOptions& options) {
  return std::max(1, static_cast<int>(std::lround(options.duration * options.fps)));
}

// Scales the contrast about the mean colour.
void ScaleContrast(double share, cv::Mat* bgr) {
  if (share == 1.0) return;
  const cv::Scalar mean = cv::mean(*bgr);
  *bgr = (*bgr - mean) * share + mean;
}

// Time [s] of row v of an image whose middle row is taken at t.
double TimeOfRow(int v, int height, double t, double readout) {
  return t + (static_cast<double>(v) / height - 0.5) * readout;
}

ImuBias BiasAt(const GivenReadings& readings, Stamp stamp) {
  const auto last = static_cast<double>(readings.biases.size() - 1);
  const double index =
      std::clamp(ToSeconds(stamp - readings.first_bias) / readings.bias_interval, 0.0, last);
  const auto i = static_cast<std::size_t>(index);
  const std::size_t next = std::min(i + 1, readings.biases.size() - 1);
  const double share = index - static_cast<double>(i);
  return readings.biases[i] + share * (readings.biases[next] - readings.biases[i]);
}

}  // namespace

std::vector<Stretch> LayOut(const std::vector<Stretch>& stretches, double period,
                            const SimulationOptions& options) {
  // A start from rest delays the motion on the spline by this time.
  const double delay = -CameraPath::MovingTime(0.0, options.rest);
  std::vector<Stretch> all;
  const auto add = [&](StretchKind kind, double begin, double end) {
    begin = std::max(begin, 0.0);
    end = std::min(end, options.duration);
    if (begin < end) all.push_back({kind, begin, end});
  };
  for (double lap = delay; lap < options.duration && !stretches.empty(); lap += period) {
    for (const Stretch& stretch : stretches) {
      add(stretch.kind, lap + stretch.begin, lap + stretch.end);
    }
  }
  for (const Blackout& blackout : options.blackouts) {
    add(StretchKind::kBlackout, blackout.begin, blackout.begin + blackout.duration);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Stretch& a, const Stretch& b) { return a.begin < b.begin; });
  return all;
}

SimulationOptions FieldTestOptions() {
  SimulationOptions options;
  options.rest = 1.0;
  options.camera.fx = options.camera.fy = 615.0;
  options.exposure.mode = ExposureMode::kAuto;
  options.sensor.noise = SensorNoise::kD435i;
  options.sensor.min_depth = 0.3;
  options.sensor.max_depth = 6.0;
  return options;
}

PinholeCamera Scaled(PinholeCamera camera, double scale) {
  camera.width = static_cast<int>(std::lround(camera.width * scale));
  camera.height = static_cast<int>(std::lround(camera.height * scale));
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx = (camera.cx + 0.5) * scale - 0.5;
  camera.cy = (camera.cy + 0.5) * scale - 0.5;
  return camera;
}

void SimulationOptions::Validate() const {
  HIGHWALL_REQUIRE(std::isfinite(duration) && duration > 0.0,
                   "SimulationOptions::duration must be positive");
  HIGHWALL_REQUIRE(std::isfinite(fps) && fps > 0.0, "SimulationOptions::fps must be positive");
  HIGHWALL_REQUIRE(duration * fps <= kMaxFrames,
                   "SimulationOptions: duration times fps must not exceed a million frames");
  HIGHWALL_REQUIRE(std::isfinite(rest) && rest >= 0.0,
                   "SimulationOptions::rest must not be negative");
  HIGHWALL_REQUIRE(readout >= 0.0 && readout <= 1.0 / fps,
                   "SimulationOptions::readout must lie between 0 and the interval of frames");
  HIGHWALL_REQUIRE(
      depth_readout >= 0.0 && depth_readout <= 1.0 / fps,
      "SimulationOptions::depth_readout must lie between 0 and the interval of frames");
  HIGHWALL_REQUIRE(std::isfinite(depth_delay), "SimulationOptions::depth_delay must be finite");
  for (const Blackout& blackout : blackouts) {
    HIGHWALL_REQUIRE(std::isfinite(blackout.begin), "Blackout::begin must be finite");
    HIGHWALL_REQUIRE(std::isfinite(blackout.duration) && blackout.duration > 0.0,
                     "Blackout::duration must be positive");
  }
  HIGHWALL_REQUIRE(low_texture_contrast > 0.0 && low_texture_contrast <= 1.0,
                   "SimulationOptions::low_texture_contrast must be in (0, 1]");
  camera.Validate();
  if (depth_camera) depth_camera->camera.Validate();
  exposure.Validate();
  sensor.Validate();
  imu.Validate();
}

Simulation::Simulation(Scene scene, SplineTrajectory trajectory, const SimulationOptions& options,
                       VibrationIntensity intensity, const std::vector<Stretch>& stretches,
                       MovingScene moving, std::optional<GivenReadings> readings)
    : options_((options.Validate(), options)),
      renderer_(std::move(scene), options.camera),
      path_(trajectory, options.rest),
      intensity_(std::move(intensity)),
      stretches_(LayOut(stretches, trajectory.period(), options)),
      moving_(options.traffic ? std::move(moving) : MovingScene()),
      blur_(options.camera),
      sensor_(options.sensor, options.camera, options.seed),
      imu_(options.imu, options.seed, kFirstStamp,
           StampOfFrame(NumberOfFrames(options) - 1, options.fps)),
      readings_(std::move(readings)) {
  if (!options_.depth_camera) return;
  const PinholeCamera& camera = options_.depth_camera->camera;
  depth_renderer_.emplace(renderer_.scene(), camera);
  depth_sensor_.emplace(options_.sensor, camera, options_.seed);
}

Stamp Simulation::FirstStamp() {
  return kFirstStamp;
}

int Simulation::size() const {
  return NumberOfFrames(options_);
}

Stamp Simulation::StampOf(int i) const {
  return StampOfFrame(i, options_.fps);
}

Pose Simulation::T_WC(Stamp stamp) const {
  return path_.T_WC(ToSeconds(stamp - kFirstStamp));
}

Rendering Simulation::RenderScene(const Renderer& renderer, const Pose& T_CV, double t,
                                  double readout, int threads) const {
  const PinholeCamera& camera = renderer.camera();
  std::vector<Pose> T_WV_of_row;
  for (int v = 0; v < camera.height; ++v) {
    T_WV_of_row.push_back(path_.T_WC(TimeOfRow(v, camera.height, t, readout)) * T_CV);
  }
  const Rendering still = renderer.Render(T_WV_of_row, threads);
  if (!moving_) return still;
  return Renderer(moving_(t), camera).RenderOver(still, T_WV_of_row, threads);
}

Rendering Simulation::RenderDepth(const Rendering& colour, double t, int threads) const {
  const double middle = t + options_.depth_delay, readout = options_.depth_readout;
  if (depth_renderer_) {
    return RenderScene(*depth_renderer_, options_.depth_camera->T_CD, middle, readout, threads);
  }
  if (options_.depth_delay == 0.0 && readout == options_.readout) return colour;
  return RenderScene(renderer_, Pose(), middle, readout, threads);
}

cv::Mat Simulation::Blur(const Rendering& sharp, double t, double exposure_time,
                         int threads) const {
  const double half = 0.5 * exposure_time;
  std::vector<ExposureMotion> motion_of_row;
  for (int v = 0; v < options_.camera.height; ++v) {
    const double middle = TimeOfRow(v, options_.camera.height, t, options_.readout);
    const Pose T_MW = path_.T_WC(middle).Inverse();
    motion_of_row.push_back({T_MW * path_.T_WC(middle - half), T_MW * path_.T_WC(middle + half)});
  }
  return blur_.Apply(sharp.bgr, sharp.depth, motion_of_row, threads);
}

SimulatedFrame Simulation::Render(int i, int threads) const {
  HIGHWALL_REQUIRE(i >= 0 && i < size(), "Simulation::Render: no frame " + std::to_string(i));
  constexpr double kHazeDensity = 0.5;  // [1/m] in the middle of a dusty stretch
  // Remaining shares of light in deep shadow, and in shade that causes motion blur.
  constexpr double kShadow = 0.05, kShade = 0.4;
  SimulatedFrame frame;
  frame.stamp = StampOf(i);
  frame.T_WC = T_WC(frame.stamp);
  const double t = ToSeconds(frame.stamp - kFirstStamp);
  const PinholeCamera& camera = options_.camera;
  if (Intensity(stretches_, StretchKind::kBlackout, t) > 0.0) {
    frame.bgr = cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar::all(0.0));
    const PinholeCamera& of_depth = (depth_renderer_ ? *depth_renderer_ : renderer_).camera();
    frame.depth = cv::Mat(of_depth.height, of_depth.width, CV_32FC1, cv::Scalar::all(0.0));
    return frame;
  }

  Rendering rendering = RenderScene(renderer_, Pose(), t, options_.readout, threads);
  AddHaze({.density = kHazeDensity * Intensity(stretches_, StretchKind::kDust, t),
           .seed = static_cast<std::uint32_t>(options_.seed)},
          t, &rendering);
  const double texture = Intensity(stretches_, StretchKind::kLowTexture, t);
  ScaleContrast(1.0 - (1.0 - options_.low_texture_contrast) * texture, &rendering.bgr);
  const double light =
      std::min(1.0 - (1.0 - kShadow) * Intensity(stretches_, StretchKind::kLowLight, t),
               1.0 - (1.0 - kShade) * Intensity(stretches_, StretchKind::kBlurred, t));
  if (light < 1.0) rendering.bgr *= light;

  frame.exposure = ChooseExposure(options_.exposure, rendering.bgr);
  Expose(options_.exposure, frame.exposure, &rendering.bgr);
  if (frame.exposure.time > 0.0) {
    rendering.bgr = Blur(rendering, t, frame.exposure.time, threads);
  }
  const Rendering of_depth = RenderDepth(rendering, t, threads);
  if (!depth_sensor_) {
    rendering.depth = of_depth.depth;
    rendering.cosine = of_depth.cosine;
  }
  SensorImages images = sensor_.Observe(rendering, i, threads, frame.exposure.gain);
  if (depth_sensor_) images.depth = depth_sensor_->Observe(of_depth, i, threads).depth;
  frame.bgr = std::move(images.bgr);
  frame.depth = std::move(images.depth);
  return frame;
}

std::vector<ImuSample> Simulation::ImuSamples() const {
  if (!options_.imu.enabled) return {};
  if (!readings_) return imu_.Samples(path_, intensity_);
  std::vector<ImuSample> samples = readings_->samples;
  for (ImuSample& sample : samples) sample.stamp += FromSeconds(options_.imu.time_offset);
  return samples;
}

TrueState Simulation::StateAt(Stamp stamp) const {
  TrueState truth = imu_.StateAt(path_, intensity_, stamp);
  if (readings_) truth.bias = BiasAt(*readings_, stamp);
  return truth;
}

}  // namespace highwall::simulate
