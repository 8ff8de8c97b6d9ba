#include "map/relative_information.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/Cholesky>

#include <highwall/core/error.h>
#include <highwall/core/so3.h>

namespace highwall {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Landmarks of a kind that stand for all that two keyframes share: a graph has thousands of edges.
constexpr std::size_t kMost = 50;

// Returns the information [1/m^2] of the rows about the position of their landmark, in C; zero
// where it is not in front of the camera.
template <int kRows>
Eigen::Matrix3d InformationOf(const RgbdProjection& projection, const ProjectionRows<kRows>& rows,
                              const Eigen::Vector3d& p_C) {
  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Matrix<double, kRows, 3> J;
  if (!projection.EvaluateInCamera<kRows>(p_C, rows, &r, &J)) return Eigen::Matrix3d::Zero();
  return J.transpose() * J;
}

// Sums what landmarks state about T_RC, of a keyframe C in another R.
class PairInformation {
 public:
  PairInformation(const RgbdProjection& projection, const Pose& T_WR, const Pose& T_WC)
      : projection_(projection),
        T_RW_(T_WR.Inverse()),
        T_CW_(T_WC.Inverse()),
        R_CR_((T_WC.Inverse() * T_WR).R()) {}

  // A point p_W that both observe.
  template <int kRows>
  void Add(const Eigen::Vector3d& p_W, const ProjectionRows<kRows>& in_R,
           const ProjectionRows<kRows>& in_C) {
    const Eigen::Vector3d p_C = T_CW_ * p_W;
    const Eigen::Matrix3d of_R =
        R_CR_ * InformationOf(projection_, in_R, T_RW_ * p_W) * R_CR_.transpose();
    Eigen::Matrix3d sum = of_R + InformationOf(projection_, in_C, p_C);
    if (!(sum.trace() > 0.0)) return;
    // Directions that neither observes, as along a line, stay out of it.
    constexpr double kRounding = 1e-9;
    sum.diagonal().array() += kRounding * sum.trace();
    const Eigen::Matrix3d both = of_R - of_R * sum.llt().solve(of_R);
    Eigen::Matrix<double, 3, 6> J;  // of p_C by the pose
    J << -Eigen::Matrix3d::Identity(), so3::Hat(p_C);
    information_ += J.transpose() * both * J;
  }

  const Matrix6& information() const { return information_; }

 private:
  const RgbdProjection& projection_;
  const Pose T_RW_, T_CW_;
  const Eigen::Matrix3d R_CR_;
  Matrix6 information_ = Matrix6::Zero();
};

void Add(const MeasurementModel& model, const MapPoint& point, const PointFeature& in_R,
         const PointFeature& in_C, PairInformation* pair) {
  pair->Add<3>(point.p_W, model.Rows(in_R), model.Rows(in_C));
}

// Both images observe the line across its direction, at whatever ends.
void Add(const MeasurementModel& model, const MapLine& line, const LineFeature& in_R,
         const LineFeature& in_C, PairInformation* pair) {
  const auto of_R = model.Rows(in_R), of_C = model.Rows(in_C);
  pair->Add<2>(line.segment_W.p(), of_R[0], of_C[0]);
  pair->Add<2>(line.segment_W.q(), of_R[1], of_C[1]);
}

// A landmark that both observe, and the features.
template <class Landmark>
struct Shared {
  const Landmark* landmark = nullptr;
  std::size_t in_R = 0, in_C = 0;
};

template <class Landmark>
std::vector<Shared<Landmark>> SharedBy(const Map& map, KeyFrameId reference, const KeyFrame& C) {
  std::vector<Shared<Landmark>> shared;
  const auto& ids = PartOf<Landmark>(C);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] == kNoId) continue;
    const Landmark* landmark = map.Find(ids[i]);
    const auto in_R = std::ranges::find(landmark->observations, reference, &Observation::keyframe);
    if (in_R == landmark->observations.end()) continue;
    shared.push_back({landmark, static_cast<std::size_t>(in_R->index), i});
  }
  return shared;
}

const KeyFrame& At(const Map& map, KeyFrameId id) {
  const KeyFrame* const keyframe = map.keyframe(id);
  HIGHWALL_REQUIRE(keyframe != nullptr, "RelativeInformation: the keyframe is not in the map");
  return *keyframe;
}

}  // namespace

Matrix6 RelativeInformation(const Map& map, const MeasurementModel& model, KeyFrameId reference,
                            KeyFrameId keyframe) {
  const KeyFrame& R = At(map, reference);
  const KeyFrame& C = At(map, keyframe);
  Matrix6 information = Matrix6::Zero();
  ForEachKind([&]<class Landmark>() {
    const auto& of_R = PartOf<Landmark>(*R.frame.features);
    const auto& of_C = PartOf<Landmark>(*C.frame.features);
    const std::vector<Shared<Landmark>> shared = SharedBy<Landmark>(map, reference, C);
    const std::size_t every = (shared.size() + kMost - 1) / kMost;
    PairInformation pair(model.projection(), R.T_WC, C.T_WC);
    std::size_t used = 0;
    for (std::size_t i = 0; i < shared.size(); i += every, ++used) {
      const auto& [landmark, in_R, in_C] = shared[i];
      Add(model, *landmark, of_R[in_R], of_C[in_C], &pair);
    }
    if (used == 0) return;
    information +=
        static_cast<double>(shared.size()) / static_cast<double>(used) * pair.information();
  });
  return information;
}

}  // namespace highwall
