#pragma once

#include <map>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace highwall::internal {

// Rows of a linear least-squares problem that are connected to a few blocks of its unknowns:
//   |A_0 x_0 + A_1 x_1 + ... + b|^2,   matrix = [A_0 A_1 ... b],   blocks ascending.
struct Rows {
  std::vector<int> blocks;
  Eigen::MatrixXd matrix;
};

// A sparse linear least-squares problem in square-root form, from which blocks of unknowns are
// eliminated one by one by Householder QR (docs/marginalization.md, Eq. 4-6). Copyable.
class RowSystem {
 public:
  // block_sizes: dimensions of each block of unknowns. rank_tolerance: a pivot of a column (scaled
  // to unit length) below it counts as zero, and so does a pivot below it times the length that the
  // column had before the elimination: the remainder of a column that an elimination has consumed
  // is rounding.
  RowSystem(std::vector<int> block_sizes, double rank_tolerance);

  // Must be called before Eliminate().
  void Add(Rows rows);

  // Minimizes over the blocks, those with few neighbours first: landmarks are eliminated one at a
  // time, each with the rows connected to it. Returns the sum of their ranks.
  int Eliminate(const std::vector<int>& blocks);

  // Returns the remaining rows as one matrix over the blocks [x_kept... b], upper trapezoidal, with
  // at most as many rows as unknowns. Every remaining row must be connected to these blocks only.
  Eigen::MatrixXd Triangular(const std::vector<int>& kept) const;
  // Returns the lengths of the columns of these blocks before the elimination.
  Eigen::VectorXd Lengths(const std::vector<int>& blocks) const;

 private:
  void Insert(Rows rows);
  int EliminateOne(int block);
  int NeighbourDimensions(int block) const;
  int Dimensions(const std::vector<int>& blocks) const;
  // Writes `rows` below row `first` of `out`; column[k]: where block k starts there.
  void Scatter(const Rows& rows, const std::vector<int>& column, Eigen::Index first,
               Eigen::MatrixXd* out) const;

  std::vector<int> sizes_;
  std::vector<Eigen::VectorXd> squared_;    // lengths of the columns of each block, as added
  std::vector<Rows> rows_;                  // empty block list: eliminated
  std::vector<std::vector<int>> rows_of_;   // block -> indices into rows_, eliminated ones included
  std::map<std::vector<int>, int> merged_;  // reduced rows by their blocks -> index into rows_
  std::vector<int> column_;                 // of each block in the front
  double tolerance_;
};

// Rank-revealing triangular form of [A b]: the rows R with R^T R = A^T A up to pivots below
// tolerance, for columns scaled to unit length, or below tolerance times `lengths`.
struct RankRevealed {
  Eigen::MatrixXd A;       // rank x n
  Eigen::VectorXd b;       // rank
  double condition = 1.0;  // largest over smallest singular value of A with unit columns
};
RankRevealed RevealRank(const Eigen::MatrixXd& A_b, const Eigen::VectorXd& lengths,
                        double tolerance);

}  // namespace highwall::internal
