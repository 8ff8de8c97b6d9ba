#include "simulate/scenes/roadside.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "simulate/random.h"
#include "simulate/scenes/relief.h"

namespace highwall::simulate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBare = 0.6;  // dust above which no objects are placed

// Returns a pose with x forward, y left, z up, on the ground, rotated by yaw.
Pose OnGround(const Course& course, const RoadSurface& surface, double s, double left, double yaw) {
  const Course::Frame frame = course.At(s);
  Eigen::Matrix3d R;
  R << frame.forward, frame.left, Vector3d::UnitZ();
  return Pose(Eigen::Quaterniond(R) * Eigen::AngleAxisd(yaw, Vector3d::UnitZ()),
              frame.Point(left, surface.Height(s, left)));
}

int AddStripes(const Colour& first, const Colour& second, float height, Scene* scene) {
  return scene->AddTexture(std::make_unique<MasonryTexture>(
      MasonryOptions{.cell = {10.0f, height},
                     .joint = 0.0f,
                     .shift = 0.0f,
                     .checker = true,
                     .first = first,
                     .second = second,
                     .contrast = 0.25f,
                     .noise = {.wavelength = 0.05f, .octaves = 3}}));
}

int AddPaint(const Colour& colour, float contrast, std::uint32_t seed, Scene* scene) {
  return scene->AddTexture(std::make_unique<NoiseTexture>(
      colour, contrast, ValueNoise{.wavelength = 0.12f, .octaves = 4, .seed = seed}));
}

// Adds a framed panel with bars of text and one or two blocks.
int AddSignFace(const Vector2d& size, RandomSequence* random, Scene* scene) {
  const Eigen::Vector2f extent = size.cast<float>();
  const bool yellow = random->Index(2) == 0;
  const Colour ink = yellow ? Rgb(0.08, 0.08, 0.08) : Rgb(0.85, 0.85, 0.82);
  const Colour ground = yellow ? Rgb(0.85, 0.65, 0.1) : Rgb(0.1, 0.25, 0.5);
  const Eigen::Vector2f border(0.03f, 0.03f);
  std::vector<PrintPatch> patches = {{border, extent - border, ground}};
  const auto patch = [&](double left, double bottom, double right, double top) {
    patches.push_back({Vector2d(left * size.x(), bottom * size.y()).cast<float>(),
                       Vector2d(right * size.x(), top * size.y()).cast<float>(), ink});
  };
  const double middle = random->Uniform(0.25, 0.45);
  patch(0.12, 0.5, middle, 0.85);
  for (double top = 0.82; top > 0.55; top -= 0.14) {
    patch(middle + 0.08, top - 0.08, random->Uniform(0.6, 0.9), top);
  }
  for (double left = 0.12; left < 0.8; left += random->Uniform(0.12, 0.25)) {
    patch(left, 0.15, left + 0.07, random->Uniform(0.28, 0.42));
  }
  return scene->AddTexture(std::make_unique<PrintTexture>(
      ink, std::move(patches), static_cast<std::uint32_t>(random->Bits())));
}

void AddSign(const Pose& T_WB, int metal, RandomSequence* random, Scene* scene) {
  const Vector2d size{random->Uniform(0.5, 0.75), random->Uniform(0.4, 0.55)};
  // Its front, -y, faces oncoming vehicles.
  const Pose T_WS =
      T_WB * Pose(Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Vector3d::UnitZ())),
                  Vector3d::Zero());
  constexpr double kFoot = 0.2, kClear = 0.75;  // [m] in the ground, below the panel
  for (const double side : {-0.35, 0.35}) {
    const Pose post(Eigen::Quaterniond::Identity(), Vector3d(side * size.x(), 0.03, -kFoot));
    scene->AddBox(T_WS * post, {0.05, 0.05, kFoot + kClear + size.y()}, {metal, metal, metal});
  }
  const int face = AddSignFace(size, random, scene);
  scene->AddBox(T_WS * Pose(Eigen::Quaterniond::Identity(), Vector3d(0, -0.01, kClear)),
                {size.x(), 0.03, size.y()}, {metal, face, metal});
}

}  // namespace

void AddTube(const Course& course, double s_begin, double s_end, double radius, int texture,
             const std::function<Vector2d(double s)>& place, Scene* scene) {
  constexpr int kAround = 10;
  constexpr double kStep = 0.15;  // [m]
  const int rows = std::max(2, static_cast<int>((s_end - s_begin) / kStep) + 1);
  AddSheet(
      rows, kAround + 1, texture,
      [&](int i, int j) -> ReliefPoint {
        const double s = s_begin + (s_end - s_begin) * i / (rows - 1);
        const double angle = -2.0 * std::numbers::pi * j / kAround;
        const Vector2d middle = place(s);
        const Vector3d p_W = course.At(s).Point(middle.x() + radius * std::cos(angle),
                                                middle.y() + radius * std::sin(angle));
        return {p_W, {.st = Vector2d(s, radius * angle).cast<float>(), .dust = 0.15f}};
      },
      scene);
}

namespace {

// Adds a cable that sags between poles, along the whole course.
void AddCable(const Course& course, const RoadSurface& surface, const RoadsideOptions& options,
              int wood, int rubber, Scene* scene) {
  constexpr double kHeight = 1.35, kSag = 0.22, kThick = 0.018;  // [m]
  const double left = options.left + 0.2;
  const int poles = static_cast<int>(course.length() / options.pole_spacing);
  const double span = course.length() / poles;
  for (int i = 0; i < poles; ++i) {
    const Pose foot = OnGround(course, surface, span * i, left, 0.0) *
                      Pose(Eigen::Quaterniond::Identity(), Vector3d(0, 0, -0.2));
    scene->AddBox(foot, {0.09, 0.09, kHeight + 0.3}, {wood, wood, wood});
  }
  const auto hang = [&](double s) {
    const double x = s / span - std::floor(s / span);
    return Vector2d(left, kHeight - 4.0 * kSag * x * (1.0 - x));
  };
  AddTube(course, 0.0, course.length(), kThick, rubber, hang, scene);
}

}  // namespace

void AddRoadside(const Course& course, const RoadSurface& surface, const RoadsideOptions& options,
                 std::uint64_t seed, Scene* scene) {
  RandomSequence random(Mix(seed));
  const int stripes = AddStripes(Rgb(0.75, 0.12, 0.08), Rgb(0.85, 0.85, 0.82), 0.16f, scene);
  const int top = AddPaint(Rgb(0.8, 0.8, 0.78), 0.2f, 1, scene);
  const int metal = AddPaint(Rgb(0.42, 0.43, 0.45), 0.25f, 2, scene);
  const int wood = AddPaint(Rgb(0.4, 0.3, 0.2), 0.5f, 3, scene);
  const int rubber = AddPaint(Rgb(0.09, 0.09, 0.1), 0.3f, 4, scene);
  const int rust = AddPaint(Rgb(0.5, 0.28, 0.16), 0.5f, 5, scene);
  const auto is_bare = [&](double s) { return surface.Dust(s, 0.0) > kBare; };
  const double length = course.length();

  for (double s = 1.0; s < length - 1.0; s += options.marker_spacing * random.Uniform(0.7, 1.3)) {
    const double lane = random.Index(3) == 0 ? options.left : options.right;
    if (is_bare(s)) continue;
    const Pose foot = OnGround(course, surface, s, lane, random.Uniform(-0.3, 0.3)) *
                      Pose(Eigen::Quaterniond::Identity(), Vector3d(0, 0, -0.1));
    scene->AddBox(foot, {0.08, 0.08, random.Uniform(0.9, 1.2)}, {stripes, stripes, top});
  }
  for (double s = 3.0; s < length - 1.0; s += options.sign_spacing * random.Uniform(0.7, 1.3)) {
    const double lane = random.Index(2) == 0 ? options.left + 0.1 : options.right - 0.1;
    if (is_bare(s)) continue;
    AddSign(OnGround(course, surface, s, lane, random.Uniform(-0.25, 0.25)), metal, &random, scene);
  }
  AddCable(course, surface, options, wood, rubber, scene);
  if (!options.pipe) return;
  const double pipe_left = options.left - 0.05;
  const auto lie = [&](double s) {
    return Vector2d(pipe_left, surface.Height(s, pipe_left) + 0.1);
  };
  AddTube(course, 0.0, length, 0.07, rust, lie, scene);
}

void AddDebris(const Course& course, const RoadSurface& surface, const DebrisOptions& options,
               int rock, std::uint64_t seed, Scene* scene) {
  RandomSequence random(Mix(seed));
  const double length = course.length();
  const auto add = [&](double left, double size, int level) {
    const double s = random.Uniform(0.0, length), yaw = random.Uniform(-3.1, 3.1);
    const double dust = surface.Dust(s, left);
    if (dust > kBare && random.Index(12) != 0) return;
    const Vector3d radii = size * Vector3d{random.Uniform(0.75, 1.3), random.Uniform(0.7, 1.0),
                                           random.Uniform(0.5, 0.85)};
    AddBoulder(OnGround(course, surface, s, left, yaw),
               {.radii = radii,
                .level = level,
                .sunk = random.Uniform(0.1, 0.5),
                .dust = static_cast<float>(std::min(0.9, dust)),
                .light = static_cast<float>(random.Uniform(0.75, 1.15))},
               rock, &random, scene);
  };
  const auto pebbles = static_cast<int>(options.pebbles * length);
  for (int i = 0; i < pebbles; ++i) {
    // Most are small.
    const double size = 0.012 + 0.05 * std::pow(random.Uniform(0.0, 1.0), 4.0);
    add(RoadSurface::kMiddle + random.Uniform(-options.road, options.road), size, 0);
  }
  const auto boulders = static_cast<int>(options.boulders * length);
  for (int i = 0; i < boulders; ++i) {
    const double size = 0.06 + 0.26 * std::pow(random.Uniform(0.0, 1.0), 3.0);
    const double beyond = random.Uniform(0.0, options.reach) + size;
    add(random.Index(2) == 0 ? options.left + beyond : options.right - beyond, size, 2);
  }
}

}  // namespace highwall::simulate
