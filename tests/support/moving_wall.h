#pragma once

#include <random>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/frontend/input/dataset.h>

namespace highwall::testing {

// Views of a wall of random grey boxes 2 m away, 320 x 240, from a camera that moves to the right
// by 4 px (31 mm at fx = 262) and a thirtieth of a second a frame.
class MovingWall {
 public:
  static RgbdSensor Sensor() {
    RgbdSensor sensor;
    sensor.camera = {
        .width = 320, .height = 240, .fx = 262.0, .fy = 262.0, .cx = 159.5, .cy = 119.5};
    return sensor;
  }

  // frame: 0 to 100.
  RgbdImage View(int frame) const {
    const cv::Size size(320, 240);
    return {.stamp = frame * Stamp{33'333'333},
            .bgr = wall_(cv::Rect({4 * frame, 0}, size)).clone(),
            .depth = cv::Mat(size, CV_32FC1, cv::Scalar(2.0))};
  }

 private:
  static cv::Mat Boxes() {
    cv::Mat wall(240, 720, CV_8UC3, cv::Scalar::all(120));
    std::mt19937 rng(3);
    for (int i = 0; i < 300; ++i) {
      const cv::Rect box(static_cast<int>(rng() % 700), static_cast<int>(rng() % 220),
                         10 + static_cast<int>(rng() % 50), 10 + static_cast<int>(rng() % 50));
      cv::rectangle(wall, box, cv::Scalar::all(static_cast<double>(rng() % 256)), cv::FILLED);
    }
    return wall;
  }

  cv::Mat wall_ = Boxes();
};

}  // namespace highwall::testing
