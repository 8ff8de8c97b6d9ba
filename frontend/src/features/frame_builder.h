#pragma once

#include <functional>
#include <memory>

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "features/depth_grid.h"
#include "features/descriptor_bits.h"
#include "features/line_extractor.h"

namespace highwall {

class WorkerTeam;

// Milliseconds spent in one FrameBuilder::Build.
struct FrameBuilderTimes {
  double points = 0.0;
  double lines = 0.0;
};

// Turns an image and its depth into features: extraction, undistortion, depth association.
class FrameBuilder {
 public:
  // points: what finds them; null: what the options say. Throws InvalidArgument on bad options.
  FrameBuilder(const RgbdSensor& sensor, const FrameBuilderOptions& options,
               std::shared_ptr<PointExtractor> points = nullptr);
  ~FrameBuilder();

  // Throws InvalidArgument where the images do not fit the sensor; so does Build(), and where the
  // points are not as PointExtractor says.
  void Check(const RgbdImage& image) const;

  std::shared_ptr<const FrameFeatures> Build(const RgbdImage& image,
                                             FrameBuilderTimes* times = nullptr);
  // What a depth image becomes before it is used, as by DepthAtTime(); nothing: it stays.
  using DepthChange = std::function<cv::Mat(const cv::Mat& depth)>;
  // The same of an image whose depth is changed first, in `image` as well: beside the extraction,
  // which does not wait for it.
  std::shared_ptr<const FrameFeatures> Build(RgbdImage* image, const DepthChange& change,
                                             FrameBuilderTimes* times = nullptr);

  const PinholeCamera& camera() const { return sensor_.camera; }
  const DepthGrid& depth_grid() const { return depth_grid_; }
  const PointKind& point_kind() const { return points_->kind(); }

 private:
  void BuildPoints(ExtractedPoints extracted, const cv::Mat& depth, FrameFeatures& features) const;
  void BuildLines(LineFeatures lines, const cv::Mat& depth, FrameFeatures& features) const;

  RgbdSensor sensor_;
  FrameBuilderOptions options_;
  std::shared_ptr<PointExtractor> points_;
  DescriptorBits descriptor_bits_;
  LineExtractor line_extractor_;
  DepthGrid depth_grid_;
  // Not a thread per image: OpenCV keeps what it has laid down for a thread when the thread is
  // gone.
  std::unique_ptr<WorkerTeam> team_;
};

}  // namespace highwall
