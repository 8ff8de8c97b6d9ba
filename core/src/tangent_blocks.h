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

// Adds weight A^T B at a block of H.
template <int kLeft, int kRight, class Left, class Right>
void AddProduct(double weight, const Left& A, const Right& B, int row, int column,
                Eigen::MatrixXd* H) {
  if constexpr (kLeft != Eigen::Dynamic && kRight != Eigen::Dynamic) {
    Eigen::Matrix<double, kLeft, kRight> sum = weight * A.row(0).transpose() * B.row(0);
    for (Eigen::Index i = 1; i < A.rows(); ++i) {
      sum.noalias() += weight * A.row(i).transpose() * B.row(i);
    }
    H->block<kLeft, kRight>(row, column) += sum;
  } else {  // where Eigen would allocate temporaries
    for (Eigen::Index c = 0; c < B.cols(); ++c) {
      for (Eigen::Index r = 0; r < A.cols(); ++r) {
        double sum = weight * A(0, r) * B(0, c);
        for (Eigen::Index i = 1; i < A.rows(); ++i) sum += weight * A(i, r) * B(i, c);
        (*H)(row + r, column + c) += sum;
      }
    }
  }
}

}  // namespace highwall::internal
