#include "input/kalibr_chain.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <highwall/internal/text_file.h>

#include "input/foreign_camera.h"
#include "input/opencv_storage.h"

namespace highwall {
namespace {

namespace fs = std::filesystem;

PinholeCamera KalibrCamera(const ForeignMap& cam0) {
  if (cam0.Word("camera_model") != "pinhole") {
    cam0.Fail("camera_model", "the camera model '" + cam0.Word("camera_model") +
                                  "' is not known: calibrate with pinhole-radtan or, for a "
                                  "fisheye, pinhole-equi, or undistort the images");
  }
  PinholeCamera camera = ForeignListCamera(cam0);
  const std::string model = cam0.Has("distortion_model") ? cam0.Word("distortion_model") : "none";
  if (model != "none") {
    SetForeignLens(cam0, "distortion_model", model, "distortion_coeffs",
                   cam0.Numbers("distortion_coeffs", 0), &camera);
  }
  CheckForeignCamera(cam0, "intrinsics", camera);
  return camera;
}

// Returns the file of the IMU beside a chain.
std::optional<fs::path> KalibrImuFile(const fs::path& chain) {
  std::vector<fs::path> names;
  const std::string name = chain.filename().string();
  for (const std::string_view part : {"camchain-imucam", "camchain"}) {
    const std::size_t at = name.find(part);
    if (at == std::string::npos) continue;
    names.push_back(std::string(name).replace(at, part.size(), "imu"));
  }
  names.emplace_back("imu.yaml");
  for (const fs::path& imu : names) {
    const fs::path path = chain.parent_path() / imu;
    if (imu != chain.filename() && fs::is_regular_file(path)) return path;
  }
  return std::nullopt;
}

// Reads the IMU that is given to Kalibr, or the first of its result.
void ReadKalibrImu(const fs::path& path, SensorCalibration* calibration) {
  const ForeignMap file = ParseOpencvStorage(path, ReadTextFile(path));
  const ForeignMap imu0 = file.Has("imu0") ? file.Map("imu0") : file;
  ImuCalibration& imu = *calibration->imu;
  imu.noise.gyroscope = imu0.Number("gyroscope_noise_density");
  imu.noise.accelerometer = imu0.Number("accelerometer_noise_density");
  imu.noise.gyroscope_walk = imu0.Number("gyroscope_random_walk");
  imu.noise.accelerometer_walk = imu0.Number("accelerometer_random_walk");
  MarkStated("imu: noise", calibration);
  if (imu0.Has("update_rate")) {
    imu.rate = imu0.Number("update_rate");
    MarkStated("imu: rate", calibration);
  }
  CheckForeignImu(imu0, "gyroscope_noise_density", imu);
}

}  // namespace

SensorCalibration ReadKalibrChain(const ForeignMap& file) {
  const ForeignMap cam0 = file.Map("cam0");
  SensorCalibration calibration = StartForeignCalibration("a camera chain of Kalibr");
  if (file.Has("cam1")) calibration.format += ", of which cam0 is used";
  calibration.sensor.camera = KalibrCamera(cam0);
  if (!cam0.Has("T_cam_imu")) return calibration;
  std::vector<double> T_CB;
  for (const std::vector<double>& row : cam0.Rows("T_cam_imu", 4)) {
    T_CB.insert(T_CB.end(), row.begin(), row.end());
  }
  ImuCalibration& imu = AddForeignImu(ForeignPose(cam0, "T_cam_imu", T_CB).Inverse(), &calibration);
  if (cam0.Has("timeshift_cam_imu")) {
    imu.time_offset = cam0.Number("timeshift_cam_imu");  // t_imu = t_cam + shift, as ours
    MarkStated("imu: time_offset", &calibration);
    CheckForeignImu(cam0, "timeshift_cam_imu", imu);
  }
  if (const std::optional<fs::path> path = KalibrImuFile(file.path())) {
    ReadKalibrImu(*path, &calibration);
    calibration.format += " with " + path->filename().string();
  }
  return calibration;
}

}  // namespace highwall
