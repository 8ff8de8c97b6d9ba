#include <highwall/factors/depth_pattern.h>

#include <algorithm>
#include <cmath>

#include <highwall/core/error.h>

namespace highwall {
namespace {

// Node interval of a pixel along one axis: its first node, and the weight of the second one.
struct Place {
  int first;
  double share;
};

Place PlaceOf(double x, int size, int count) {
  const double position = std::clamp(x / std::max(size - 1, 1), 0.0, 1.0) * (count - 1);
  const int first = std::min(static_cast<int>(position), count - 2);
  return {first, position - first};
}

}  // namespace

void DepthPattern::Validate() const {
  HIGHWALL_REQUIRE(nodes.allFinite() && nodes.cwiseAbs().maxCoeff() < 1.0,
                   "DepthPattern::nodes must be within 1 / m");
}

double DepthPattern::Rms() const {
  return std::sqrt(nodes.squaredNorm() / kNodes);
}

double DepthPattern::At(double u, double v, int width, int height) const {
  const Place column = PlaceOf(u, width, kColumns);
  const Place row = PlaceOf(v, height, kRows);
  const auto along = [&](int node) {
    return (1.0 - column.share) * nodes[node] + column.share * nodes[node + 1];
  };
  const int node = row.first * kColumns + column.first;
  return (1.0 - row.share) * along(node) + row.share * along(node + kColumns);
}

DepthPattern::Vector DepthPattern::Shares(double u, double v, int width, int height) {
  const Place column = PlaceOf(u, width, kColumns);
  const Place row = PlaceOf(v, height, kRows);
  Vector shares = Vector::Zero();
  const int node = row.first * kColumns + column.first;
  shares[node] = (1.0 - row.share) * (1.0 - column.share);
  shares[node + 1] = (1.0 - row.share) * column.share;
  shares[node + kColumns] = row.share * (1.0 - column.share);
  shares[node + kColumns + 1] = row.share * column.share;
  return shares;
}

}  // namespace highwall
