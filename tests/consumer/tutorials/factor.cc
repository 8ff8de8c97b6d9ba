// Runs the program of docs/tutorial_factor.md; exits 0 if the body is found.
#include <factor/beacon_range.h>

int main() {
  const highwall::Pose truth;
  const Eigen::Vector3d antenna(0.3, 0.0, 0.0);
  std::vector<Range> ranges;
  for (const highwall::Point& beacon : {highwall::Point(0, 0, 3), highwall::Point(9, 0, 1),
                                        highwall::Point(0, 9, 0), highwall::Point(9, 9, 4)}) {
    ranges.push_back({beacon, (truth * antenna - beacon).norm()});
  }
  const highwall::Pose found =
      Locate(ranges, antenna, highwall::Pose::FromTangent({0.5, 0.5, 0}, {0, 0, 0}));
  return found.p().norm() < 1e-3 ? 0 : 1;
}
