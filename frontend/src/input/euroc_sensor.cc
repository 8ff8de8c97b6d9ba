#include "input/euroc_sensor.h"

#include <filesystem>
#include <string>

#include <highwall/internal/text_file.h>

#include "input/foreign_camera.h"
#include "input/opencv_storage.h"

namespace highwall {

PinholeCamera ReadEurocCamera(const ForeignMap& file) {
  if (const std::string model = file.Word("camera_model"); model != "pinhole") {
    file.Fail("camera_model", "the camera model '" + model +
                                  "' is not known: calibrate a pinhole camera with a "
                                  "radial-tangential or, for a fisheye, an equidistant lens, or "
                                  "undistort the images");
  }
  PinholeCamera camera = ForeignListCamera(file);
  const std::string model = file.Word("distortion_model");
  SetForeignLens(file, "distortion_model", model == "radial-tangential" ? "radtan" : model,
                 "distortion_coefficients", file.Numbers("distortion_coefficients", 4), &camera);
  CheckForeignCamera(file, "intrinsics", camera);
  return camera;
}

Pose ReadEurocPose(const ForeignMap& file) {
  return ForeignPose(file, "T_BS", file.Matrix("T_BS", 16));
}

ImuCalibration ReadEurocImu(const ForeignMap& file, const Pose& T_BC) {
  ImuCalibration imu{.T_BC = ReadEurocPose(file).Inverse() * T_BC};
  const auto read = [&file](const char* key, double* value) {
    if (file.Has(key)) *value = file.Number(key);
  };
  read("gyroscope_noise_density", &imu.noise.gyroscope);
  read("accelerometer_noise_density", &imu.noise.accelerometer);
  read("gyroscope_random_walk", &imu.noise.gyroscope_walk);
  read("accelerometer_random_walk", &imu.noise.accelerometer_walk);
  read("rate_hz", &imu.rate);
  CheckForeignImu(file, file.Has("gyroscope_noise_density") ? "gyroscope_noise_density" : "T_BS",
                  imu);
  return imu;
}

SensorCalibration ReadEurocSensor(const ForeignMap& file) {
  SensorCalibration calibration = StartForeignCalibration("a sensor.yaml of EuRoC");
  calibration.sensor.camera = ReadEurocCamera(file);
  if (!file.Has("T_BS")) return calibration;
  const Pose T_BC = ReadEurocPose(file);
  ImuCalibration& imu = AddForeignImu(T_BC, &calibration);
  const std::filesystem::path path =
      (file.path().parent_path() / ".." / "imu0" / "sensor.yaml").lexically_normal();
  if (!std::filesystem::is_regular_file(path)) return calibration;
  const ForeignMap imu_file = ParseOpencvStorage(path, ReadTextFile(path));
  imu = ReadEurocImu(imu_file, T_BC);
  if (imu_file.Has("gyroscope_noise_density")) MarkStated("imu: noise", &calibration);
  if (imu_file.Has("rate_hz")) MarkStated("imu: rate", &calibration);
  calibration.format += " with imu0/sensor.yaml";
  return calibration;
}

}  // namespace highwall
