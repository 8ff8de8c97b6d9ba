#include "run/gps_input.h"

#include <cmath>
#include <memory>

#include <ceres/loss_function.h>

#include <highwall/factors/position.h>

namespace highwall::apps {

std::optional<GpsFeed> LoadGps(const std::filesystem::path& dataset, const RunConfig& config,
                               bool with_imu) {
  const std::filesystem::path file = dataset / "gps.csv";
  if (!std::filesystem::exists(file)) return std::nullopt;
  GpsFeed feed{ReadGps(file), config.antenna_B, {}};
  if (!config.imu) return feed;
  const Pose T_CB = config.imu->T_BC.Inverse();
  if (with_imu) {
    feed.T_CB = T_CB;
  } else {
    feed.antenna_B = T_CB * config.antenna_B;
  }
  return feed;
}

PoseFactor MakeGpsFactor(const GpsFix& fix, const Eigen::Vector3d& antenna_B,
                         ReferenceFrameId frame) {
  constexpr double kHuber = 3.0;  // [sigma]
  return {{fix.stamp},
          frame,
          std::make_shared<PositionFactor>(fix.p_G, antenna_B,
                                           fix.sigma.cwiseInverse().asDiagonal().toDenseMatrix()),
          std::make_shared<ceres::HuberLoss>(kHuber),
          kGpsSource};
}

GpsSummary SummarizeGps(const GpsFeed& feed, const FactorCounts& counts,
                        const std::optional<Pose>& T_GW, const Trajectory& trajectory) {
  GpsSummary summary{feed.fixes.size(), counts.attached, counts.refused, T_GW, 0.0};
  if (!T_GW) return summary;
  double sum = 0.0;
  std::size_t count = 0;
  for (const GpsFix& fix : feed.fixes) {
    const std::optional<Pose> T_WC = Interpolate(trajectory, fix.stamp);
    if (!T_WC) continue;
    const Eigen::Vector3d l_W = *T_WC * feed.T_CB * feed.antenna_B;
    sum += (*T_GW * l_W - fix.p_G).squaredNorm();
    ++count;
  }
  if (count > 0) summary.rms = std::sqrt(sum / static_cast<double>(count));
  return summary;
}

}  // namespace highwall::apps
