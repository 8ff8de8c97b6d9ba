#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_report.h>

namespace highwall {

// Online estimator of the noise of each kind of residual row, from the residuals of adjusted
// landmarks (docs/noise.md). A priori noise models of cameras and corners are never quite right,
// and joint estimates weigh one kind of row against another. A robust estimate of variance
// components: the median of the squared rows of each kind over the latest keyframes, divided by
// their redundancy. Kinds that are rarely observed follow those of their group.
class NoiseEstimator {
 public:
  // model: must outlive it.
  explicit NoiseEstimator(const MeasurementModel& model);
  NoiseEstimator(const NoiseEstimator&) = delete;
  NoiseEstimator& operator=(const NoiseEstimator&) = delete;

  // Returns the features with the current noise estimate.
  std::shared_ptr<const FrameFeatures> Apply(const FrameFeatures& features) const;
  // Adds the observations of keyframes after an adjustment; features with the noise of Apply().
  void Add(const Map& map, std::span<const KeyFrameId> keyframes);

  const NoiseEstimate& estimate() const { return estimate_; }

 private:
  // Rows of one kind; the kinds of a group share one a priori noise parameter.
  struct Kind {
    double* factor;               // in estimate_
    double shared;                // part not visible in residuals, as a factor like it
    double log_var = 0.0;         // of the visible part
    double weight = 0.0;          // observations, with older ones faded out
    std::vector<double> squared;  // [a priori sigma^2] of the rows that were added
  };
  struct Group {
    std::vector<Kind> kinds;
    int dof = 1;  // of each squared row
  };
  enum GroupId {
    kPointPx,
    kLowContrastPx,
    kRefinedPx,
    kPointDepth,
    kEdgeDepth,
    kLinePx,
    kLineDepth,
    kGroups
  };

  // shared: function from the index of a kind to Kind::shared.
  template <std::size_t kSize, class Shared>
  void Follow(GroupId group, int dof, std::array<double, kSize>* factors, const Shared& shared);
  template <class Feature, class Landmark>
  void Collect(const Feature&, const Landmark&, const Pose&) {}
  void Collect(const PointFeature& feature, const MapPoint& point, const Pose& T_WC);
  void Collect(const LineFeature& feature, const MapLine& line, const Pose& T_WC);
  void Update(Group* group);

  const MeasurementModel& model_;
  NoiseEstimate estimate_;
  std::array<Group, kGroups> groups_;
};

}  // namespace highwall
