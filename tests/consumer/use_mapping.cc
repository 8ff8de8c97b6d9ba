// A wall 2 m in front of a depth camera: what stands in the way? Exits 0 if the answer is right.
#include <cmath>

#include <highwall/mapping/octomap_builder.h>
#include <highwall/mapping/octree_queries.h>

int main() {
  using namespace highwall;
  const PinholeCamera camera;
  const cv::Mat depth(camera.height, camera.width, CV_32FC1, cv::Scalar(2.0));
  OctomapBuilder map({.resolution = 0.1});
  map.Insert(depth, camera, Pose());
  const auto hit = CastRay(map, Eigen::Vector3d(0.01, 0.01, 0.5), Eigen::Vector3d::UnitZ(), 3.0);
  return hit && hit->known && std::abs(hit->p_W.z() - 2.0) <= 0.1 ? 0 : 1;
}
