#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include <highwall/core/abi.h>
#include <highwall/core/stamp.h>

namespace [[gnu::visibility("default")]] highwall {

// A line segment in an image [px]. As extracted, its brighter side lies to the left of the
// direction from s to e as the image is seen (y down), so that the order of the ends is the same in
// every view.
struct LineSegment {
  Eigen::Vector2f s = Eigen::Vector2f::Zero();
  Eigen::Vector2f e = Eigen::Vector2f::Zero();

  float Length() const;
  // Angle of the undirected segment [rad], in [0, pi), from x towards y.
  float Angle() const;
  Eigen::Vector2f Midpoint() const;
};

// A line segment in space, in the camera frame.
struct SegmentDepth {
  Eigen::Vector3d p_C, q_C;   // [m] on the fitted line, behind the segment's ends s and e
  double sigma_p = 0.0;       // [m] standard deviation of p_C.z() from the fit
  double sigma_q = 0.0;       // [m] of q_C.z()
  double inlier_share = 0.0;  // share of the measurements used
  double rms = 0.0;           // [m] depth residuals of the inliers
  bool depth_edge = false;    // the two sides differ: only the nearer one was used
};

// Spatial index of keypoints: finds those around a position without visiting the others.
class FeatureGrid {
 public:
  FeatureGrid() = default;
  // cell_size: [px] > 0, best near the radius of the queries. Keypoints outside of the image are
  // found as well. Throws InvalidArgument for a bad size or a position that is not finite.
  FeatureGrid(const std::vector<cv::KeyPoint>& keypoints, const cv::Size& image_size,
              double cell_size = 20.0);

  // Returns the indices of the keypoints within `radius` [px] of `centre` whose octave lies in
  // [min_octave, max_octave], in an order that depends on the keypoints alone.
  std::vector<int> Query(const Eigen::Vector2d& centre, double radius, int min_octave,
                         int max_octave) const;
  // Writes the same into *indices, whose memory is reused.
  void Query(const Eigen::Vector2d& centre, double radius, int min_octave, int max_octave,
             std::vector<int>* indices) const;

  std::size_t size() const { return entries_.size(); }
  std::size_t MemoryBytes() const {
    return entries_.capacity() * sizeof(Entry) + cell_begin_.capacity() * sizeof(int);
  }

 private:
  struct Entry {
    float x, y;
    int octave, index;
  };

  int Column(double x) const;
  int Row(double y) const;

  double cell_size_ = 1.0;
  int columns_ = 0, rows_ = 0;
  std::vector<int> cell_begin_;  // entries of cell c: [cell_begin_[c], cell_begin_[c + 1])
  std::vector<Entry> entries_;
};

// Standard deviations of an observation as multiples of the prior noise models: of the pixels
// (MeasurementOptions) and of the depth (DepthNoise).
struct NoiseFactors {
  float px = 1.0F;     // > 0
  float depth = 1.0F;  // > 0
};

// One point observation, with its depth where the sensor measured one.
struct PointFeature {
  Eigen::Vector2d uv = Eigen::Vector2d::Zero();     // [px] undistorted
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();  // [px] in the raw image; (0, 0) if loaded
  double depth = 0.0;                               // [m] along z; 0 = none
  double depth_sigma = 0.0;                         // [m] standard deviation of depth, > 0 with it
  int octave = 0;                                   // pyramid level
  float angle = 0.0f;                               // [deg] orientation, [0, 360]; negative: none
  // response below FeatureType::low_contrast_response: the corner may be mere noise
  bool low_contrast = false;
  // position aligned with the first appearance of the landmark instead of detected
  bool refined = false;
  NoiseFactors noise{};           // the newest estimate that it got (docs/noise.md)
  float refined_noise_px = 1.0F;  // likewise, of a corner that CornerRefiner refines
};

// One line observation: an undistorted segment with its end points in C where depth allowed a fit.
struct LineFeature {
  LineSegment segment;                    // [px] undistorted
  std::optional<SegmentDepth> segment_C;  // [m]
  NoiseFactors noise{};                   // the newest estimate that it got (docs/noise.md)
};

// The features of one image, immutable once built; shared by the tracker and the keyframes.
struct FrameFeatures {
  double sharpness = 0.0;   // [grey levels] mean difference between neighbouring pixels
  double brightness = 0.0;  // [grey levels] mean
  std::vector<PointFeature> points;
  cv::Mat point_descriptors;  // N x 32 CV_8U, one row per point
  FeatureGrid point_grid;
  std::vector<LineFeature> lines;
  cv::Mat line_descriptors;  // M x 32 CV_8U, or empty
  cv::Mat depth_grid;        // DepthGrid::Sample; empty where unknown
  cv::Mat gray_grid;         // DepthGrid::Average of the image; empty if the features were loaded
  cv::Mat gray;              // CV_8UC1, the raw image; empty if they were loaded, and in keyframes
};

// Returns the grid of the points for FrameFeatures::point_grid. size: of the image.
FeatureGrid GridOf(const std::vector<PointFeature>& points, const cv::Size& size);

// A flag for each feature of an image.
struct FeatureFlags {
  std::vector<bool> points;
  std::vector<bool> lines;
};

// Returns the features of all kinds whose flag is set, in the same order. size: of the image.
std::shared_ptr<const FrameFeatures> Select(const FrameFeatures& features, const FeatureFlags& kept,
                                            const cv::Size& size);

// One image with its features.
struct Frame {
  std::int64_t index = 0;  // counted from 0 over all frames given
  Stamp stamp = 0;         // of its colour: where that is late, before the stamp of the image
  std::shared_ptr<const FrameFeatures> features;
  double depth_delay = 0.0;  // [s] by which the stamp of its depth image is later
};

}  // namespace highwall
