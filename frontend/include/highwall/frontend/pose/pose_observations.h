#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <highwall/core/line3.h>
#include <highwall/core/pose.h>
#include <highwall/factors/rgbd_projection.h>
#include <highwall/frontend/features/frame.h>
#include <highwall/frontend/map/landmark.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/options.h>

// Observations of known landmarks by one image, from which SolvePose estimates its pose. Those of
// each kind have
//   kEnds, kEndRows: the number of points of the landmark and of the residual rows of each,
//   End(i), RowsOf(i): point i in W [m] and its rows,
//   dimension: number of rows that can take part,
//   Huber(options): the threshold of their robust cost,
//   RowsAtStart(pixels_first): how many rows take part before the first classification of inliers,
//     where pixels_first means without the depth of points,
//   UsesDepth(used): whether the last row of each end takes part if `used` rows do,
//   InlierRows(r, bounds, pixels_first): how many rows take part where the residuals are r; 0 for
//     an outlier.
namespace [[gnu::visibility("default")]] highwall {

// A known world point and the rows of its observation; rows beyond `dimension` are zero.
struct PosePoint {
  static constexpr int kEnds = 1, kEndRows = 3;

  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();  // [m]
  ProjectionRows<3> rows;
  int dimension = 3;     // 2 or 3
  NoiseFactors noise{};  // of the feature

  const Eigen::Vector3d& End(int) const { return p_W; }
  const ProjectionRows<3>& RowsOf(int) const { return rows; }
  static double Huber(const PoseSolverOptions& options) { return options.point_huber; }
  int RowsAtStart(bool pixels_first) const { return pixels_first ? 2 : dimension; }
  static bool UsesDepth(int used) { return used > 2; }
  // With pixels_first, a point whose depth alone is inconsistent is kept without it.
  int InlierRows(const Eigen::Vector3d& r, const InlierBounds& bounds, bool pixels_first) const;
};

// A known world line and the rows of its observation in the end-point form. The ends lie on the
// line where the observed ends project to it (TrimToObservation), so that the distance is measured
// at the observed ends and not at those of a longer map line.
struct PoseLine {
  static constexpr int kEnds = 2, kEndRows = 2;

  Segment3 segment_W;  // [m]
  std::array<ProjectionRows<2>, 2> rows;
  int dimension = 4;     // 2 or 4
  NoiseFactors noise{};  // of the feature

  Eigen::Vector3d End(int i) const { return i == 0 ? segment_W.p() : segment_W.q(); }
  const ProjectionRows<2>& RowsOf(int i) const { return rows[static_cast<std::size_t>(i)]; }
  static double Huber(const PoseSolverOptions& options) { return options.line_huber; }
  int RowsAtStart(bool) const { return dimension; }
  static bool UsesDepth(int) { return true; }
  int InlierRows(const Eigen::Vector4d& r, const InlierBounds& bounds, bool pixels_first) const;
};

// The form in which SolvePose takes a kind of landmark.
template <class Landmark>
struct PoseTraits;
// Points.
template <>
struct PoseTraits<MapPoint> {
  using Observation = PosePoint;
};
// Lines.
template <>
struct PoseTraits<MapLine> {
  using Observation = PoseLine;
};
// Observations of one kind; PerKind<PoseObservations> are those of an image.
template <class Landmark>
using PoseObservations = std::vector<typename PoseTraits<Landmark>::Observation>;

// Returns a landmark and its feature in the form used by SolvePose.
PosePoint MakePoseObservation(const MeasurementModel& model, const MapPoint& point,
                              const PointFeature& feature);
// The same as for a line; never empty, and T_WC has no effect.
std::optional<PosePoint> MakePoseObservation(const MeasurementModel& model, const MapPoint& point,
                                             const PointFeature& feature, const Pose& T_WC);
// The same for a line. T_WC: rough pose of the camera, which determines the part of the map line
// that the feature observes. Empty if that part is not in front of the camera.
std::optional<PoseLine> MakePoseObservation(const MeasurementModel& model, const MapLine& line,
                                            const LineFeature& feature, const Pose& T_WC);

}  // namespace highwall
