#include "input/orbslam_settings.h"

#include <initializer_list>
#include <string>
#include <vector>

#include "input/foreign_camera.h"

namespace highwall {
namespace {

// Returns the coefficients that the file has, 0 for the others.
std::vector<double> OrbSlamCoefficients(const ForeignMap& file, const std::string& prefix,
                                        std::initializer_list<const char*> names) {
  std::vector<double> values;
  for (const char* const name : names) {
    const std::string key = prefix + name;
    values.push_back(file.Has(key) ? file.Number(key) : 0.0);
  }
  return values;
}

cv::Size OrbSlamImageSize(const ForeignMap& file, const std::string& prefix,
                          const ImageSizeSource& image_size) {
  const bool has_width = file.Has("Camera.width"), has_height = file.Has("Camera.height");
  if (has_width && has_height) {
    return {file.Integer("Camera.width"), file.Integer("Camera.height")};
  }
  if (!has_width && !has_height && image_size) return image_size();
  file.Fail(prefix + "fx",
            "Camera.width and Camera.height are missing: add the size of the images, such as "
            "'Camera.width: 640' and 'Camera.height: 480'");
}

PinholeCamera OrbSlamCamera(const ForeignMap& file, const std::string& prefix,
                            const cv::Size& size) {
  PinholeCamera camera{.width = size.width,
                       .height = size.height,
                       .fx = file.Number(prefix + "fx"),
                       .fy = file.Number(prefix + "fy"),
                       .cx = file.Number(prefix + "cx"),
                       .cy = file.Number(prefix + "cy")};
  const std::string type = file.Has("Camera.type") ? file.Word("Camera.type") : "PinHole";
  if (type == "KannalaBrandt8") {
    SetForeignLens(file, "Camera.type", "equidistant", prefix + "fx",
                   OrbSlamCoefficients(file, prefix, {"k1", "k2", "k3", "k4"}), &camera);
  } else if (type == "PinHole") {
    SetForeignLens(file, "Camera.type", "", prefix + "fx",
                   OrbSlamCoefficients(file, prefix, {"k1", "k2", "p1", "p2", "k3"}), &camera);
  } else if (type != "Rectified") {
    file.Refuse("Camera.type", "PinHole, Rectified or KannalaBrandt8, found '" + type + "'");
  }
  CheckForeignCamera(file, prefix + "fx", camera);
  return camera;
}

void ReadOrbSlamImu(const ForeignMap& file, const std::string& pose_key,
                    SensorCalibration* calibration) {
  ImuCalibration& imu =
      AddForeignImu(ForeignPose(file, pose_key, file.Matrix(pose_key, 16)), calibration);
  if (file.Has("IMU.NoiseGyro") || file.Has("IMU.NoiseAcc")) {
    imu.noise.gyroscope = file.Number("IMU.NoiseGyro");
    imu.noise.accelerometer = file.Number("IMU.NoiseAcc");
    imu.noise.gyroscope_walk = file.Number("IMU.GyroWalk");
    imu.noise.accelerometer_walk = file.Number("IMU.AccWalk");
    MarkStated("imu: noise", calibration);
  }
  if (file.Has("IMU.Frequency")) {
    imu.rate = file.Number("IMU.Frequency");
    MarkStated("imu: rate", calibration);
  }
  CheckForeignImu(file, file.Has("IMU.NoiseGyro") ? "IMU.NoiseGyro" : pose_key, imu);
}

}  // namespace

SensorCalibration ReadOrbSlamSettings(const ForeignMap& file, const ImageSizeSource& image_size) {
  SensorCalibration calibration = StartForeignCalibration("a settings file of ORB-SLAM");
  const std::string prefix = file.Has("Camera1.fx") ? "Camera1." : "Camera.";
  const cv::Size size = OrbSlamImageSize(file, prefix, image_size);
  if (!file.Has("Camera.width")) {
    calibration.format += " (for " + std::to_string(size.width) + " x " +
                          std::to_string(size.height) + ", the size of the images)";
  }
  calibration.sensor.camera = OrbSlamCamera(file, prefix, size);
  for (const char* const key : {"RGBD.DepthMapFactor", "DepthMapFactor"}) {
    if (!file.Has(key)) continue;
    ReadForeignDepthFactor(file, key, &calibration);
    break;
  }
  for (const char* const key : {"IMU.T_b_c1", "Tbc"}) {
    if (!file.Has(key)) continue;
    ReadOrbSlamImu(file, key, &calibration);
    break;
  }
  return calibration;
}

}  // namespace highwall
