#include "sensor/imu_axes.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include <highwall/internal/number_text.h>

namespace highwall {

std::string MatrixText(const Eigen::Matrix3d& R) {
  std::string text = "[";
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      text += (row + column > 0 ? ", " : "") + FixedText(R(row, column), 3);
    }
  }
  return text + "]";
}

std::string AxesText(const Eigen::Matrix3d& P) {
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (P(row, column) == 0.0) continue;
      text += (row > 0 ? ", " : "") + std::string(P(row, column) < 0.0 ? "-" : "") +
              "xyz"[static_cast<std::size_t>(column)];
    }
  }
  return text;
}

std::vector<Eigen::Matrix3d> SignedPermutations() {
  std::vector<Eigen::Matrix3d> all;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (unsigned signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
      for (int row = 0; row < 3; ++row) {
        P(row, order[static_cast<std::size_t>(row)]) = ((signs >> row) & 1U) != 0U ? -1.0 : 1.0;
      }
      all.push_back(P);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

}  // namespace highwall
