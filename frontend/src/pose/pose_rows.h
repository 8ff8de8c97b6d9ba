#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <utility>

#include <Eigen/Core>

#include <highwall/factors/rgbd_projection.h>

namespace highwall {

// Landmarks are evaluated in groups of so many, each in a lane of its own, so that all steps are
// vectorized.
inline constexpr int kPoseLanes = 4;
using PoseLanes = Eigen::Array<double, kPoseLanes, 1>;

// J^T J and J^T r of rows, summed lane by lane in the camera: J = [G, G Q], with G = dr/dp_C and
// row vectors g Q = (g x q)^T, q = R_CB p_B. That is the tangent of the pose up to two rotations,
// which are the same for all landmarks and follow at the end.
class PoseNormalSums {
 public:
  using Vector = std::array<PoseLanes, 3>;
  // Upper triangle of a symmetric matrix: 00, 01, 02, 11, 12, 22.
  using Symmetric = std::array<PoseLanes, 6>;

  PoseNormalSums() { sums_.fill(PoseLanes::Zero()); }

  // W: G^T G; h: G^T r, both weighted.
  void Add(const Symmetric& W, const Vector& h, const Vector& q) {
    const Vector V0 = Cross({W[0], W[1], W[2]}, q);  // rows of W Q
    const Vector V1 = Cross({W[1], W[3], W[4]}, q);
    const Vector V2 = Cross({W[2], W[4], W[5]}, q);
    const Vector hQ = Cross(h, q);
    for (std::size_t i = 0; i < 6; ++i) sums_[i] += W[i];
    for (std::size_t i = 0; i < 3; ++i) {
      sums_[6 + i] += V0[i];
      sums_[9 + i] += V1[i];
      sums_[12 + i] += V2[i];
      sums_[21 + i] += h[i];
      sums_[24 + i] += hQ[i];
    }
    // Q^T W Q: columns of W Q, crossed with q.
    sums_[15] += V1[0] * q[2] - V2[0] * q[1];
    sums_[16] += V1[1] * q[2] - V2[1] * q[1];
    sums_[17] += V1[2] * q[2] - V2[2] * q[1];
    sums_[18] += V2[1] * q[0] - V0[1] * q[2];
    sums_[19] += V2[2] * q[0] - V0[2] * q[2];
    sums_[20] += V0[2] * q[1] - V1[2] * q[0];
  }

  Eigen::Matrix<double, 6, 6> Information() const {
    std::array<double, 21> s;
    for (std::size_t i = 0; i < s.size(); ++i) s[i] = sums_[i].sum();
    Eigen::Matrix<double, 6, 6> H;
    H.topLeftCorner<3, 3>() << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
    H.topRightCorner<3, 3>() << s[6], s[7], s[8], s[9], s[10], s[11], s[12], s[13], s[14];
    H.bottomLeftCorner<3, 3>() = H.topRightCorner<3, 3>().transpose();
    H.bottomRightCorner<3, 3>() << s[15], s[16], s[17], s[16], s[18], s[19], s[17], s[19], s[20];
    return H;
  }
  Eigen::Matrix<double, 6, 1> Gradient() const {
    Eigen::Matrix<double, 6, 1> g;
    for (std::size_t i = 0; i < 6; ++i) g[static_cast<Eigen::Index>(i)] = sums_[21 + i].sum();
    return g;
  }

 private:
  static Vector Cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }

  // W, W Q, Q^T W Q, h and h Q.
  std::array<PoseLanes, 27> sums_;
};

// Landmarks of one kind in a pose-only problem: each is observed at kEnds ends with kRows rows.
// They are projected once per pose; cost and normal equations follow from what is kept then.
template <int kRows, int kEnds>
class PoseRows {
 public:
  using Residual = Eigen::Matrix<double, kRows * kEnds, 1>;

  // projection: must outlive it.
  void Reset(std::size_t size, const RgbdProjection& projection) {
    projection_ = &projection;
    groups_ = static_cast<Eigen::Index>((size + kPoseLanes - 1) / kPoseLanes);
    given_.setZero(kPoseLanes, groups_ * kEnds * kGiven);
    kept_.setZero(kPoseLanes, groups_ * kEnds * kKept);
    uses_.setZero(kPoseLanes, groups_ * kUses);
  }

  void Set(std::size_t i, int end, const Eigen::Vector3d& p_W, const ProjectionRows<kRows>& rows) {
    const auto [lane, group] = Find(i);
    const Eigen::Index first = (group * kEnds + end) * kGiven;
    const double fx = projection_->fx(), fy = projection_->fy();
    const Eigen::Matrix<double, kRows, 1> b =
        rows.b + rows.A * Eigen::Vector3d(projection_->cx(), projection_->cy(), 0.0);
    if (!rows.A.allFinite() || !b.allFinite()) {
      // Never in the domain: lanes are masked by a product, which keeps NaN.
      given_(lane, first + 2) = std::numeric_limits<double>::quiet_NaN();
      return;
    }
    for (int k = 0; k < 3; ++k) given_(lane, first + k) = p_W[k];
    for (int k = 0; k < kRows; ++k) {
      const Eigen::Index row = first + 3 + 4 * k;
      given_(lane, row) = rows.A(k, 0) * fx;
      given_(lane, row + 1) = rows.A(k, 1) * fy;
      given_(lane, row + 2) = rows.A(k, 2) * (fx * projection_->baseline());
      given_(lane, row + 3) = b[k];
    }
  }
  // worst: residual outside of the domain.
  void SetWorst(std::size_t i, double worst) { Use(i, kWorst) = worst; }
  // Whether it counts, and with the last row of each end.
  void SetActive(std::size_t i, bool active, bool with_last_row = true) {
    Use(i, kActive) = active ? 1.0 : 0.0;
    Use(i, kLastRow) = with_last_row ? 1.0 : 0.0;
  }

  // Evaluates all rows from `view`.
  void Project(const RgbdProjection::View& view) {
    const Eigen::Matrix3d R = projection_->R_CB() * view.R_BW;
    for (Eigen::Index group = 0; group < groups_; ++group) {
      bool inside = true;
      for (int end = 0; end < kEnds; ++end) inside &= ProjectEnd(R, view.p_WB, group, end);
      if (!inside) [[unlikely]]
        LeaveDomain(group);
    }
  }

  // Of the last projection: whether all ends are in the domain, the rows (only if they are), and
  // the mean depth [m].
  bool IsInside(std::size_t i) const {
    const auto [lane, group] = Find(i);
    return kept_(lane, group * kEnds * kKept + kInverseDepth) > 0.0;
  }
  Residual At(std::size_t i) const {
    const auto [lane, group] = Find(i);
    Residual r;
    for (int end = 0; end < kEnds; ++end) {
      for (int k = 0; k < kRows; ++k) {
        r[end * kRows + k] = kept_(lane, (group * kEnds + end) * kKept + kResidual + k);
      }
    }
    return r;
  }
  double Depth(std::size_t i) const {
    const auto [lane, group] = Find(i);
    double sum = 0.0;
    for (int end = 0; end < kEnds; ++end) sum += kept_(lane, (group * kEnds + end) * kKept + 2);
    return sum / kEnds + projection_->p_CB().z();
  }

  // Returns the sum of the Huber cost rho(|r|^2) of active landmarks.
  double Cost(double huber) const {
    PoseLanes cost = PoseLanes::Zero();
    for (Eigen::Index group = 0; group < groups_; ++group) {
      const PoseLanes norm = Norm(group);
      // rho: |r|^2 up to the threshold, then 2 huber |r| - huber^2.
      const PoseLanes least = norm.min(huber);
      cost += uses_.col(group * kUses + kActive) * least * (2.0 * norm - least);
    }
    return cost.sum();
  }

  // Returns the same, and adds the rows of active landmarks, weighted as in iteratively reweighted
  // least squares: cost and gradient are those of rho. (Scaling r to |r|^2 = rho would halve J^T J
  // for large residuals, and steps would be twice too long.)
  double AddTo(PoseNormalSums* sums, double huber) const {
    PoseLanes cost = PoseLanes::Zero();
    for (Eigen::Index group = 0; group < groups_; ++group) {
      const PoseLanes norm = Norm(group), least = norm.min(huber);
      const PoseLanes active = uses_.col(group * kUses + kActive);
      cost += active * least * (2.0 * norm - least);
      const PoseLanes weight = active * (huber / norm.max(huber));
      for (int end = 0; end < kEnds; ++end) AddEnd(group, end, weight, sums);
    }
    return cost.sum();
  }

 private:
  // Columns of an end: p_W, then for each row the factors of (x/z, y/z, 1/z) and the constant.
  static constexpr int kGiven = 3 + 4 * kRows;
  // Columns of a projected end: q, 1/z, which is zero outside of the domain, and r.
  static constexpr int kInverseDepth = 3, kResidual = 4, kKept = 4 + kRows;
  // Columns of a landmark.
  static constexpr int kActive = 0, kLastRow = 1, kWorst = 2, kUses = 3;
  using Array = Eigen::Array<double, kPoseLanes, Eigen::Dynamic>;

  static std::pair<Eigen::Index, Eigen::Index> Find(std::size_t i) {
    return {static_cast<Eigen::Index>(i % kPoseLanes), static_cast<Eigen::Index>(i / kPoseLanes)};
  }
  double& Use(std::size_t i, int column) {
    const auto [lane, group] = Find(i);
    return uses_(lane, group * kUses + column);
  }

  // Returns whether all lanes are in the domain.
  bool ProjectEnd(const Eigen::Matrix3d& R, const Eigen::Vector3d& p_WB, Eigen::Index group,
                  int end) {
    const auto given = given_.template middleCols<kGiven>((group * kEnds + end) * kGiven);
    auto kept = kept_.template middleCols<kKept>((group * kEnds + end) * kKept);
    const Eigen::Vector3d& p_CB = projection_->p_CB();
    const PoseLanes x = given.col(0) - p_WB.x();
    const PoseLanes y = given.col(1) - p_WB.y();
    const PoseLanes z = given.col(2) - p_WB.z();
    const PoseLanes qx = R(0, 0) * x + R(0, 1) * y + R(0, 2) * z;
    const PoseLanes qy = R(1, 0) * x + R(1, 1) * y + R(1, 2) * z;
    const PoseLanes qz = R(2, 0) * x + R(2, 1) * y + R(2, 2) * z;
    const PoseLanes depth = qz + p_CB.z();
    const PoseLanes iz = 1.0 / depth;
    const PoseLanes u = (qx + p_CB.x()) * iz;
    const PoseLanes v = (qy + p_CB.y()) * iz;
    kept.col(0) = qx;
    kept.col(1) = qy;
    kept.col(2) = qz;
    kept.col(kInverseDepth) = iz;
    for (int k = 0; k < kRows; ++k) {
      const int row = 3 + 4 * k;
      kept.col(kResidual + k) = given.col(row) * u + given.col(row + 1) * v +
                                given.col(row + 2) * iz + given.col(row + 3);
    }
    return (depth >= projection_->min_depth()).all();
  }

  // Sets the worst residual, without a derivative, for landmarks with an end outside of the domain.
  void LeaveDomain(Eigen::Index group) {
    for (int lane = 0; lane < kPoseLanes; ++lane) {
      auto kept = kept_.row(lane).template segment<kEnds * kKept>(group * kEnds * kKept);
      bool inside = true;
      for (int end = 0; end < kEnds; ++end) {
        inside &= kept[end * kKept + 2] + projection_->p_CB().z() >= projection_->min_depth();
      }
      if (inside) continue;
      kept.setZero();
      kept[kResidual] = uses_(lane, group * kUses + kWorst);
    }
  }

  // Returns |r| over all ends.
  PoseLanes Norm(Eigen::Index group) const {
    PoseLanes squares = PoseLanes::Zero();
    for (int end = 0; end < kEnds; ++end) {
      const auto r = kept_.template middleCols<kRows>((group * kEnds + end) * kKept + kResidual);
      for (int k = 0; k + 1 < kRows; ++k) squares += r.col(k).square();
      squares += uses_.col(group * kUses + kLastRow) * r.col(kRows - 1).square();
    }
    return squares.sqrt();
  }

  void AddEnd(Eigen::Index group, int end, const PoseLanes& weight, PoseNormalSums* sums) const {
    const auto given = given_.template middleCols<kGiven>((group * kEnds + end) * kGiven);
    const auto kept = kept_.template middleCols<kKept>((group * kEnds + end) * kKept);
    const PoseLanes iz = kept.col(kInverseDepth);
    PoseNormalSums::Symmetric W;
    PoseNormalSums::Vector h;
    for (int k = 0; k < kRows; ++k) {
      const int row = 3 + 4 * k;
      // r = a x/z + b y/z + c/z + d:  dr/dp_C = (a, b, d - r) / z.
      const PoseLanes gx = given.col(row) * iz;
      const PoseLanes gy = given.col(row + 1) * iz;
      const PoseLanes gz = (given.col(row + 3) - kept.col(kResidual + k)) * iz;
      PoseLanes w = weight;
      if (k + 1 == kRows) w *= uses_.col(group * kUses + kLastRow);
      const PoseLanes wx = w * gx, wy = w * gy, wz = w * gz;
      const PoseLanes r = kept.col(kResidual + k);
      const PoseNormalSums::Symmetric of_row{wx * gx, wx * gy, wx * gz, wy * gy, wy * gz, wz * gz};
      const PoseNormalSums::Vector h_row{wx * r, wy * r, wz * r};
      for (std::size_t i = 0; i < W.size(); ++i) {
        W[i] = k == 0 ? of_row[i] : PoseLanes(W[i] + of_row[i]);
      }
      for (std::size_t i = 0; i < h.size(); ++i) {
        h[i] = k == 0 ? h_row[i] : PoseLanes(h[i] + h_row[i]);
      }
    }
    sums->Add(W, h, {kept.col(0), kept.col(1), kept.col(2)});
  }

  const RgbdProjection* projection_ = nullptr;
  Eigen::Index groups_ = 0;
  Array given_, kept_, uses_;
};

}  // namespace highwall
