#include "input/open3d_intrinsic.h"

#include "input/foreign_camera.h"

namespace highwall {

SensorCalibration ReadOpen3dIntrinsic(const std::filesystem::path& path) {
  SensorCalibration calibration = ReadOpen3dIntrinsic(ForeignMap::LoadJson(path));
  calibration.format.clear();  // beside its recording, whose format has these defaults
  calibration.defaults.clear();
  return calibration;
}

SensorCalibration ReadOpen3dIntrinsic(const ForeignMap& file) {
  SensorCalibration calibration = StartForeignCalibration("a camera intrinsic of Open3D");
  calibration.sensor.camera = ForeignMatrixCamera(
      file, "intrinsic_matrix", file.Numbers("intrinsic_matrix", 9), "width", "height");
  if (file.Has("depth_scale")) ReadForeignDepthFactor(file, "depth_scale", &calibration);
  return calibration;
}

}  // namespace highwall
