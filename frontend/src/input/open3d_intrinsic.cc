#include "input/open3d_intrinsic.h"

#include <highwall/core/error.h>

#include "input/json_object.h"
#include "input/matrix_text.h"

namespace highwall {

SensorCalibration ReadOpen3dIntrinsic(const std::filesystem::path& path) {
  const JsonObject json = JsonObject::Load(path);
  SensorCalibration calibration;
  calibration.sensor.camera = CameraOfMatrix(path, json.Numbers("intrinsic_matrix", 9));
  calibration.sensor.camera.width = json.Integer("width");
  calibration.sensor.camera.height = json.Integer("height");
  if (calibration.sensor.camera.width < 1 || calibration.sensor.camera.height < 1) {
    throw IoError(path, "width and height must be positive");
  }
  calibration.sensor.depth_factor = json.Has("depth_scale") ? json.Number("depth_scale") : 1000.0;
  return calibration;
}

}  // namespace highwall
