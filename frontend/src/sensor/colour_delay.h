#pragma once

#include <deque>
#include <memory>
#include <optional>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/twist.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "features/depth_grid.h"
#include "pose/direct_alignment.h"

namespace highwall {

// Finds by how many images colour is late against depth. In the dark, cameras deliver colour at a
// lower rate than depth and repeat images in between; those that are new are older than their
// stamps, by up to three intervals, until the camera catches up. Each of them is aligned with the
// image before (DirectAligner) by several depth images: with the wrong one, the motion of the depth
// contradicts that of the grey levels.
class ColourDelay {
 public:
  // sensor: range and noise of the depth. grid: must outlive this.
  ColourDelay(const RgbdSensor& sensor, const DepthGrid& grid);

  // Gives the image the depth of the time at which its colour was taken. To be called with every
  // image. repeated: whether the colour repeats that of the image before; then the depth is only
  // remembered. motion: that of the camera at the image before.
  void Apply(bool repeated, const Twist& motion, RgbdImage* image);
  // Takes the features of the image that was given last to Apply(), and did not repeat another.
  void SetReference(std::shared_ptr<const FrameFeatures> features);

  // Returns by how much the colour of the last image that repeated none is older than its stamp.
  Stamp delay() const { return delay_; }

 private:
  // Remembers the depth of an image, if colour was repeated recently; its pixels are copied, since
  // the caller may overwrite them.
  void Remember(const RgbdImage& image);
  // Sum of the logarithms of the errors of grey levels and planes, less for a greater overlap;
  // empty if the images cannot be aligned. T_RC: of the image in the reference, if it is known from
  // an alignment with other depth; returns that of this one, if there is one.
  std::optional<double> Error(const cv::Mat& gray_grid, std::size_t late, const Twist& motion,
                              std::optional<Pose>* T_RC) const;
  // Returns by how many images the colour of this one is late.
  std::size_t Find(const RgbdImage& image, const Twist& motion) const;
  // Returns how far [cells] the motion moves the scene from one depth image to the next.
  double Shift(const Twist& motion) const;
  // Returns the time from the depth image `late` images ago to the newest one.
  Stamp Age(std::size_t late) const;

  const RgbdSensor sensor_;
  const DepthGrid& grid_;
  const DirectAligner aligner_;
  std::deque<RgbdImage> newest_;  // depth alone, the newest one first
  std::shared_ptr<const FrameFeatures> reference_;
  Stamp reference_stamp_ = 0;
  std::size_t late_ = 0;      // [images] of the reference
  std::size_t repeated_ = 0;  // images since the reference
  Stamp repeated_at_ = 0;     // the last one
  Stamp delay_ = 0;
};

}  // namespace highwall
