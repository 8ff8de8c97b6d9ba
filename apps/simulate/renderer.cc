#include "simulate/renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulate/parallel_for.h"

namespace highwall::simulate {

struct Renderer::View {
  Eigen::Matrix3d R_WC;
  Eigen::Vector3d p_WC;

  // The direction with z_C = 1: its multiple is the depth.
  Eigen::Vector3d Direction(const Eigen::Vector2d& ray) const {
    return R_WC * Eigen::Vector3d(ray.x(), ray.y(), 1.0);
  }
};

struct Renderer::SurfacePoint {
  const Surface* surface;
  Eigen::Vector3d p_W;
  Eigen::Vector3d normal;  // towards the camera
  double depth;            // [m]
  double cosine;           // of the angle of incidence
};

namespace {

// Sample k of a grid x grid pattern within a pixel, [px] from its centre. The lens distortion
// hardly changes there: its share of the offset is left out.
Eigen::Vector2d SampleOffset(int k, int grid, const PinholeCamera& camera) {
  return {((k % grid + 0.5) / grid - 0.5) / camera.fx, ((k / grid + 0.5) / grid - 0.5) / camera.fy};
}

}  // namespace

Renderer::Renderer(Scene scene, const PinholeCamera& camera)
    : scene_(std::move(scene)), camera_(camera), raycaster_(scene_.mesh) {
  camera_.Validate();
  rays_.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      rays_.push_back(camera.Unproject({u, v}, 1.0).head<2>());
    }
  }
}

int Renderer::SurfaceOnRay(const View& view, const Eigen::Vector2d& ray) const {
  const int triangle = raycaster_.FirstTriangle(view.p_WC, view.Direction(ray));
  if (triangle == Raycaster::kNone) return Raycaster::kNone;
  return scene_.surface_of_triangle[static_cast<std::size_t>(triangle)];
}

// In double from the plane itself: the tree's single precision only decides which surface it is.
Renderer::SurfacePoint Renderer::PointOnRay(const View& view, const Eigen::Vector2d& ray,
                                            int index) const {
  const Surface& surface = scene_.surfaces[static_cast<std::size_t>(index)];
  const Eigen::Vector3d direction = view.Direction(ray);
  const double facing = surface.normal.dot(direction);
  const double depth = surface.normal.dot(surface.origin - view.p_WC) / facing;
  return {&surface, view.p_WC + depth * direction,
          facing > 0.0 ? Eigen::Vector3d(-surface.normal) : surface.normal, depth,
          std::abs(facing) / direction.norm()};
}

Eigen::Vector3f Renderer::Albedo(const SurfacePoint& point) const {
  const Surface& surface = *point.surface;
  const Eigen::Vector3d offset = point.p_W - surface.origin;
  const Eigen::Vector2d st(surface.s_axis.dot(offset), surface.t_axis.dot(offset));
  // A pixel is depth / f wide; a slant stretches it one way only, hence the root.
  constexpr double kMinCosine = 0.05;
  const double footprint =
      point.depth / (camera_.fx * std::sqrt(std::max(kMinCosine, point.cosine)));
  return scene_.textures[static_cast<std::size_t>(surface.texture)]->Albedo(
      st.cast<float>(), static_cast<float>(footprint));
}

float Renderer::Irradiance(const SurfacePoint& point) const {
  double sum = scene_.ambient;
  for (const Light& light : scene_.lights) {
    const Eigen::Vector3d to_light = light.p_W - point.p_W;
    const double squared = to_light.squaredNorm();
    const double facing = std::max(0.0, point.normal.dot(to_light));
    sum += light.power * facing / (std::sqrt(squared) * (squared + 1.0));
  }
  return static_cast<float>(sum);
}

bool Renderer::IsInside(const cv::Mat& surfaces, int u, int v) const {
  const int centre = surfaces.at<int>(v, u);
  for (int y = std::max(0, v - 1); y <= std::min(camera_.height - 1, v + 1); ++y) {
    for (int x = std::max(0, u - 1); x <= std::min(camera_.width - 1, u + 1); ++x) {
      if (surfaces.at<int>(y, x) != centre) return false;
    }
  }
  return centre != Raycaster::kNone;
}

Eigen::Vector3f Renderer::ShadeInside(const View& view, const Eigen::Vector2d& centre, int surface,
                                      const SurfacePoint& point) const {
  constexpr int kGrid = 2;
  Eigen::Vector3f albedo = Eigen::Vector3f::Zero();
  for (int k = 0; k < kGrid * kGrid; ++k) {
    albedo += Albedo(PointOnRay(view, centre + SampleOffset(k, kGrid, camera_), surface));
  }
  return albedo * (Irradiance(point) / static_cast<float>(kGrid * kGrid));
}

Eigen::Vector3f Renderer::ShadeEdge(const View& view, const Eigen::Vector2d& centre) const {
  constexpr int kGrid = 3;
  Eigen::Vector3f radiance = Eigen::Vector3f::Zero();
  for (int k = 0; k < kGrid * kGrid; ++k) {
    const Eigen::Vector2d ray = centre + SampleOffset(k, kGrid, camera_);
    const int surface = SurfaceOnRay(view, ray);
    if (surface == Raycaster::kNone) continue;
    const SurfacePoint point = PointOnRay(view, ray, surface);
    radiance += Albedo(point) * Irradiance(point);
  }
  return radiance / static_cast<float>(kGrid * kGrid);
}

void Renderer::ShadeRow(const View& view, const cv::Mat& surfaces, int v, Rendering* out) const {
  const Eigen::Vector2d* rays =
      &rays_[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width)];
  for (int u = 0; u < camera_.width; ++u) {
    const int surface = surfaces.at<int>(v, u);
    Eigen::Vector3f radiance;
    if (surface != Raycaster::kNone) {
      const SurfacePoint point = PointOnRay(view, rays[u], surface);
      out->depth.at<float>(v, u) = static_cast<float>(point.depth);
      out->cosine.at<float>(v, u) = static_cast<float>(point.cosine);
      radiance = IsInside(surfaces, u, v) ? ShadeInside(view, rays[u], surface, point)
                                          : ShadeEdge(view, rays[u]);
    } else {
      radiance = ShadeEdge(view, rays[u]);
    }
    out->bgr.at<cv::Vec3f>(v, u) = 255.0f * cv::Vec3f(radiance.x(), radiance.y(), radiance.z());
  }
}

Rendering Renderer::Render(const Pose& T_WC, int threads) const {
  const View view{T_WC.R(), T_WC.p()};
  const int w = camera_.width, h = camera_.height;
  cv::Mat surfaces(h, w, CV_32SC1);
  ParallelFor(h, threads, [&](int v) {
    const auto row = static_cast<std::size_t>(v) * static_cast<std::size_t>(w);
    for (int u = 0; u < w; ++u) {
      surfaces.at<int>(v, u) = SurfaceOnRay(view, rays_[row + static_cast<std::size_t>(u)]);
    }
  });
  Rendering out{cv::Mat(h, w, CV_32FC3), cv::Mat(h, w, CV_32FC1, cv::Scalar(0.0)),
                cv::Mat(h, w, CV_32FC1, cv::Scalar(0.0))};
  ParallelFor(h, threads, [&](int v) { ShadeRow(view, surfaces, v, &out); });
  return out;
}

}  // namespace highwall::simulate
