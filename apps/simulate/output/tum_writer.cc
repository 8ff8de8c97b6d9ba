#include "simulate/output/tum_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iomanip>
#include <limits>
#include <mutex>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

#include "simulate/output/atomic_folder.h"
#include "simulate/output/imu_files.h"
#include "simulate/output/portrait.h"
#include "simulate/parallel_for.h"

namespace highwall::simulate {
namespace {

namespace fs = std::filesystem;

double DepthFactor(const SimulationOptions& options) {
  return options.sensor.noise == SensorNoise::kD435i ? kD435iDepthFactor : kTumDepthFactor;
}

cv::Mat Turned(const cv::Mat& image) {
  cv::Mat turned;
  cv::rotate(image, turned, cv::ROTATE_90_CLOCKWISE);
  return turned;
}

void WriteFrame(const fs::path& folder, const SimulatedFrame& frame, double depth_factor,
                bool portrait) {
  const std::string name = FormatStamp(frame.stamp) + ".png";
  cv::Mat depth;
  frame.depth.convertTo(depth, CV_16UC1, depth_factor);
  WritePng(folder / "rgb" / name, portrait ? Turned(frame.bgr) : frame.bgr);
  WritePng(folder / "depth" / name, portrait ? Turned(depth) : depth);
}

std::string ImageList(const Simulation& simulation, const std::string& kind) {
  std::string list = "# " + kind + " images\n# timestamp filename\n";
  for (int i = 0; i < simulation.size(); ++i) {
    const std::string stamp = FormatStamp(simulation.StampOf(i));
    list += stamp + " " + kind + "/" + stamp + ".png\n";
  }
  return list;
}

// Returns the stamps of all frames, with intermediate ones for at least 100 Hz.
std::vector<Stamp> TruthStamps(const Simulation& simulation) {
  std::vector<Stamp> stamps;
  const int steps = std::max(1, static_cast<int>(std::ceil(100.0 / simulation.options().fps)));
  for (int i = 0; i < simulation.size(); ++i) {
    const Stamp begin = simulation.StampOf(i);
    const Stamp end = simulation.StampOf(i + 1);
    const int count = i + 1 < simulation.size() ? steps : 1;
    for (int k = 0; k < count; ++k) {
      stamps.push_back(begin + (end - begin) * k / steps / 1000 * 1000);
    }
  }
  return stamps;
}

// T_CI: pose of the camera of the images.
std::string GroundTruth(const Simulation& simulation, const std::vector<Stamp>& stamps,
                        const Pose& T_CI) {
  TextWriter out;
  out << "# ground truth, pose of the camera in the world\n# timestamp tx ty tz qx qy qz qw\n"
      << std::fixed << std::setprecision(9);
  for (const Stamp stamp : stamps) {
    out << FormatStamp(stamp);
    const Pose T_WI = simulation.T_WC(stamp) * T_CI;
    for (int j = 0; j < Pose::kSize; ++j) out << ' ' << T_WI.data()[j];
    out << '\n';
  }
  return out.str();
}

// The keys of a camera in its section.
std::string CameraYaml(const PinholeCamera& camera) {
  TextWriter out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "  width: " << camera.width << "\n  height: " << camera.height << "\n  fx: " << camera.fx
      << "\n  fy: " << camera.fy << "\n  cx: " << camera.cx << "\n  cy: " << camera.cy
      << "\n  k1: " << camera.k1 << "\n  k2: " << camera.k2 << "\n  p1: " << camera.p1
      << "\n  p2: " << camera.p2 << "\n  k3: " << camera.k3;
  for (const auto& [key, value] :
       {std::pair{"k4", camera.k4}, {"k5", camera.k5}, {"k6", camera.k6}}) {
    if (value != 0.0) out << "\n  " << key << ": " << value;
  }
  if (camera.lens == LensModel::kEquidistant) out << "\n  lens: equidistant";
  out << "\n";
  return out.str();
}

std::string DepthCameraYaml(const DepthCamera& depth) {
  const Eigen::IOFormat list(Eigen::FullPrecision, Eigen::DontAlignCols, ", ", ", ");
  TextWriter out;
  out << "depth_camera:\n"
      << CameraYaml(depth.camera) << "  T_CD: [" << depth.T_CD.Matrix().format(list) << "]\n";
  return out.str();
}

std::string Calibration(const SimulationOptions& options) {
  const DepthNoise noise = options.sensor.Noise();
  TextWriter out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << "camera:\n"
      << CameraYaml(options.camera)
      << (options.depth_camera ? DepthCameraYaml(*options.depth_camera) : "")
      << "depth_factor: " << DepthFactor(options)
      << "\ndepth_range:\n  min: " << options.sensor.min_depth
      << "\n  max: " << options.sensor.max_depth << "\ndepth_noise:\n  offset: " << noise.offset
      << "\n  quadratic: " << noise.quadratic << "\n  reference: " << noise.reference << "\n";
  return out.str();
}

// What is not in data sheets, as far as it is stated.
std::string ErrorsYaml(const SimulationOptions& options, const TumOptions& stated) {
  const std::string direction = stated.portrait ? "  direction: left\n" : "";
  if (!stated.errors) return stated.portrait ? "colour:\n" + direction : "";
  TextWriter out;
  out << std::setprecision(std::numeric_limits<double>::digits10)
      << "colour:\n  readout: " << options.readout << "\n"
      << direction << "depth:\n  delay: " << options.depth_delay
      << "\n  readout: " << options.depth_readout
      << "\n  inverse_offset: " << options.sensor.InverseDepthOffset() << "\n";
  const DepthPattern pattern = options.sensor.Pattern();
  if (!pattern.IsZero()) {
    const Eigen::IOFormat list(Eigen::StreamPrecision, Eigen::DontAlignCols, ", ", ", ");
    out << "  pattern: [" << pattern.nodes.transpose().format(list) << "]\n";
  }
  return out.str();
}

std::string StretchesCsv(const Simulation& simulation) {
  std::string csv = "#kind,begin [s],end [s]\n";
  const Stamp first = simulation.StampOf(0);
  for (const Stretch& stretch : simulation.stretches()) {
    csv += std::string(ToString(stretch.kind)) + "," +
           FormatStamp(first + FromSeconds(stretch.begin)) + "," +
           FormatStamp(first + FromSeconds(stretch.end)) + "\n";
  }
  return csv;
}

template <typename T>
void Append(const T& value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string SurfacePly(const Mesh& mesh) {
  std::string ply = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                    std::to_string(mesh.vertices.size()) +
                    "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                    std::to_string(mesh.triangles.size()) +
                    "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    for (int i = 0; i < 3; ++i) Append(static_cast<float>(vertex[i]), &ply);
  }
  for (const auto& triangle : mesh.triangles) {
    Append(static_cast<std::uint8_t>(triangle.size()), &ply);
    for (const std::uint32_t index : triangle) Append(static_cast<std::int32_t>(index), &ply);
  }
  return ply;
}

}  // namespace

void WriteTum(const Simulation& simulation, const fs::path& folder,
              const std::function<void(int, int)>& progress, const TumOptions& options) {
  HIGHWALL_REQUIRE(!(options.portrait && options.gps), "TumOptions: portrait excludes gps");
  AtomicFolder output(folder);
  const fs::path& root = output.temporary();
  for (const char* kind : {"rgb", "depth"}) {
    fs::create_directory(root / kind);
    WriteBytes(root / (std::string(kind) + ".txt"), ImageList(simulation, kind));
  }
  const std::vector<Stamp> stamps = TruthStamps(simulation);
  WriteBytes(root / "groundtruth.txt", GroundTruth(simulation, stamps, options.portrait ? PortraitPose() : Pose()));
  const SimulationOptions stated =
      options.portrait ? Portrait(simulation.options()) : simulation.options();
  std::string calibration = Calibration(stated);
  if (simulation.options().imu.enabled) {
    calibration += ImuCalibrationYaml(stated.imu);
    WriteBytes(root / "imu.csv", ImuCsv(simulation.ImuSamples()));
    WriteBytes(root / "groundtruth_state.csv", StateCsv(simulation, stamps));
  }
  if (options.gps) {
    calibration += GpsCalibrationYaml(simulation.options());
    WriteBytes(root / "gps.csv", GpsCsv(simulation, *options.gps));
    WriteBytes(root / "groundtruth_gps.txt", GpsAlignmentText(simulation));
  }
  calibration += ErrorsYaml(simulation.options(), options);
  WriteBytes(root / "calibration.yaml", calibration);
  WriteBytes(root / "stretches.csv", StretchesCsv(simulation));
  WriteBytes(root / "surface.ply", SurfacePly(simulation.scene().mesh));

  // One frame per thread: rendering and PNG compression both keep every processor busy.
  std::mutex progress_mutex;
  int done = 0;
  ParallelFor(simulation.size(), 0, [&](int i) {
    WriteFrame(root, simulation.Render(i, 1), DepthFactor(stated), options.portrait);
    const std::scoped_lock lock(progress_mutex);
    ++done;
    if (progress) progress(done, simulation.size());
  });
  output.Commit();
}

}  // namespace highwall::simulate
