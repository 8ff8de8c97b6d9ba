#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/types.hpp>

#include <highwall/frontend/input/image_source.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall::apps {

// A camera that is connected.
struct ConnectedCamera {
  std::string uri;   // for OpenOpenNi2Camera()
  std::string name;  // human-readable: vendor and product
};

// Returns the cameras that OpenNI 2 finds. Throws NoCamera if this build lacks OpenNI 2.
std::vector<ConnectedCamera> ListOpenNi2Cameras();

// Returns the calibration of a camera whose images have this size [px] unless the calibration
// states another.
using CameraCalibrationSource = std::function<SensorCalibration(const cv::Size& usual)>;

// Opens a camera by its URI, the first one if that is empty, or a recording of OpenNI (.oni), which
// is played once at its pace, as a camera. Depth is registered to colour by the device, and images
// are not mirrored; exposure stays as it is. calibration: of the sensor, in the place of the field
// of view that the device states, unless it is empty; its depth factor is that of the device in any
// case. Throws NoCamera if there is none, and IoError for a recording that cannot be read, a camera
// that cannot do what is needed, and a calibration of another size than its images; and as
// calibration() does.
std::unique_ptr<ImageSource> OpenOpenNi2Camera(const std::string& uri,
                                               const CameraCalibrationSource& calibration);

}  // namespace highwall::apps
