// A camera before a wall moves 40 mm to the right: how far did it go? Exits 0 if the answer is
// right.
#include <cmath>
#include <random>

#include <highwall/frontend/system/slam_system.h>

int main() {
  using namespace highwall;
  const RgbdSensor sensor;
  const PinholeCamera& camera = sensor.camera;
  constexpr double kDepth = 2.0, kWay = 0.04;                                  // [m]
  const int shift = static_cast<int>(std::lround(camera.fx * kWay / kDepth));  // [px]

  // Blocks of random grey.
  cv::Mat wall(camera.height, camera.width + shift, CV_8UC3);
  std::mt19937 random(1);
  for (int v = 0; v < wall.rows; v += 8) {
    for (int u = 0; u < wall.cols; u += 8) {
      const cv::Rect block = cv::Rect(u, v, 8, 8) & cv::Rect(0, 0, wall.cols, wall.rows);
      wall(block).setTo(cv::Scalar::all(static_cast<double>(random() % 256)));
    }
  }
  const cv::Mat depth(camera.height, camera.width, CV_32FC1, cv::Scalar(kDepth));
  SlamSystem slam(sensor);
  FrameResult frame;
  for (const int moved : {0, shift / 2, shift}) {
    const cv::Rect view(moved, 0, camera.width, camera.height);
    frame = slam.Track({moved * 1'000'000, wall(view).clone(), depth});
  }
  slam.Finish();
  const Eigen::Vector3d truth(0.0, -shift * kDepth / camera.fx, 0.0);  // x is forward, z up
  return HasPose(frame.state) && (frame.T_WC.p() - truth).norm() < 1e-3 ? 0 : 1;
}
