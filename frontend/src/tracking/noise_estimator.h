#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include <highwall/frontend/map/map.h>
#include <highwall/frontend/map/measurement_model.h>
#include <highwall/frontend/pose/pose_report.h>

namespace highwall {

// How noisy each kind of residual row is, found out from the residuals of adjusted landmarks
// (docs/noise.md): what is known beforehand of a camera and of corners is never quite right, and
// joint estimates weigh one kind against another. A robust estimate of variance components: the
// median of the squared rows of each kind over the latest keyframes, by their redundancy. Kinds
// that are seldom seen follow those of their group.
class NoiseEstimator {
 public:
  // model: must outlive it.
  explicit NoiseEstimator(const MeasurementModel& model);
  NoiseEstimator(const NoiseEstimator&) = delete;
  NoiseEstimator& operator=(const NoiseEstimator&) = delete;

  // The features with the noise that is known by now.
  std::shared_ptr<const FrameFeatures> Apply(const FrameFeatures& features) const;
  // What keyframes observe, features with the noise of Apply(), as an adjustment has left it.
  void Add(const Map& map, std::span<const KeyFrameId> keyframes);

  const NoiseEstimate& estimate() const { return estimate_; }

 private:
  // Rows of one kind; those of a group were known beforehand by one number.
  struct Kind {
    double* factor;               // in estimate_
    double shared;                // what residuals do not show, as a factor like it
    double log_var = 0.0;         // of what they show
    double weight = 0.0;          // observations, the older the less
    std::vector<double> squared;  // [sigma^2 known beforehand] the rows that were added
  };
  struct Group {
    std::vector<Kind> kinds;
    int dof = 1;  // of each squared row
  };
  enum GroupId { kPointPx, kRefinedPx, kPointDepth, kEdgeDepth, kLinePx, kLineDepth, kGroups };

  // shared: of a kind, by its index.
  template <std::size_t kSize, class Shared>
  void Follow(GroupId group, int dof, std::array<double, kSize>* factors, const Shared& shared);
  bool IsAtEdge(const PointFeature& feature) const;
  std::size_t LengthBand(const LineFeature& feature) const;
  NoiseFactors FactorsOf(const PointFeature& feature) const;
  NoiseFactors FactorsOf(const LineFeature& feature) const;
  void Collect(const PointFeature& feature, const MapPoint& point, const Pose& T_WC);
  void Collect(const LineFeature& feature, const MapLine& line, const Pose& T_WC);
  void Update(Group* group);

  const MeasurementModel& model_;
  NoiseEstimate estimate_;
  std::array<Group, kGroups> groups_;
};

}  // namespace highwall
