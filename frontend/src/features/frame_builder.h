#pragma once

#include <functional>
#include <memory>

#include <opencv2/core/mat.hpp>

#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/features/line_extractor.h>
#include <highwall/frontend/features/options.h>
#include <highwall/frontend/features/point_extractor.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/input/sensor.h>

#include "features/depth_grid.h"
#include "features/descriptor_bits.h"

namespace highwall {

class RunProfile;
class WorkerTeam;

// Share of the depth spread among a corner's neighbouring pixels that is added to its depth noise:
// colour and depth are registered to no better than a pixel or two, so that next to a depth edge
// the reading may be that of the other side.
inline constexpr double kDepthSpreadShare = 1.0;

// Milliseconds spent in one FrameBuilder::Build.
struct FrameBuilderTimes {
  double points = 0.0;
  double lines = 0.0;
};

// Converts an image and its depth to features: extraction, undistortion, depth association.
class FrameBuilder {
 public:
  // points, lines: the extractors; null: those of the options. parallel: points and lines on two
  // threads; the result is the same. profile: null: none; must outlive the builder. Throws
  // InvalidArgument for bad options.
  FrameBuilder(const RgbdSensor& sensor, const FrameBuilderOptions& options,
               std::shared_ptr<PointExtractor> points = nullptr,
               std::shared_ptr<LineExtractor> lines = nullptr, bool parallel = true,
               double depth_spread_share = kDepthSpreadShare, RunProfile* profile = nullptr);
  ~FrameBuilder();

  // Throws InvalidArgument if the images do not match the sensor; so does Build(), and also if the
  // points or lines are not as their extractor's interface says.
  void Check(const RgbdImage& image) const;

  std::shared_ptr<const FrameFeatures> Build(const RgbdImage& image,
                                             FrameBuilderTimes* times = nullptr);
  // Replaces or corrects the depth of an image before it is used; empty: nothing.
  using DepthChange = std::function<void(RgbdImage* image)>;
  // The same for an image whose depth is changed first, in parallel with the extraction, which does
  // not wait for it. The change must leave the colour as it is.
  std::shared_ptr<const FrameFeatures> Build(RgbdImage* image, const DepthChange& change,
                                             FrameBuilderTimes* times = nullptr);

  const PinholeCamera& camera() const { return sensor_.camera; }
  const DepthGrid& depth_grid() const { return depth_grid_; }
  const FeatureType& feature_type() const { return points_->kind(); }

 private:
  void BuildPoints(ExtractedPoints extracted, const RgbdImage& image,
                   FrameFeatures& features) const;
  void BuildLines(LineFeatures lines, const RgbdImage& image, FrameFeatures& features) const;

  RgbdSensor sensor_;
  FrameBuilderOptions options_;
  double depth_spread_share_;
  std::shared_ptr<PointExtractor> points_;
  DescriptorBits descriptor_bits_;
  bool users_lines_;  // by a user-defined extractor, whose lines are validated
  std::shared_ptr<LineExtractor> lines_;
  DepthGrid depth_grid_;
  RunProfile* profile_;
  // Not a thread per image: OpenCV does not release thread-local data when a thread ends.
  std::unique_ptr<WorkerTeam> team_;
};

}  // namespace highwall
