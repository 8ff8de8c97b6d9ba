#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/input/sensor_verdict.h>

namespace [[gnu::visibility("default")]] highwall {

// Returns the stored values, CV_16UC1, of a depth image [m], CV_32FC1: the inverse of MetricDepth()
// with this sensor, saturated at 65535.
cv::Mat StoredDepth(const cv::Mat& depth, const RgbdSensor& sensor);

// Tests by some raw images of a recording whether depth is stored as the calibration says:
// constant, with exchanged bytes, with a value other than 0 where nothing was measured, with
// another depth factor, as inverse depth, mirrored, shifted or delayed against colour. Each test
// speaks only where the images are clear (docs/misconfiguration.md, Depth).
class DepthCheck {
 public:
  explicit DepthCheck(const RgbdSensor& sensor);
  ~DepthCheck();
  DepthCheck(const DepthCheck&) = delete;
  DepthCheck& operator=(const DepthCheck&) = delete;

  // raw: CV_16UC1 as stored, 0 where nothing was measured. bgr: CV_8UC3 of the same size. The best
  // are about eight images, spread over the recording; less than four show nothing. They must not
  // change until Findings() was called. Throws InvalidArgument for other images, and for one of
  // another size than the first.
  void Add(const cv::Mat& raw, const cv::Mat& bgr);
  // Adds a depth image with the colour images around it, bgr: an odd number of at least three in a
  // row, its own in their middle, `interval` [s] > 0 apart. stated: [s] by which depth is later
  // than its colour image as it is known. The best are about eight, beside those of Add(), which
  // may be the same: they tell a shift of depth from a delay. Throws InvalidArgument as Add() does.
  void AddAround(const cv::Mat& raw, const std::vector<cv::Mat>& bgr, double interval,
                 double stated);
  // Returns what is wrong, in the order of the tests.
  std::vector<SensorFinding> Findings() const;
  // Whether the edges of the images fit badly as they are, or better with a flip, a shift or another
  // field of view, so that the images around them may show a delay.
  bool IsUnclear() const;
  // Whether more images may show more: depths are unusual, whose factor more values may contradict,
  // or a flip, a far shift or another field of view is near to the limits of a finding.
  bool MayMoreImagesShow() const;
  // The same of a delay, and more images with those around them. True if there are too few.
  bool MayBeDelayed() const;

 private:
  struct Tests;

  const RgbdSensor sensor_;
  std::unique_ptr<Tests> tests_;
};

// Applies DepthCheck to eight frames of [begin, end) of a recording that was opened with this
// sensor, or to 15 and then 30 where less find nothing and are unclear. Where they are unclear, or
// depth lies elsewhere, colour images before and after show whether it is late. A shift of depth
// against colour is not reported where Dataset::is_registered(), nor in less than a second, which
// shows one view; a delay is not reported in less than two.
std::vector<SensorFinding> CheckDepth(const Dataset& dataset, const RgbdSensor& sensor,
                                      std::size_t begin = 0, std::size_t end = SIZE_MAX);

}  // namespace highwall
