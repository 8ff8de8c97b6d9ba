#include <algorithm>
#include <cmath>
#include <cstdint>

#include <fmt/core.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "misuses.h"

namespace highwall::bench {
namespace {

Misuse Factor(double factor) {
  return {"depth factor",
          fmt::format("x {}", factor),
          {SensorFault::kDepthScale},
          false,
          [factor](StatedRecording* stated) { stated->sensor.depth_factor *= factor; }};
}

// A misuse of the stored values alone.
Misuse Stored(std::string fault, std::string strength, std::vector<SensorFault> expected,
              const std::function<void(double factor, cv::Mat* stored)>& change) {
  return {std::move(fault), std::move(strength), std::move(expected), false,
          [change](StatedRecording* stated) {
            stated->change_depth = [change, factor = stated->sensor.depth_factor](
                                       std::size_t, cv::Mat* stored) { change(factor, stored); };
          }};
}

// The scale of the readings is that of the IMU.
Misuse FactorWithImu(double factor) {
  Misuse misuse = Factor(factor);
  misuse.fault = "depth factor beside an IMU";
  misuse.inertial = true;
  return misuse;
}

// 10 of 16 bits.
Misuse CutDepth() {
  return Stored("depth of 10 bits", "cut to 1023",
                {SensorFault::kDepthSaturated, SensorFault::kDepthConstant},
                [](double, cv::Mat* stored) { cv::min(*stored, 1023, *stored); });
}

Misuse ShortDepth(int bits) {
  return Stored("depth of 10 bits", fmt::format("without the lowest {}", bits),
                {SensorFault::kDepthScale}, [bits](double, cv::Mat* stored) {
                  for (std::uint16_t& value : cv::Mat_<std::uint16_t>(*stored)) {
                    value = static_cast<std::uint16_t>(value >> bits);
                  }
                });
}

// axes: as in cv::flip().
Misuse MirroredColour(const char* strength, int axes) {
  return {"mirrored colour",
          strength,
          {SensorFault::kDepthMirrored},
          false,
          [axes](StatedRecording* stated) {
            stated->change_colour = [axes](cv::Mat* bgr) { cv::flip(*bgr, *bgr, axes); };
          }};
}

Misuse ConstantDepth() {
  return Stored("constant depth", "2 m", {SensorFault::kDepthConstant},
                [](double factor, cv::Mat* stored) { stored->setTo(2.0 * factor); });
}

Misuse FrozenDepth() {
  return {"constant depth",
          "of the first image",
          {SensorFault::kDepthConstant, SensorFault::kDepthInconsistent},
          false,
          [](StatedRecording* stated) {
            for (StatedFrame& frame : stated->frames) frame.depth = stated->frames[0].colour;
          }};
}

Misuse SaturatedDepth(std::uint16_t value) {
  return Stored("saturated depth", fmt::format("{}", value), {SensorFault::kDepthSaturated},
                [value](double, cv::Mat* stored) { stored->setTo(value, *stored == 0); });
}

Misuse SwappedBytes() {
  return Stored("swapped bytes", "", {SensorFault::kDepthByteOrder}, [](double, cv::Mat* stored) {
    for (std::uint16_t& value : cv::Mat_<std::uint16_t>(*stored)) {
      value = static_cast<std::uint16_t>(value << 8 | value >> 8);
    }
  });
}

// one_metre: stored value over the depth factor there.
Misuse InverseDepth(double one_metre) {
  return Stored("inverse depth", fmt::format("{} m at 1 m", one_metre),
                {SensorFault::kDepthInverse}, [one_metre](double factor, cv::Mat* stored) {
                  for (std::uint16_t& value : cv::Mat_<std::uint16_t>(*stored)) {
                    if (value == 0) continue;
                    const double inverse = factor / value * factor * one_metre;
                    value = cv::saturate_cast<std::uint16_t>(inverse);
                  }
                });
}

// axes: as in cv::flip().
Misuse Mirrored(const char* strength, int axes) {
  return Stored("mirrored depth", strength, {SensorFault::kDepthMirrored},
                [axes](double, cv::Mat* stored) { cv::flip(*stored, *stored, axes); });
}

// Pixels are those of an image 640 wide.
Misuse Shifted(int pixels) {
  return Stored(
      "shifted depth", fmt::format("{} px", pixels), {SensorFault::kDepthUnregistered},
      [pixels](double, cv::Mat* stored) {
        const int shift = pixels * stored->cols / 640;
        cv::Mat shifted(stored->size(), stored->type(), cv::Scalar(0));
        stored->colRange(0, stored->cols - shift).copyTo(shifted.colRange(shift, stored->cols));
        *stored = shifted;
      });
}

Misuse LateDepth(int frames) {
  return {"late depth",
          fmt::format("{} ms", frames * 100 / 3),
          {SensorFault::kDepthInconsistent, SensorFault::kStamps},
          false,
          [frames](StatedRecording* stated) {
            auto& all = stated->frames;
            const auto lag = static_cast<std::size_t>(frames);
            for (std::size_t i = all.size(); i-- > 0;)
              all[i].depth = all[i - std::min(i, lag)].colour;
          }};
}

Misuse EarlyDepth() {
  return {"early depth",
          "33 ms",
          {SensorFault::kDepthInconsistent, SensorFault::kStamps},
          false,
          [](StatedRecording* stated) {
            auto& all = stated->frames;
            for (std::size_t i = 0; i + 1 < all.size(); ++i) all[i].depth = all[i + 1].colour;
          }};
}

// share: of the field of view of the colour image.
Misuse NarrowDepth(double share) {
  return Stored("narrow depth", fmt::format("{} of the view", share),
                {SensorFault::kDepthUnregistered}, [share](double, cv::Mat* stored) {
                  const cv::Size size = stored->size();
                  const int width = static_cast<int>(std::lround(share * size.width));
                  const int height = static_cast<int>(std::lround(share * size.height));
                  const cv::Rect middle((size.width - width) / 2, (size.height - height) / 2, width,
                                        height);
                  cv::resize((*stored)(middle).clone(), *stored, size, 0, 0, cv::INTER_NEAREST);
                });
}

}  // namespace

std::vector<Misuse> DepthMisuses() {
  return {Factor(5.0),
          Factor(0.2),
          Factor(1.25),
          Factor(10.0),
          Factor(0.1),
          FactorWithImu(10.0),
          FactorWithImu(5.0),
          FactorWithImu(1.25),
          FactorWithImu(0.8),
          FactorWithImu(0.2),
          FactorWithImu(0.1),
          CutDepth(),
          ShortDepth(2),
          ShortDepth(6),
          MirroredColour("left to right", 1),
          MirroredColour("upside down", 0),
          EarlyDepth(),
          ConstantDepth(),
          FrozenDepth(),
          SaturatedDepth(65535),
          SaturatedDepth(8191),
          SwappedBytes(),
          InverseDepth(1.0),
          InverseDepth(0.2),
          InverseDepth(4.0),
          Mirrored("left to right", 1),
          Mirrored("upside down", 0),
          Mirrored("turned by 180 deg", -1),
          Shifted(32),
          Shifted(16),
          Shifted(8),
          LateDepth(3),
          LateDepth(2),
          LateDepth(1),
          NarrowDepth(0.5),
          NarrowDepth(0.7),
          NarrowDepth(0.85)};
}

}  // namespace highwall::bench
