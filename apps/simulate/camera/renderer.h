#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include <highwall/core/camera.h>
#include <highwall/core/pose.h>

#include "simulate/camera/raycaster.h"
#include "simulate/materials/scene.h"

namespace highwall::simulate {

// Image of an ideal camera.
struct Rendering {
  cv::Mat bgr;     // CV_32FC3, grey levels 0..255, not rounded
  cv::Mat depth;   // CV_32FC1, z of the surface on the ray through the pixel's centre [m], 0 = none
  cv::Mat cosine;  // CV_32FC1, of the angle between that ray and the surface's normal
};

// Renderer of Lambertian surfaces. The light comes from point lights without shadows, or is baked
// into the vertices if they have looks. Colour is averaged over each pixel: from 2 x 2 samples
// within a flat surface, along the pixel's footprint within a relief, over several rays at surface
// boundaries. Textures are filtered to the sample spacing, so that corners are stable under motion.
class Renderer {
 public:
  // Throws InvalidArgument for an invalid camera.
  Renderer(Scene scene, const PinholeCamera& camera);

  const Scene& scene() const { return scene_; }
  const PinholeCamera& camera() const { return camera_; }

  // threads: 0 = one per processor; the result does not depend on it. Thread-safe.
  Rendering Render(const Pose& T_WC, int threads = 0) const;
  // With a rolling shutter, every row has its own pose. Throws InvalidArgument unless there is one
  // per row.
  Rendering Render(std::span<const Pose> T_WC_of_row, int threads = 0) const;
  // Renders over another scene's rendering from the same poses, with depth ordering.
  Rendering RenderOver(const Rendering& background, std::span<const Pose> T_WC_of_row,
                       int threads = 0) const;

 private:
  struct View;
  struct SurfacePoint;
  // Intersection of the ray through a pixel's centre.
  struct Pixel {
    int triangle = Raycaster::kNone;
    int surface = Raycaster::kNone;
    float depth = 0.0f, cosine = 0.0f;
    VertexLook look;
  };
  using Pixels = std::vector<Pixel>;  // row by row
  // Background of the scene.
  struct Backdrop {
    double depth;  // [m], infinite for the sky
    float cosine;
    Eigen::Vector3f radiance;
  };

  // background: the sky if null.
  Rendering RenderViews(std::span<const View> views, const Rendering* background,
                        int threads) const;
  std::vector<View> MakeViews(std::span<const Pose> T_WC_of_row) const;
  Backdrop BackdropAt(const View& view, const Rendering* background, int u, int v) const;
  void TraceRow(const View& view, const Rendering* background, int v, Pixels* pixels) const;
  // Returns the intersection of the ray with the triangle's plane. ray: (x/z, y/z) in the camera.
  SurfacePoint PointOnRay(const View& view, const Eigen::Vector2d& ray, int triangle) const;
  SurfacePoint PointOnRelief(const View& view, const Eigen::Vector2d& ray, int triangle) const;
  Eigen::Vector3f Albedo(const SurfacePoint& point) const;
  float Irradiance(const SurfacePoint& point) const;
  Eigen::Vector3f SkyOnRay(const View& view, const Eigen::Vector2d& ray) const;

  std::size_t Index(int u, int v) const;
  // Whether pixel (u, v) and its neighbours all show one surface, without a step or an edge.
  bool IsInside(const Pixels& pixels, int u, int v) const;
  Eigen::Vector3f ShadeInside(const View& view, const Eigen::Vector2d& centre,
                              const Pixel& pixel) const;
  Eigen::Vector3f ShadeRelief(const Pixels& pixels, int u, int v) const;
  Eigen::Vector3f ShadeEdge(const View& view, const Eigen::Vector2d& centre) const;
  Eigen::Vector3f ShadeReliefEdge(const View& view, const Eigen::Vector2d& centre,
                                  const Backdrop& backdrop) const;
  void ShadeRow(const View& view, const Rendering* background, const Pixels& pixels, int v,
                Rendering* out) const;

  Scene scene_;
  PinholeCamera camera_;
  Raycaster raycaster_;
  std::vector<Eigen::Vector2d> rays_;  // (x/z, y/z) of every pixel's centre, distortion removed
};

}  // namespace highwall::simulate
