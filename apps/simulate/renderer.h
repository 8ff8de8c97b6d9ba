#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

#include "simulate/raycaster.h"
#include "simulate/scene.h"

namespace highwall::simulate {

// What an ideal camera sees.
struct Rendering {
  cv::Mat bgr;     // CV_32FC3, grey levels 0..255, not rounded
  cv::Mat depth;   // CV_32FC1, z of the surface on the ray through the pixel's centre [m], 0 = none
  cv::Mat cosine;  // CV_32FC1, of the angle between that ray and the surface's normal
};

// Lambertian surfaces under point lights without shadows. Colour is averaged over each pixel:
// 2 x 2 samples inside a surface, 3 x 3 rays where surfaces meet, textures filtered to the
// distance of the samples, so that corners stay put under motion.
class Renderer {
 public:
  // Throws InvalidArgument for a camera that is not valid.
  Renderer(Scene scene, const PinholeCamera& camera);

  const Scene& scene() const { return scene_; }
  const PinholeCamera& camera() const { return camera_; }

  // threads: 0 = one per processor; the result does not depend on it. Thread-safe.
  Rendering Render(const Pose& T_WC, int threads = 0) const;

 private:
  struct View;
  struct SurfacePoint;

  // ray: (x/z, y/z) in the camera. The index of the surface it meets, or Raycaster::kNone.
  int SurfaceOnRay(const View& view, const Eigen::Vector2d& ray) const;
  // Where the ray meets the plane of that surface.
  SurfacePoint PointOnRay(const View& view, const Eigen::Vector2d& ray, int surface) const;
  Eigen::Vector3f Albedo(const SurfacePoint& point) const;
  float Irradiance(const SurfacePoint& point) const;

  // Pixel (u, v) and its neighbours all show one surface.
  bool IsInside(const cv::Mat& surfaces, int u, int v) const;
  Eigen::Vector3f ShadeInside(const View& view, const Eigen::Vector2d& centre, int surface,
                              const SurfacePoint& point) const;
  Eigen::Vector3f ShadeEdge(const View& view, const Eigen::Vector2d& centre) const;
  void ShadeRow(const View& view, const cv::Mat& surfaces, int v, Rendering* out) const;

  Scene scene_;
  PinholeCamera camera_;
  Raycaster raycaster_;
  std::vector<Eigen::Vector2d> rays_;  // (x/z, y/z) of every pixel's centre, distortion removed
};

}  // namespace highwall::simulate
