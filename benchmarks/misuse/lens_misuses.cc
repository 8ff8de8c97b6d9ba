#include <functional>
#include <utility>

#include <fmt/core.h>

#include <highwall/core/camera.h>

#include "misuses.h"

namespace highwall::bench {
namespace {

Misuse Lens(std::string fault, std::string strength,
            const std::function<void(PinholeCamera*)>& change) {
  return {std::move(fault),
          std::move(strength),
          {SensorFault::kLens},
          false,
          [change](StatedRecording* stated) { change(&stated->sensor.camera); }};
}

Misuse FocalLengths(double factor) {
  return Lens("focal lengths", fmt::format("x {}", factor), [factor](PinholeCamera* camera) {
    camera->fx *= factor;
    camera->fy *= factor;
  });
}

Misuse OneFocalLength(double factor) {
  return Lens("fx alone", fmt::format("x {}", factor),
              [factor](PinholeCamera* camera) { camera->fx *= factor; });
}

// Pixels are those of an image 640 wide.
Misuse PrincipalPoint(double pixels) {
  return Lens("cx", fmt::format("off by {} px", pixels),
              [pixels](PinholeCamera* camera) { camera->cx += pixels * camera->width / 640.0; });
}

Misuse PrincipalRow(double pixels) {
  return Lens("cy", fmt::format("off by {} px", pixels),
              [pixels](PinholeCamera* camera) { camera->cy += pixels * camera->width / 640.0; });
}

Misuse ExchangedCentre() {
  return Lens("cx and cy exchanged", "",
              [](PinholeCamera* camera) { std::swap(camera->cx, camera->cy); });
}

// As if that of another lens had been copied.
Misuse Distortion(double k1) {
  return Lens("distortion", fmt::format("k1 off by {}", k1),
              [k1](PinholeCamera* camera) { camera->k1 += k1; });
}

// Those of the fisheye model, taken for radial and tangential ones.
Misuse OtherModel() {
  return Lens("distortion of another model", "", [](PinholeCamera* camera) {
    camera->k1 += 0.3;
    camera->k2 += -0.1;
    camera->p1 += 0.05;
    camera->p2 += -0.02;
  });
}

}  // namespace

std::vector<Misuse> LensMisuses() {
  return {FocalLengths(2.0),   FocalLengths(0.5),    FocalLengths(1.1),   OneFocalLength(2.0),
          OneFocalLength(0.5), OneFocalLength(1.25), PrincipalPoint(100), PrincipalPoint(50),
          PrincipalPoint(25),  PrincipalRow(100),    PrincipalRow(50),    ExchangedCentre(),
          Distortion(-0.3),    Distortion(-0.15),    Distortion(0.15),    OtherModel()};
}

}  // namespace highwall::bench
