#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/point_cloud_io.h>

namespace [[gnu::visibility("default")]] highwall {

// Statistics of distances [m].
struct DistanceStatistics {
  double mean = 0.0;
  double median = 0.0;
  double percentile_90 = 0.0;
  std::size_t count = 0;
};

struct MapComparison {
  struct AtThreshold {
    double threshold = 0.0;  // [m]
    double precision = 0.0;  // share of the map within the threshold of the reference
    double recall = 0.0;     // share of the reference within the threshold of the map
    double f_score = 0.0;    // their harmonic mean
  };

  DistanceStatistics accuracy;      // from the map to the reference
  DistanceStatistics completeness;  // from the reference to the map
  std::vector<AtThreshold> thresholds;
};

// Reference surface for the evaluation of maps: points, or points sampled from triangles, to which
// distances are then exact.
class ReferenceSurface {
 public:
  // points: those that are not finite are dropped. Throws InvalidArgument if none is left.
  explicit ReferenceSurface(std::vector<Eigen::Vector3f> points);
  // Samples the triangles at every `spacing` [m] > 0. Throws InvalidArgument if there is no
  // triangle, or if there would be more than 2^27 samples.
  ReferenceSurface(const TriangleMesh& mesh, double spacing);

  const std::vector<Eigen::Vector3f>& samples() const { return samples_; }
  // Drops the samples for which keep[i] is zero; the surface itself is unchanged. Throws
  // InvalidArgument if no sample is left or `keep` differs in size.
  void KeepSamples(const std::vector<char>& keep);

 private:
  friend MapComparison CompareMaps(std::span<const Eigen::Vector3f>, const ReferenceSurface&,
                                   std::span<const double>);

  // Surface: points, and the triangle of each (empty for a point cloud).
  std::vector<Eigen::Vector3f> points_;
  std::vector<std::uint32_t> triangle_of_point_;
  std::vector<std::array<Eigen::Vector3f, 3>> triangles_;
  std::vector<Eigen::Vector3f> samples_;
};

// Returns the squared distance [m^2] of p to the triangle abc (Ericson, "Real-Time Collision
// Detection", 2005, section 5.1.5).
float SquaredDistanceToTriangle(const Eigen::Vector3f& p,
                                const std::array<Eigen::Vector3f, 3>& abc);

// Marks in `seen` (one entry per point, in W) the points that a depth image observes: those that
// project into it, at a pixel with a measured depth within `tolerance` [m] of theirs. Throws
// InvalidArgument for a depth image of another type or size, or if the numbers of entries differ.
void MarkSeen(std::span<const Eigen::Vector3f> points_W, const DepthView& view,
              const PinholeCamera& camera, double tolerance, std::vector<char>& seen);

// Returns the centres of the occupied voxels, larger leaves being split into voxels of the smallest
// size.
std::vector<Eigen::Vector3f> OccupiedCentres(const OctomapBuilder& map);

// Computes accuracy and completeness of the points of a map, and F-scores at thresholds [m]
// (Knapitsch et al., "Tanks and Temples", SIGGRAPH 2017). Throws InvalidArgument if there is no
// finite point.
MapComparison CompareMaps(std::span<const Eigen::Vector3f> points,
                          const ReferenceSurface& reference,
                          std::span<const double> thresholds = std::array{0.02, 0.05, 0.1});

}  // namespace highwall
