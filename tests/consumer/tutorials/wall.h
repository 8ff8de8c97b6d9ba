// An image for the programs of the tutorials.
#pragma once

#include <random>

#include <highwall/frontend/input/dataset.h>

// Blocks of random grey, 2 m away.
inline highwall::RgbdImage Wall(highwall::Stamp stamp, const highwall::PinholeCamera& camera) {
  highwall::RgbdImage image{stamp, cv::Mat(camera.height, camera.width, CV_8UC3),
                            cv::Mat(camera.height, camera.width, CV_32FC1, cv::Scalar(2.0))};
  std::mt19937 random(1);
  for (int v = 0; v < camera.height; v += 8) {
    for (int u = 0; u < camera.width; u += 8) {
      image.bgr(cv::Rect(u, v, 8, 8)).setTo(cv::Scalar::all(static_cast<double>(random() % 256)));
    }
  }
  return image;
}
