#include "simulate/camera/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include <highwall/core/error.h>

#include "simulate/parallel_for.h"

namespace highwall::simulate {

struct Renderer::View {
  Eigen::Matrix3d R_WC;
  Eigen::Vector3d p_WC;

  // Direction with z_C = 1: its multiple is the depth.
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
  VertexLook look{};
};

namespace {

// Returns sample k of a grid x grid pattern within a pixel, in [px] from its centre. Lens
// distortion is ignored within a pixel.
Eigen::Vector2d SampleOffset(int k, int grid, const PinholeCamera& camera) {
  return {((k % grid + 0.5) / grid - 0.5) / camera.fx, ((k / grid + 0.5) / grid - 0.5) / camera.fy};
}

// Returns one sample per element of a packet, each in a row and a column of its own; units as
// above.
Eigen::Vector2d RookOffset(int k, const PinholeCamera& camera) {
  constexpr std::array<int, Raycaster::kPacket> kColumns = {3, 6, 0, 5, 2, 7, 4, 1};
  constexpr double kSide = Raycaster::kPacket;
  return {((kColumns[static_cast<std::size_t>(k)] + 0.5) / kSide - 0.5) / camera.fx,
          ((k + 0.5) / kSide - 0.5) / camera.fy};
}

VertexLook Mix(const VertexLook& a, const VertexLook& b, const VertexLook& c, float weight_b,
               float weight_c) {
  const float weight_a = 1.0f - weight_b - weight_c;
  return {.st = weight_a * a.st + weight_b * b.st + weight_c * c.st,
          .dust = weight_a * a.dust + weight_b * b.dust + weight_c * c.dust,
          .light = weight_a * a.light + weight_b * b.light + weight_c * c.light};
}

}  // namespace

Renderer::Renderer(Scene scene, const PinholeCamera& camera)
    : scene_(std::move(scene)), camera_(camera), raycaster_(scene_.mesh) {
  camera_.Validate();
  HIGHWALL_REQUIRE(scene_.looks.empty() || scene_.looks.size() == scene_.mesh.vertices.size(),
                   "Renderer: Scene::looks holds " + std::to_string(scene_.looks.size()) +
                       " entries, neither none nor one per vertex");
  rays_.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u < camera.width; ++u) {
      rays_.push_back(camera.Unproject({u, v}, 1.0).head<2>());
    }
  }
}

std::size_t Renderer::Index(int u, int v) const {
  return static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width) +
         static_cast<std::size_t>(u);
}

// Uses double precision and the plane itself: the single-precision tree only selects the triangle.
Renderer::SurfacePoint Renderer::PointOnRay(const View& view, const Eigen::Vector2d& ray,
                                            int triangle) const {
  const Surface& surface = scene_.surfaces[static_cast<std::size_t>(
      scene_.surface_of_triangle[static_cast<std::size_t>(triangle)])];
  if (!scene_.looks.empty()) return PointOnRelief(view, ray, triangle);
  const Eigen::Vector3d direction = view.Direction(ray);
  const double facing = surface.normal.dot(direction);
  const double depth = surface.normal.dot(surface.origin - view.p_WC) / facing;
  return {&surface, view.p_WC + depth * direction,
          facing > 0.0 ? Eigen::Vector3d(-surface.normal) : surface.normal, depth,
          std::abs(facing) / direction.norm()};
}

Renderer::SurfacePoint Renderer::PointOnRelief(const View& view, const Eigen::Vector2d& ray,
                                               int triangle) const {
  const auto index = static_cast<std::size_t>(triangle);
  const Surface& surface =
      scene_.surfaces[static_cast<std::size_t>(scene_.surface_of_triangle[index])];
  const auto& [i, j, k] = scene_.mesh.triangles[index];
  const Eigen::Vector3d& a = scene_.mesh.vertices[i];
  const Eigen::Vector3d ab = scene_.mesh.vertices[j] - a, ac = scene_.mesh.vertices[k] - a;
  const Eigen::Vector3d normal = ab.cross(ac);  // its length is twice the area
  const Eigen::Vector3d direction = view.Direction(ray);
  const double facing = normal.dot(direction);
  const Eigen::Vector3d to_a = a - view.p_WC;
  const double depth = normal.dot(to_a) / facing;
  // Barycentric weights (Moeller and Trumbore 1997).
  const Eigen::Vector3d across = to_a.cross(direction);
  const auto weight_b = static_cast<float>(ac.dot(across) / facing);
  const auto weight_c = static_cast<float>(-ab.dot(across) / facing);
  SurfacePoint point{&surface,
                     view.p_WC + depth * direction,
                     normal,
                     depth,
                     std::abs(facing) / std::sqrt(direction.squaredNorm() * normal.squaredNorm()),
                     Mix(scene_.looks[i], scene_.looks[j], scene_.looks[k], weight_b, weight_c)};
  if (!surface.relief) {
    const Eigen::Vector3d offset = point.p_W - surface.origin;
    point.look.st =
        Eigen::Vector2d(surface.s_axis.dot(offset), surface.t_axis.dot(offset)).cast<float>();
  }
  return point;
}

Eigen::Vector3f Renderer::Albedo(const SurfacePoint& point) const {
  const Surface& surface = *point.surface;
  const Texture& texture = *scene_.textures[static_cast<std::size_t>(surface.texture)];
  // A pixel is depth / f wide; a slanted surface stretches it in one direction only, hence the
  // square root.
  constexpr double kMinCosine = 0.05;
  const auto footprint = static_cast<float>(
      point.depth / (camera_.fx * std::sqrt(std::max(kMinCosine, point.cosine))));
  if (scene_.looks.empty()) {
    const Eigen::Vector3d offset = point.p_W - surface.origin;
    const Eigen::Vector2d st(surface.s_axis.dot(offset), surface.t_axis.dot(offset));
    return texture.Albedo(st.cast<float>() / surface.magnification,
                          footprint / surface.magnification);
  }
  const Colour clean = texture.Albedo(point.look.st, footprint);
  return clean + (scene_.dust - clean) * point.look.dust;
}

float Renderer::Irradiance(const SurfacePoint& point) const {
  if (!scene_.looks.empty()) return point.look.light;
  double sum = scene_.ambient;
  for (const Light& light : scene_.lights) {
    const Eigen::Vector3d to_light = light.p_W - point.p_W;
    const double squared = to_light.squaredNorm();
    const double facing = std::max(0.0, point.normal.dot(to_light));
    sum += light.power * facing / (std::sqrt(squared) * (squared + 1.0));
  }
  return static_cast<float>(sum);
}

Eigen::Vector3f Renderer::SkyOnRay(const View& view, const Eigen::Vector2d& ray) const {
  const double sine = view.Direction(ray).normalized().z();
  const auto high = static_cast<float>(std::clamp(sine, 0.0, 1.0));
  return scene_.sky.horizon + (scene_.sky.zenith - scene_.sky.horizon) * high;
}

Renderer::Backdrop Renderer::BackdropAt(const View& view, const Rendering* background, int u,
                                        int v) const {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  if (background == nullptr) return {kFar, 0.0f, SkyOnRay(view, rays_[Index(u, v)])};
  const float depth = background->depth.at<float>(v, u);
  const cv::Vec3f bgr = background->bgr.at<cv::Vec3f>(v, u) / 255.0f;
  return {depth > 0.0f ? static_cast<double>(depth) : kFar,
          background->cosine.at<float>(v, u),
          {bgr[0], bgr[1], bgr[2]}};
}

bool Renderer::IsInside(const Pixels& pixels, int u, int v) const {
  constexpr float kDepthStep = 0.05f, kLightStep = 0.12f;  // relative
  const Pixel& centre = pixels[Index(u, v)];
  const bool relief = !scene_.looks.empty();
  for (int y = std::max(0, v - 1); y <= std::min(camera_.height - 1, v + 1); ++y) {
    for (int x = std::max(0, u - 1); x <= std::min(camera_.width - 1, u + 1); ++x) {
      const Pixel& other = pixels[Index(x, y)];
      if (other.surface != centre.surface) return false;
      if (relief &&
          (std::abs(other.depth - centre.depth) > kDepthStep * centre.depth ||
           std::abs(other.look.light - centre.look.light) > kLightStep * centre.look.light)) {
        return false;
      }
    }
  }
  return true;
}

Eigen::Vector3f Renderer::ShadeInside(const View& view, const Eigen::Vector2d& centre,
                                      const Pixel& pixel) const {
  constexpr int kGrid = 2;
  Eigen::Vector3f albedo = Eigen::Vector3f::Zero();
  for (int k = 0; k < kGrid * kGrid; ++k) {
    albedo += Albedo(PointOnRay(view, centre + SampleOffset(k, kGrid, camera_), pixel.triangle));
  }
  const float light = Irradiance(PointOnRay(view, centre, pixel.triangle));
  return albedo * (light / static_cast<float>(kGrid * kGrid));
}

// Samples along the longer axis of the pixel's footprint, derived from the neighbours' coordinates.
Eigen::Vector3f Renderer::ShadeRelief(const Pixels& pixels, int u, int v) const {
  constexpr float kMaxSamples = 4.0f;
  const Pixel& pixel = pixels[Index(u, v)];
  const auto step_to = [&](int x, int y) -> Eigen::Vector2f {
    return pixels[Index(x, y)].look.st - pixel.look.st;
  };
  const Eigen::Vector2f across = step_to(u + 1 < camera_.width ? u + 1 : u - 1, v);
  const Eigen::Vector2f down = step_to(u, v + 1 < camera_.height ? v + 1 : v - 1);
  const bool tall = down.squaredNorm() > across.squaredNorm();
  const Eigen::Vector2f longer = tall ? down : across;
  const float width = std::max((tall ? across : down).norm(), 1e-4f), length = longer.norm();
  const float samples = std::clamp(std::round(length / width), 1.0f, kMaxSamples);
  // At a seam of the coordinates the step is meaningless, hence the limit on the length.
  const float footprint = std::min(std::max(width, length / samples),
                                   4.0f * pixel.depth / static_cast<float>(camera_.fx));

  const Surface& surface = scene_.surfaces[static_cast<std::size_t>(pixel.surface)];
  const Texture& texture = *scene_.textures[static_cast<std::size_t>(surface.texture)];
  Colour clean = Colour::Zero();
  for (float k = 0.5f; k < samples; k += 1.0f) {
    clean += texture.Albedo(pixel.look.st + (k / samples - 0.5f) * longer, footprint);
  }
  clean /= samples;
  return (clean + (scene_.dust - clean) * pixel.look.dust) * pixel.look.light;
}

Eigen::Vector3f Renderer::ShadeEdge(const View& view, const Eigen::Vector2d& centre) const {
  constexpr int kGrid = 3;
  Eigen::Vector3f radiance = Eigen::Vector3f::Zero();
  for (int k = 0; k < kGrid * kGrid; ++k) {
    const Eigen::Vector2d ray = centre + SampleOffset(k, kGrid, camera_);
    const int triangle = raycaster_.FirstTriangle(view.p_WC, view.Direction(ray));
    if (triangle == Raycaster::kNone) {
      radiance += SkyOnRay(view, ray);
      continue;
    }
    const SurfacePoint point = PointOnRay(view, ray, triangle);
    radiance += Albedo(point) * Irradiance(point);
  }
  return radiance / static_cast<float>(kGrid * kGrid);
}

Eigen::Vector3f Renderer::ShadeReliefEdge(const View& view, const Eigen::Vector2d& centre,
                                          const Backdrop& backdrop) const {
  std::array<Eigen::Vector3d, Raycaster::kPacket> directions;
  for (int k = 0; k < Raycaster::kPacket; ++k) {
    directions[static_cast<std::size_t>(k)] = view.Direction(centre + RookOffset(k, camera_));
  }
  const auto triangles = raycaster_.FirstTriangles(view.p_WC, directions);
  Eigen::Vector3f radiance = Eigen::Vector3f::Zero();
  for (int k = 0; k < Raycaster::kPacket; ++k) {
    const Eigen::Vector2d ray = centre + RookOffset(k, camera_);
    const int triangle = triangles[static_cast<std::size_t>(k)];
    if (triangle == Raycaster::kNone) {
      radiance += backdrop.radiance;
      continue;
    }
    const SurfacePoint point = PointOnRelief(view, ray, triangle);
    radiance += point.depth < backdrop.depth ? Albedo(point) * point.look.light : backdrop.radiance;
  }
  return radiance / static_cast<float>(Raycaster::kPacket);
}

void Renderer::TraceRow(const View& view, const Rendering* background, int v,
                        Pixels* pixels) const {
  for (int first = 0; first < camera_.width; first += Raycaster::kPacket) {
    // The last packet of a row may repeat the last pixel.
    std::array<Eigen::Vector3d, Raycaster::kPacket> directions;
    for (int k = 0; k < Raycaster::kPacket; ++k) {
      const int u = std::min(first + k, camera_.width - 1);
      directions[static_cast<std::size_t>(k)] = view.Direction(rays_[Index(u, v)]);
    }
    const auto triangles = raycaster_.FirstTriangles(view.p_WC, directions);
    for (int k = 0; k < Raycaster::kPacket && first + k < camera_.width; ++k) {
      const std::size_t index = Index(first + k, v);
      const int triangle = triangles[static_cast<std::size_t>(k)];
      if (triangle == Raycaster::kNone) continue;
      const SurfacePoint point = PointOnRay(view, rays_[index], triangle);
      if (background != nullptr && point.depth > BackdropAt(view, background, first + k, v).depth) {
        continue;
      }
      (*pixels)[index] = {.triangle = triangle,
                          .surface = scene_.surface_of_triangle[static_cast<std::size_t>(triangle)],
                          .depth = static_cast<float>(point.depth),
                          .cosine = static_cast<float>(point.cosine),
                          .look = point.look};
    }
  }
}

void Renderer::ShadeRow(const View& view, const Rendering* background, const Pixels& pixels, int v,
                        Rendering* out) const {
  const bool relief = !scene_.looks.empty();
  for (int u = 0; u < camera_.width; ++u) {
    const Pixel& pixel = pixels[Index(u, v)];
    const Eigen::Vector2d& centre = rays_[Index(u, v)];
    const bool none = pixel.surface == Raycaster::kNone, inside = IsInside(pixels, u, v);
    Backdrop backdrop{0.0, 0.0f, {}};
    if (none || !inside) backdrop = BackdropAt(view, background, u, v);
    Eigen::Vector3f radiance;
    if (!inside) {
      radiance = relief ? ShadeReliefEdge(view, centre, backdrop) : ShadeEdge(view, centre);
    } else if (none) {
      radiance = backdrop.radiance;
    } else {
      radiance = relief ? ShadeRelief(pixels, u, v) : ShadeInside(view, centre, pixel);
    }
    const bool far = none && std::isinf(backdrop.depth);
    out->depth.at<float>(v, u) = none && !far ? static_cast<float>(backdrop.depth) : pixel.depth;
    out->cosine.at<float>(v, u) = none ? backdrop.cosine : pixel.cosine;
    out->bgr.at<cv::Vec3f>(v, u) = 255.0f * cv::Vec3f(radiance.x(), radiance.y(), radiance.z());
  }
}

std::vector<Renderer::View> Renderer::MakeViews(std::span<const Pose> T_WC_of_row) const {
  HIGHWALL_REQUIRE(T_WC_of_row.size() == static_cast<std::size_t>(camera_.height),
                   "Renderer: needs one pose per row");
  std::vector<View> views;
  for (const Pose& T_WC : T_WC_of_row) views.push_back({T_WC.R(), T_WC.p()});
  return views;
}

Rendering Renderer::Render(const Pose& T_WC, int threads) const {
  const View view{T_WC.R(), T_WC.p()};
  return RenderViews(std::vector<View>(static_cast<std::size_t>(camera_.height), view), nullptr,
                     threads);
}

Rendering Renderer::Render(std::span<const Pose> T_WC_of_row, int threads) const {
  return RenderViews(MakeViews(T_WC_of_row), nullptr, threads);
}

Rendering Renderer::RenderOver(const Rendering& background, std::span<const Pose> T_WC_of_row,
                               int threads) const {
  return RenderViews(MakeViews(T_WC_of_row), &background, threads);
}

Rendering Renderer::RenderViews(std::span<const View> views, const Rendering* background,
                                int threads) const {
  const int w = camera_.width, h = camera_.height;
  Pixels pixels(rays_.size());
  ParallelFor(h, threads,
              [&](int v) { TraceRow(views[static_cast<std::size_t>(v)], background, v, &pixels); });
  Rendering out{cv::Mat(h, w, CV_32FC3), cv::Mat(h, w, CV_32FC1), cv::Mat(h, w, CV_32FC1)};
  ParallelFor(h, threads, [&](int v) {
    ShadeRow(views[static_cast<std::size_t>(v)], background, pixels, v, &out);
  });
  return out;
}

}  // namespace highwall::simulate
