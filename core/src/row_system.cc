#include "row_system.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>

#include <Eigen/Householder>
#include <Eigen/QR>

namespace highwall::internal {
namespace {

// The columns scaled to unit length and pivoted. `lengths`: their lengths before the elimination;
// columns and pivots that are negligible relative to them do not count.
struct Pivoted {
  Pivoted(const Eigen::Ref<const Eigen::MatrixXd>& A, const Eigen::VectorXd& lengths,
          double tolerance)
      : scale(A.colwise().norm().transpose()) {
    Eigen::VectorXd inverse(scale.size());
    for (Eigen::Index c = 0; c < scale.size(); ++c) {
      inverse[c] = scale[c] > tolerance * lengths[c] ? 1.0 / scale[c] : 0.0;
    }
    qr.setThreshold(tolerance);
    qr.compute(A * inverse.asDiagonal());
    rank = qr.rank();
    const Eigen::VectorXi& column = qr.colsPermutation().indices();
    const auto is_rounding = [&](Eigen::Index k) {
      return std::abs(qr.matrixQR()(k, k)) * scale[column[k]] <= tolerance * lengths[column[k]];
    };
    while (rank > 0 && is_rounding(rank - 1)) --rank;
  }

  Eigen::VectorXd scale;
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
  Eigen::Index rank = 0;
};

// [A b] -> [R Q^T b], as many rows as columns of A: the rows below are a constant of the cost.
void Compress(Eigen::MatrixXd* A_b) {
  const Eigen::Index columns = A_b->cols() - 1;
  if (A_b->rows() <= columns) return;
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(*A_b);
  *A_b = qr.matrixQR().topRows(columns).triangularView<Eigen::Upper>();
}

// Returns the diagonal and the superdiagonal, interleaved from the top, of an upper bidiagonal
// matrix with the singular values of A, which has no more columns than rows.
Eigen::VectorXd Bidiagonal(Eigen::MatrixXd A) {
  const Eigen::Index n = A.cols();
  Eigen::VectorXd out(2 * n - 1), workspace(A.rows());
  double tau = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index below = A.rows() - k - 1, right = n - k - 1;
    A.col(k).tail(below + 1).makeHouseholderInPlace(tau, out[2 * k]);
    if (right == 0) break;
    A.bottomRightCorner(below + 1, right)
        .applyHouseholderOnTheLeft(A.col(k).tail(below), tau, workspace.data());
    A.row(k).tail(right).makeHouseholderInPlace(tau, out[2 * k + 1]);
    A.bottomRightCorner(below, right)
        .applyHouseholderOnTheRight(A.row(k).tail(right - 1).transpose(), tau, workspace.data());
  }
  return out;
}

// Returns the number of singular values of a bidiagonal matrix below x: by Sylvester's law of
// inertia for the tridiagonal matrix with eigenvalues +-sigma, whose diagonal is zero and whose
// off-diagonal holds these entries.
Eigen::Index CountBelow(const Eigen::VectorXd& bidiagonal, double x) {
  Eigen::Index negative = 1;  // pivots
  double pivot = -x;
  for (const double entry : bidiagonal) {
    if (pivot == 0.0) pivot = std::numeric_limits<double>::min();
    pivot = -x - entry / pivot * entry;
    negative += pivot < 0.0;
  }
  return negative - (bidiagonal.size() + 1) / 2;
}

// Returns the ratio of the largest to the smallest singular value of R with R^T of full rank, by
// bisection: a decomposition would compute all the others too.
double Condition(const Eigen::MatrixXd& R) {
  const Eigen::VectorXd bidiagonal = Bidiagonal(R.transpose());
  // Fewer than `count` are below low, at least as many below high.
  const auto bisect = [&](double low, double high, Eigen::Index count) {
    while (high - low > 1e-12 * high) {
      const double middle = 0.5 * (low + high);
      (CountBelow(bidiagonal, middle) < count ? low : high) = middle;
    }
    return high;
  };
  const double above_all = 2.0 * R.norm();
  double low = above_all;
  while (low > 0.0 && CountBelow(bidiagonal, low) > 0) low *= 0.25;
  const double smallest = bisect(low, 4.0 * low, 1);
  return bisect(smallest, above_all, R.rows()) / smallest;
}

}  // namespace

RowSystem::RowSystem(std::vector<int> block_sizes, double rank_tolerance)
    : sizes_(std::move(block_sizes)),
      rows_of_(sizes_.size()),
      column_(sizes_.size(), 0),
      tolerance_(rank_tolerance) {
  for (const int size : sizes_) squared_.push_back(Eigen::VectorXd::Zero(size));
}

void RowSystem::Add(Rows rows) {
  Eigen::Index from = 0;
  for (const int block : rows.blocks) {
    Eigen::VectorXd& squared = squared_[static_cast<std::size_t>(block)];
    squared += rows.matrix.middleCols(from, squared.size()).colwise().squaredNorm().transpose();
    from += squared.size();
  }
  Insert(std::move(rows));
}

void RowSystem::Insert(Rows rows) {
  const int index = static_cast<int>(rows_.size());
  for (const int block : rows.blocks) rows_of_[static_cast<std::size_t>(block)].push_back(index);
  rows_.push_back(std::move(rows));
}

int RowSystem::Dimensions(const std::vector<int>& blocks) const {
  int sum = 0;
  for (const int block : blocks) sum += sizes_[static_cast<std::size_t>(block)];
  return sum;
}

int RowSystem::NeighbourDimensions(int block) const {
  std::vector<int> all;
  for (const int index : rows_of_[static_cast<std::size_t>(block)]) {
    const std::vector<int>& blocks = rows_[static_cast<std::size_t>(index)].blocks;
    all.insert(all.end(), blocks.begin(), blocks.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return Dimensions(all);
}

void RowSystem::Scatter(const Rows& rows, const std::vector<int>& column, Eigen::Index first,
                        Eigen::MatrixXd* out) const {
  const Eigen::Index count = rows.matrix.rows();
  Eigen::Index from = 0;
  for (const int block : rows.blocks) {
    const int size = sizes_[static_cast<std::size_t>(block)];
    out->block(first, column[static_cast<std::size_t>(block)], count, size) =
        rows.matrix.middleCols(from, size);
    from += size;
  }
  out->col(out->cols() - 1).segment(first, count) = rows.matrix.col(from);
}

int RowSystem::Eliminate(const std::vector<int>& blocks) {
  // Minimum degree with stale keys: a block whose degree has grown is queued again.
  using Entry = std::pair<int, int>;  // degree, block
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const int block : blocks) queue.emplace(NeighbourDimensions(block), block);
  int rank = 0;
  while (!queue.empty()) {
    const int block = queue.top().second;
    queue.pop();
    const int degree = NeighbourDimensions(block);
    if (!queue.empty() && degree > queue.top().first) {
      queue.emplace(degree, block);
      continue;
    }
    rank += EliminateOne(block);
  }
  return rank;
}

int RowSystem::EliminateOne(int block) {
  const std::vector<int>& touching = rows_of_[static_cast<std::size_t>(block)];
  Rows reduced;
  Eigen::Index count = 0;
  for (const int index : touching) {
    const Rows& rows = rows_[static_cast<std::size_t>(index)];
    reduced.blocks.insert(reduced.blocks.end(), rows.blocks.begin(), rows.blocks.end());
    count += rows.matrix.rows();
  }
  std::sort(reduced.blocks.begin(), reduced.blocks.end());
  reduced.blocks.erase(std::unique(reduced.blocks.begin(), reduced.blocks.end()),
                       reduced.blocks.end());

  if (count == 0) return 0;
  reduced.blocks.erase(std::find(reduced.blocks.begin(), reduced.blocks.end(), block));

  // The front [A_block A_others b].
  const int size = sizes_[static_cast<std::size_t>(block)];
  column_[static_cast<std::size_t>(block)] = 0;
  int columns = size;
  for (const int other : reduced.blocks) {
    column_[static_cast<std::size_t>(other)] = columns;
    columns += sizes_[static_cast<std::size_t>(other)];
  }
  Eigen::MatrixXd front = Eigen::MatrixXd::Zero(count, columns + 1);
  Eigen::Index first = 0;
  for (const int index : touching) {
    Rows& rows = rows_[static_cast<std::size_t>(index)];
    if (rows.blocks.empty()) continue;
    Scatter(rows, column_, first, &front);
    first += rows.matrix.rows();
    const auto merged = merged_.find(rows.blocks);
    if (merged != merged_.end() && merged->second == index) merged_.erase(merged);
    rows = {};
  }

  const Pivoted pivoted(front.leftCols(size), Lengths({block}), tolerance_);  // Eq. 4
  const Eigen::Index rank = pivoted.rank;
  if (rank == count || reduced.blocks.empty()) return static_cast<int>(rank);
  front.rightCols(columns + 1 - size).applyOnTheLeft(pivoted.qr.householderQ().adjoint());
  reduced.matrix = front.bottomRightCorner(count - rank, columns + 1 - size);  // Eq. 5

  const auto same = merged_.find(reduced.blocks);
  if (same == merged_.end()) {
    Compress(&reduced.matrix);
    merged_.emplace(reduced.blocks, static_cast<int>(rows_.size()));
    Insert(std::move(reduced));
    return static_cast<int>(rank);
  }
  // Landmarks with the same neighbours share one triangle.
  Eigen::MatrixXd& matrix = rows_[static_cast<std::size_t>(same->second)].matrix;
  const Eigen::Index before = matrix.rows();
  matrix.conservativeResize(before + reduced.matrix.rows(), Eigen::NoChange);
  matrix.bottomRows(reduced.matrix.rows()) = reduced.matrix;
  if (matrix.rows() >= 6 * matrix.cols()) Compress(&matrix);
  return static_cast<int>(rank);
}

Eigen::MatrixXd RowSystem::Triangular(const std::vector<int>& kept) const {
  std::vector<int> column(sizes_.size(), -1);
  int columns = 0;
  for (const int block : kept) {
    column[static_cast<std::size_t>(block)] = columns;
    columns += sizes_[static_cast<std::size_t>(block)];
  }
  // In batches, so that memory does not grow with the number of rows.
  const Eigen::Index limit = std::max<Eigen::Index>(4 * columns, 64);
  Eigen::MatrixXd result(0, columns + 1);
  for (const Rows& rows : rows_) {
    if (rows.blocks.empty()) continue;
    const Eigen::Index first = result.rows();
    result.conservativeResize(first + rows.matrix.rows(), Eigen::NoChange);
    result.bottomRows(rows.matrix.rows()).setZero();
    Scatter(rows, column, first, &result);
    if (result.rows() > limit) Compress(&result);
  }
  Compress(&result);
  return result;
}

Eigen::VectorXd RowSystem::Lengths(const std::vector<int>& blocks) const {
  Eigen::VectorXd lengths(Dimensions(blocks));
  Eigen::Index to = 0;
  for (const int block : blocks) {
    const Eigen::VectorXd& squared = squared_[static_cast<std::size_t>(block)];
    lengths.segment(to, squared.size()) = squared.cwiseSqrt();
    to += squared.size();
  }
  return lengths;
}

RankRevealed RevealRank(const Eigen::MatrixXd& A_b, const Eigen::VectorXd& lengths,
                        double tolerance) {
  const Eigen::Index n = A_b.cols() - 1;
  RankRevealed out;
  if (A_b.rows() == 0 || n == 0) {
    out.A.resize(0, n);
    return out;
  }
  const Pivoted pivoted(A_b.leftCols(n), lengths, tolerance);
  const auto& qr = pivoted.qr;
  const Eigen::MatrixXd R = qr.matrixQR().topRows(pivoted.rank).triangularView<Eigen::Upper>();
  out.A = R * qr.colsPermutation().transpose() * pivoted.scale.asDiagonal();
  out.b = (qr.householderQ().adjoint() * A_b.col(n)).head(pivoted.rank);
  if (pivoted.rank > 0) out.condition = Condition(R);
  return out;
}

}  // namespace highwall::internal
