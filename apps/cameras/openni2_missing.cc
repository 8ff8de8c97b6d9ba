// In the place of openni2_camera.cc where OpenNI 2 was missing at build time.
#include "cameras/no_camera.h"
#include "cameras/openni2_camera.h"

namespace highwall::apps {
namespace {

constexpr const char* kMissing =
    "this build knows no camera of OpenNI 2: install libopenni2-dev and build Highwall again";

}  // namespace

std::vector<ConnectedCamera> ListOpenNi2Cameras() {
  throw NoCamera(kMissing);
}

std::unique_ptr<ImageSource> OpenOpenNi2Camera(const std::string&, const CameraCalibrationSource&) {
  throw NoCamera(kMissing);
}

}  // namespace highwall::apps
