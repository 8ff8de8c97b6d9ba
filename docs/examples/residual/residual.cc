// Evaluates a residual and checks its Jacobian.
#include <iostream>

#include "reproject.h"

int main() {
  std::string message;
  const highwall::Pose T_WB = highwall::Pose::FromTangent({0.1, 0.0, -0.2}, {0.0, 0.05, 0.0});
  const Eigen::Vector2d residual = Reproject(T_WB, {0.1, 0.05, 2.0}, {320.0, 240.0}, &message);
  std::cout << "residual " << residual.transpose() << " px\n"
            << (message.empty() ? "Jacobian agrees\n" : message);
}
