#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>
#include <highwall/core/stamp.h>
#include <highwall/frontend/input/dataset.h>
#include <highwall/frontend/features/depth_grid.h>
#include <highwall/frontend/features/line_extractor.h>
#include <highwall/frontend/features/orb_extractor.h>
#include <highwall/frontend/features/orb_matcher.h>
#include <highwall/frontend/features/segment_depth.h>
#include <highwall/frontend/input/sensor.h>

namespace highwall {

class WorkerTeam;

// One point observation: an ORB corner with its depth where the sensor gave one.
struct PointFeature {
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();  // [px] undistorted
  double depth = 0.0;                            // [m] along z; 0 = none
  double depth_sigma = 0.0;                      // [m] standard deviation of depth, > 0 with it
  int octave = 0;                                // pyramid level
  float angle = 0.0f;                            // [deg] intensity-centroid orientation
};

// One line observation: an undistorted segment with its end points in C where depth allowed a fit.
struct LineFeature {
  LineSegment segment;                    // [px] undistorted
  std::optional<SegmentDepth> segment_C;  // [m]
};

// The features of one image, immutable once built; shared by the tracker and by keyframes.
struct FrameFeatures {
  double sharpness = 0.0;  // [grey levels] mean step between neighbouring pixels
  std::vector<PointFeature> points;
  cv::Mat point_descriptors;  // N x 32 CV_8U, a row a point
  FeatureGrid point_grid;
  std::vector<LineFeature> lines;
  cv::Mat line_descriptors;  // M x 32 CV_8U, or empty
  cv::Mat depth_grid;        // DepthGrid::Sample; empty where the features were loaded
};

// The features that are to be kept, one flag each, in the same order. size: of the image.
std::shared_ptr<const FrameFeatures> Select(const FrameFeatures& features,
                                            const std::vector<bool>& points,
                                            const std::vector<bool>& lines, const cv::Size& size);

// What is known of one image.
struct Frame {
  std::int64_t index = 0;  // counted from 0 over the frames fed
  Stamp stamp = 0;
  std::shared_ptr<const FrameFeatures> features;
};

struct FrameBuilderOptions {
  OrbExtractorOptions orb{};
  LineExtractorOptions lines{};
  SegmentDepthOptions segment_depth{};  // its noise and range are taken from the sensor and below
  bool use_points = true;
  bool use_lines = true;
  double min_depth = 0.3;  // [m] > 0; nearer readings are dropped
  double max_depth = 8.0;  // [m] > min_depth; farther readings are dropped
  // Share of the depth spread among a corner's neighbouring pixels that joins its depth noise,
  // >= 0: colour and depth are registered to no better than a pixel or two, so that beside a depth
  // edge the reading may be that of the other side.
  double depth_spread_share = 1.0;
  bool parallel = true;  // points and lines on two threads; the result is the same

  void Validate() const;
};

// Milliseconds spent in one FrameBuilder::Build.
struct FrameBuilderTimes {
  double points = 0.0;
  double lines = 0.0;
};

// Turns an image and its depth into features: extraction, undistortion, depth association.
class FrameBuilder {
 public:
  FrameBuilder(const RgbdSensor& sensor, const FrameBuilderOptions& options);
  ~FrameBuilder();

  // Throws InvalidArgument where the images do not fit the sensor.
  std::shared_ptr<const FrameFeatures> Build(const RgbdImage& image,
                                             FrameBuilderTimes* times = nullptr);

  const DepthGrid& depth_grid() const { return depth_grid_; }

 private:
  void BuildPoints(const cv::Mat& gray, const cv::Mat& depth, FrameFeatures& features) const;
  void BuildLines(const cv::Mat& gray, const cv::Mat& depth, FrameFeatures& features);

  RgbdSensor sensor_;
  FrameBuilderOptions options_;
  OrbExtractor orb_;
  LineExtractor line_extractor_;
  DepthGrid depth_grid_;
  // Not a thread per image: OpenCV keeps what it has laid down for a thread when the thread is
  // gone.
  std::unique_ptr<WorkerTeam> team_;
};

}  // namespace highwall
