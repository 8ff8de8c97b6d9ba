#include "commands/tum_copy.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <system_error>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>
#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/frame_reader.h>
#include <highwall/internal/number_text.h>

#include "run/calibration_file.h"
#include "simulate/output/atomic_folder.h"

namespace highwall::apps {
namespace {

namespace fs = std::filesystem;

// [stored unit] the largest rounding error of depth by this factor; infinite beyond 16 bits.
double RoundingOf(const cv::Mat& depth, double factor) {
  double largest = 0.0;
  for (int v = 0; v < depth.rows; ++v) {
    const float* const z = depth.ptr<float>(v);
    for (int u = 0; u < depth.cols; ++u) {
      const double value = factor * static_cast<double>(z[u]);
      largest = std::max(largest, std::abs(value - std::round(value)));
      if (value >= UINT16_MAX) return std::numeric_limits<double>::infinity();
    }
  }
  return largest;
}

// Looks at a few frames spread over the recording.
double ChooseDepthFactor(const Dataset& images, double stated) {
  constexpr std::size_t kFrames = 10;
  constexpr double kExact = 0.01;  // a float holds 24 bits of which 16 are stored
  double rounding = 0.0;
  bool fits_tum = true;
  const std::size_t stride = std::max<std::size_t>(1, images.size() / kFrames);
  for (std::size_t i = 0; i < images.size(); i += stride) {
    const std::optional<RgbdImage> image = images.Load(i);
    if (!image) continue;
    rounding = std::max(rounding, RoundingOf(image->depth, stated));
    fits_tum &= std::isfinite(RoundingOf(image->depth, 5000.0));
  }
  if (rounding <= kExact) return stated;
  return fits_tum ? 5000.0 : 1000.0;
}

// Depth beyond 16 bits is left out.
cv::Mat StoredBy(const cv::Mat& depth, double factor) {
  cv::Mat stored;
  depth.convertTo(stored, CV_16UC1, factor);
  stored.setTo(0, stored == UINT16_MAX);
  return stored;
}

std::string ImuText(const ImuRecording& imu) {
  std::string text = "#timestamp [ns],wx [rad/s],wy,wz,ax [m/s^2],ay,az\n";
  for (const ImuSample& sample : imu.samples) {
    text += std::to_string(sample.stamp);
    for (int i = 0; i < 3; ++i) text += "," + NumberText(sample.gyroscope(i));
    for (int i = 0; i < 3; ++i) text += "," + NumberText(sample.accelerometer(i));
    text += "\n";
  }
  return text;
}

// Returns the number of readings. Throws IoError as ReadImu().
std::size_t CopyImu(const Dataset& images, const RunConfig& config, const fs::path& root) {
  if (!images.imu_file()) return 0;
  const Stamp offset = config.imu ? FromSeconds(config.imu->time_offset) : 0;
  const ImuRecording imu =
      images.ReadImu({images.stamp(0) + offset, images.stamp(images.size() - 1) + offset});
  simulate::WriteBytes(root / "imu.csv", ImuText(imu));
  return imu.samples.size();
}

void CopyFrames(const Dataset& images, const fs::path& root,
                const std::function<void(std::size_t, std::size_t)>& progress, TumCopy* copy) {
  std::string rgb = "# color images\n# timestamp filename\n";
  std::string depth = "# depth images\n# timestamp filename\n";
  FrameReader reader(images);
  while (const std::optional<RgbdImage> image = reader.Next()) {
    const std::string colour_stamp = FormatStamp(image->stamp);
    const std::string depth_stamp = FormatStamp(image->depth_stamp.value_or(image->stamp));
    simulate::WritePng(root / "rgb" / (colour_stamp + ".png"), image->bgr);
    simulate::WritePng(root / "depth" / (depth_stamp + ".png"),
                       StoredBy(image->depth, copy->depth_factor));
    rgb += colour_stamp + " rgb/" + colour_stamp + ".png\n";
    depth += depth_stamp + " depth/" + depth_stamp + ".png\n";
    ++copy->frames;
    if (!image->noise_factor.empty()) ++copy->without_confidence;
    progress(reader.position(), reader.count());
  }
  simulate::WriteBytes(root / "rgb.txt", rgb);
  simulate::WriteBytes(root / "depth.txt", depth);
}

}  // namespace

TumCopy CopyAsTum(const OpenedDataset& recording, const fs::path& source, const fs::path& folder,
                  const std::function<void(std::size_t, std::size_t)>& progress) {
  const Dataset& images = *recording.images;
  simulate::AtomicFolder output(folder);
  const fs::path& root = output.temporary();
  fs::create_directory(root / "rgb");
  fs::create_directory(root / "depth");
  TumCopy copy{.depth_factor = ChooseDepthFactor(images, recording.config.sensor.depth_factor)};
  CopyFrames(images, root, progress, &copy);
  if (copy.frames == 0) {
    throw IoError(source, "no frame can be used; the first: " + images.problems().at(0).what);
  }
  if (const Trajectory* const truth = images.groundtruth()) {
    WriteTumTrajectory(root / "groundtruth.txt", *truth);
    copy.poses = truth->size();
  }
  copy.readings = CopyImu(images, recording.config, root);
  if (fs::is_regular_file(source / "gps.csv")) fs::copy_file(source / "gps.csv", root / "gps.csv");
  RunConfig config = recording.config;
  config.sensor.depth_factor = copy.depth_factor;
  config.sensor.inverse_depth_offset = 0.0;
  config.sensor.depth_pattern = {};
  config.sensor.depth_camera.reset();  // its images are registered now
  WriteConfig(root / "calibration.yaml", config);
  output.Commit();
  return copy;
}

}  // namespace highwall::apps
