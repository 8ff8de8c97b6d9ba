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

namespace {

double DepthOnRay(const Surface& surface, const Eigen::Vector3d& origin,
                  const Eigen::Vector3d& direction) {
  return surface.normal.dot(surface.origin - origin) / surface.normal.dot(direction);
}

double Irradiance(const Scene& scene, const Eigen::Vector3d& p_W, const Eigen::Vector3d& normal) {
  double sum = scene.ambient;
  for (const Light& light : scene.lights) {
    const Eigen::Vector3d to_light = light.p_W - p_W;
    const double squared = to_light.squaredNorm();
    sum += light.power * std::max(0.0, normal.dot(to_light)) / (std::sqrt(squared) * (squared + 1));
  }
  return sum;
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

bool Renderer::IsUniform(const cv::Mat& surfaces, int u, int v) const {
  const int centre = surfaces.at<int>(v, u);
  for (int y = std::max(0, v - 1); y <= std::min(camera_.height - 1, v + 1); ++y) {
    for (int x = std::max(0, u - 1); x <= std::min(camera_.width - 1, u + 1); ++x) {
      if (surfaces.at<int>(y, x) != centre) return false;
    }
  }
  return centre != Raycaster::kNone;
}

Eigen::Vector3f Renderer::Radiance(const View& view, const Eigen::Vector2d& ray,
                                   int surface_index) const {
  if (surface_index == Raycaster::kNone) return Eigen::Vector3f::Zero();
  const Surface& surface = scene_.surfaces[static_cast<std::size_t>(surface_index)];
  const Eigen::Vector3d direction = view.Direction(ray);
  const double depth = DepthOnRay(surface, view.p_WC, direction);
  const Eigen::Vector3d p_W = view.p_WC + depth * direction;
  const double facing = surface.normal.dot(direction);
  const Eigen::Vector3d normal = facing > 0.0 ? -surface.normal : surface.normal;
  // A pixel is depth / f wide; a slant stretches it one way only, hence the root.
  const double slant = std::max(0.05, std::abs(facing) / direction.norm());
  const double footprint = depth / camera_.fx / std::sqrt(slant);
  const Eigen::Vector3d from_origin = p_W - surface.origin;
  const Eigen::Vector2f st =
      Eigen::Vector2d(surface.s_axis.dot(from_origin), surface.t_axis.dot(from_origin))
          .cast<float>();
  const Texture& texture = *scene_.textures[static_cast<std::size_t>(surface.texture)];
  return texture.Albedo(st, static_cast<float>(footprint)) *
         static_cast<float>(Irradiance(scene_, p_W, normal));
}

void Renderer::ShadeRow(const View& view, const cv::Mat& surfaces, int v, Rendering* out) const {
  for (int u = 0; u < camera_.width; ++u) {
    const int surface = surfaces.at<int>(v, u);
    const Eigen::Vector2d& centre =
        rays_[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width) +
              static_cast<std::size_t>(u)];
    if (surface != Raycaster::kNone) {
      const Surface& plane = scene_.surfaces[static_cast<std::size_t>(surface)];
      const Eigen::Vector3d direction = view.Direction(centre);
      out->depth.at<float>(v, u) = static_cast<float>(DepthOnRay(plane, view.p_WC, direction));
      out->cosine.at<float>(v, u) =
          static_cast<float>(std::abs(plane.normal.dot(direction)) / direction.norm());
    }
    const bool uniform = IsUniform(surfaces, u, v);
    const int grid = uniform ? 2 : 3;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (int k = 0; k < grid * grid; ++k) {
      // Within a pixel the lens distortion hardly changes: its share of the offset is left out.
      const Eigen::Vector2d ray =
          centre + Eigen::Vector2d(((k % grid + 0.5) / grid - 0.5) / camera_.fx,
                                   ((k / grid + 0.5) / grid - 0.5) / camera_.fy);
      sum += Radiance(view, ray, uniform ? surface : SurfaceOnRay(view, ray));
    }
    sum *= 255.0f / static_cast<float>(grid * grid);
    out->bgr.at<cv::Vec3f>(v, u) = cv::Vec3f(sum.x(), sum.y(), sum.z());
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
