#pragma once

#include <type_traits>

#include <Eigen/Core>

// Blocks of a normal matrix whose sizes are known when the program is compiled, or are not.
namespace highwall::internal {

// Calls `visit` with the tangent size of an unknown, as a constant for a pose or a scalar: landmark
// factors rarely depend on other unknowns.
template <class Visit>
void WithSize(int tangent_size, const Visit& visit) {
  if (tangent_size == 6) {
    visit(std::integral_constant<int, 6>());
  } else if (tangent_size == 1) {
    visit(std::integral_constant<int, 1>());
  } else {
    visit(std::integral_constant<int, Eigen::Dynamic>());
  }
}

// Calls `visit` with the number of residuals of a factor, as a constant for those of points (2 or,
// with depth, 3) and of lines (2 or 4).
template <class Visit>
auto WithRows(int rows, const Visit& visit) {
  if (rows == 3) return visit(std::integral_constant<int, 3>());
  if (rows == 2) return visit(std::integral_constant<int, 2>());
  if (rows == 4) return visit(std::integral_constant<int, 4>());
  return visit(std::integral_constant<int, Eigen::Dynamic>());
}

// Adds A^T B at a block of H, upper-left corner (row, column). For kLeft and kRight columns of A
// and B.
template <int kLeft, int kRight, class Left, class Right, class Sum>
void AddProduct(const Left& A, const Right& B, int row, int column, Sum* H) {
  if constexpr (kLeft != Eigen::Dynamic && kRight != Eigen::Dynamic) {
    Eigen::Matrix<double, kLeft, kRight> sum = A.row(0).transpose() * B.row(0);
    for (Eigen::Index i = 1; i < A.rows(); ++i) {
      sum.noalias() += A.row(i).transpose() * B.row(i);
    }
    H->template block<kLeft, kRight>(row, column) += sum;
  } else {  // where Eigen would allocate temporaries
    for (Eigen::Index c = 0; c < B.cols(); ++c) {
      for (Eigen::Index i = 0; i < B.rows(); ++i) {
        // A row depends on few of many unknowns: on four nodes of a pattern, for instance.
        if (B(i, c) == 0.0) continue;
        H->col(column + c).segment(row, A.cols()) += B(i, c) * A.row(i).transpose();
      }
    }
  }
}

}  // namespace highwall::internal
