#include "input/foreign_camera.h"

#include <vector>

#include <Eigen/Core>

#include <highwall/core/error.h>

#include "input/lens_coefficients.h"
#include "input/matrix_text.h"

namespace highwall {
namespace {

// Calls validate(), whose errors about the field of a struct become one of the file.
template <class Validate>
void CheckFields(const ForeignMap& file, const std::string& key, const Validate& validate) {
  try {
    validate();
  } catch (const InvalidArgument& error) {  // the file's fault, which IoError reports
    const std::string message = error.what();
    const std::size_t scope = message.substr(0, message.find(' ')).find("::");
    file.Fail(key, scope == std::string::npos ? message : message.substr(scope + 2));
  }
}

}  // namespace

SensorCalibration StartForeignCalibration(const std::string& format) {
  SensorCalibration calibration;
  calibration.sensor.depth_factor = 1000.0;
  calibration.format = format;
  calibration.defaults = {"depth_factor", "depth_range", "depth_noise"};
  return calibration;
}

void MarkStated(const std::string& key, SensorCalibration* calibration) {
  std::erase(calibration->defaults, key);
}

PinholeCamera ForeignMatrixCamera(const ForeignMap& file, const std::string& key,
                                  std::span<const double> numbers, const std::string& width_key,
                                  const std::string& height_key) {
  PinholeCamera camera;
  try {
    camera = CameraOfMatrix(file.path(), numbers);
  } catch (const IoError&) {  // which names no line
    file.Fail(key, "the camera matrix must be fx 0 cx, 0 fy cy, 0 0 1");
  }
  camera.width = file.Integer(width_key);
  camera.height = file.Integer(height_key);
  CheckForeignCamera(file, key, camera);
  return camera;
}

PinholeCamera ForeignListCamera(const ForeignMap& file) {
  const std::vector<double> f = file.Numbers("intrinsics", 4);
  const std::vector<double> size = file.Numbers("resolution", 2);
  constexpr double kLargest = 1 << 20;  // [px]
  for (const double side : size) {
    if (!(side >= 1.0 && side <= kLargest)) file.Refuse("resolution", "the size of the images");
  }
  return {.width = static_cast<int>(size[0]),
          .height = static_cast<int>(size[1]),
          .fx = f[0],
          .fy = f[1],
          .cx = f[2],
          .cy = f[3]};
}

void SetForeignLens(const ForeignMap& file, const std::string& model_key, const std::string& model,
                    const std::string& key, std::span<const double> coefficients,
                    PinholeCamera* camera) {
  if (HasUnknownCoefficients(coefficients)) {
    file.Fail(key, "'" + key +
                       "' has coefficients of a thin prism or a tilted sensor, which are not "
                       "known: calibrate with k1 to k6, p1 and p2, or undistort the images");
  }
  if (!SetLens(model, coefficients, camera)) {
    file.Fail(model_key, "the lens model '" + model +
                             "' is not known: calibrate with a radial-tangential model (radtan, "
                             "plumb_bob) or, for a fisheye, an equidistant one, or undistort the "
                             "images");
  }
  if (camera->lens == LensModel::kEquidistant && coefficients.size() != 4) {
    file.Refuse(key, "the 4 coefficients of an equidistant lens");
  }
}

void CheckForeignCamera(const ForeignMap& file, const std::string& key,
                        const PinholeCamera& camera) {
  CheckFields(file, key, [&] { RgbdSensor{.camera = camera}.Validate(); });
}

void ReadForeignDepthFactor(const ForeignMap& file, const std::string& key,
                            SensorCalibration* calibration) {
  const double factor = file.Number(key);
  if (!(factor > 0.0)) file.Refuse(key, "positive");
  calibration->sensor.depth_factor = factor;
  MarkStated("depth_factor", calibration);
}

Pose ForeignPose(const ForeignMap& file, const std::string& key, std::span<const double> numbers) {
  const std::string demand =
      "the 16 numbers of a rotation and a translation, row by row, which end with 0, 0, 0, 1";
  if (numbers.size() != 16) file.Refuse(key, demand);
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> T(numbers.data());
  if (T.row(3) != Eigen::RowVector4d(0.0, 0.0, 0.0, 1.0)) file.Refuse(key, demand);
  try {
    return Pose::FromMatrix(T);
  } catch (const InvalidArgument&) {
    file.Refuse(key, demand);
  }
}

ImuCalibration& AddForeignImu(const Pose& T_BC, SensorCalibration* calibration) {
  calibration->defaults.insert(calibration->defaults.end(),
                               {"imu: noise", "imu: rate", "imu: time_offset"});
  calibration->imu = ImuCalibration{.T_BC = T_BC};
  return *calibration->imu;
}

void CheckForeignImu(const ForeignMap& file, const std::string& key, const ImuCalibration& imu) {
  CheckFields(file, key, [&] { imu.Validate(); });
}

}  // namespace highwall
