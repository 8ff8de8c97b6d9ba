#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>

#include "simulate/camera/renderer.h"
#include "simulate/materials/baked_texture.h"
#include "simulate/materials/gravel.h"
#include "simulate/materials/strata.h"
#include "simulate/motion/course.h"
#include "simulate/parallel_for.h"
#include "simulate/random.h"
#include "simulate/scenes/relief.h"
#include "simulate/scenes/road_surface.h"
#include "simulate/scenes/sunlight.h"

namespace highwall::simulate::terrain_test {
namespace {

PinholeCamera SmallCamera() {
  return {.width = 160, .height = 120, .fx = 153.75, .fy = 153.75, .cx = 79.5, .cy = 59.5};
}

// Uneven ground around the origin, 6 x 6 m, 0.25 m apart, with a boulder.
Scene MakeHills() {
  Scene scene;
  const int gravel = scene.AddTexture(std::make_unique<BakedTexture>(
      std::make_unique<GravelTexture>(GravelOptions{.seed = 5}), Eigen::Vector2f(-4.0f, -4.0f),
      Eigen::Vector2f(8.0f, 8.0f), 0.004f));
  AddSheet(
      25, 25, gravel,
      [](int i, int j) -> ReliefPoint {
        const double x = 0.25 * i - 3.0, y = 0.25 * j - 3.0;
        const Eigen::Vector3d p_W(x, y, 0.2 * std::sin(2.0 * x) * std::cos(1.7 * y));
        return {p_W, {.st = p_W.head<2>().cast<float>(), .light = 1.0f}};
      },
      &scene);
  RandomSequence random(3);
  AddBoulder(Pose::FromTangent({0.3, 0.2, 0.1}, {0, 0, 0}), {}, gravel, &random, &scene);
  return scene;
}

// Pose above the hills, looking obliquely down.
Pose Lookout() {
  Eigen::Matrix3d R_WC;
  R_WC << 1, 0, 0, 0, -0.6, 0.8, 0, -0.8, -0.6;
  return Pose(Eigen::Quaterniond(R_WC), Eigen::Vector3d(0.1, -2.0, 1.6));
}

double MeanAlbedo(const Texture& texture, float footprint, float extent) {
  const int count = static_cast<int>(extent / footprint);
  double sum = 0.0;
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2f st =
          (Eigen::Vector2f(static_cast<float>(i), static_cast<float>(j)).array() + 0.5f) *
          footprint;
      sum += static_cast<double>(texture.Albedo(st, footprint).sum()) / 3.0;
    }
  }
  return sum / (count * count);
}

TEST(Relief, DepthOfEveryPixelIsThatOfTheNearestTriangleOnItsRay) {
  const Renderer renderer(MakeHills(), SmallCamera());
  const Rendering rendering = renderer.Render(Lookout());
  const Mesh& mesh = renderer.scene().mesh;
  const Eigen::Matrix3d R_WC = Lookout().R();
  int hits = 0;
  for (int v = 3; v < 120; v += 9) {
    for (int u = 2; u < 160; u += 9) {
      const Eigen::Vector3d direction = R_WC * SmallCamera().Unproject({u, v}, 1.0);
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& [i, j, k] : mesh.triangles) {
        // z direction = a + b (B - A) + c (C - A) by elimination.
        Eigen::Matrix3d M;
        M << direction, mesh.vertices[i] - mesh.vertices[j], mesh.vertices[i] - mesh.vertices[k];
        const Eigen::Vector3d zbc = M.fullPivLu().solve(mesh.vertices[i] - Lookout().p());
        const bool inside = zbc[1] >= 0.0 && zbc[2] >= 0.0 && zbc[1] + zbc[2] <= 1.0;
        if (inside && zbc[0] > 0.0) nearest = std::min(nearest, zbc[0]);
      }
      const auto depth = static_cast<double>(rendering.depth.at<float>(v, u));
      if (std::isinf(nearest)) {
        EXPECT_EQ(depth, 0.0);
        continue;
      }
      ++hits;
      EXPECT_NEAR(depth, nearest, 5e-7);  // half a float step at 4 m
    }
  }
  EXPECT_GT(hits, 150);
}

TEST(Relief, RendersTheSameBytesOnAnyNumberOfThreadsAndInAnyOrder) {
  const Renderer one(MakeHills(), SmallCamera()), five(MakeHills(), SmallCamera());
  const Pose elsewhere = Lookout() * Pose::FromTangent({0.5, 0, 0.2}, {0, 0.4, 0});
  five.Render(elsewhere);  // tiles are filled in another order
  const cv::Mat a = one.Render(Lookout(), 1).bgr, b = five.Render(Lookout(), 5).bgr;
  EXPECT_EQ(std::memcmp(a.data, b.data, a.total() * a.elemSize()), 0);
}

TEST(Relief, RollingShutterTakesEveryRowFromItsOwnPose) {
  const Renderer renderer(MakeHills(), SmallCamera());
  const Pose other = Lookout() * Pose::FromTangent({0.05, 0, 0}, {0, 0.02, 0});
  std::vector<Pose> poses(60, Lookout());
  poses.resize(120, other);
  const cv::Mat mixed = renderer.Render(poses).depth;
  const cv::Mat upper = renderer.Render(Lookout()).depth, lower = renderer.Render(other).depth;
  EXPECT_EQ(cv::norm(mixed.rowRange(0, 60), upper.rowRange(0, 60), cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(mixed.rowRange(60, 120), lower.rowRange(60, 120), cv::NORM_INF), 0.0);
  EXPECT_THROW(renderer.Render(std::vector<Pose>(7)), InvalidArgument);
}

TEST(Relief, BouldersAreClosedAndStandOnTheirOrigin) {
  Scene scene;
  RandomSequence random(1);
  const Pose T_WB = Pose::FromTangent({1, 2, 3}, {0, 0, 0.5});
  AddBoulder(T_WB, {.radii = {0.3, 0.2, 0.25}, .sunk = 0.4}, 0, &random, &scene);
  EXPECT_EQ(scene.mesh.triangles.size(), 320u);
  Eigen::Vector3d area = Eigen::Vector3d::Zero();
  for (const auto& [a, b, c] : scene.mesh.triangles) {
    const auto& v = scene.mesh.vertices;
    area += (v[b] - v[a]).cross(v[c] - v[a]);
  }
  EXPECT_LT(area.norm(), 1e-12);  // the area vectors of a closed surface sum to zero
  for (const Eigen::Vector3d& vertex : scene.mesh.vertices) {
    EXPECT_GT(vertex.z(), 3.0 - 0.4 * 0.25 - 1e-12);
    EXPECT_LT(vertex.z(), 3.0 + (2.0 - 0.4) * 0.25 + 1e-12);
  }
}

class MeansAcrossDistances : public ::testing::TestWithParam<int> {
 protected:
  static std::unique_ptr<const Texture> Make() {
    if (GetParam() == 0) return std::make_unique<GravelTexture>(GravelOptions{.seed = 4});
    return std::make_unique<StrataTexture>(Strata(8.0f, 4), StrataColours{});
  }
};

TEST_P(MeansAcrossDistances, StayTheSame) {
  const BakedTexture texture(Make(), {0.0f, 0.0f}, {8.0f, 8.0f}, 0.008f);
  const double near = MeanAlbedo(texture, 0.008f, 4.0f);
  for (const float footprint : {0.03f, 0.1f}) {
    // Textures fade to their mean, which is sampled to a per cent or two.
    EXPECT_NEAR(MeanAlbedo(texture, footprint, 4.0f) / near, 1.0, 0.03) << footprint;
  }
}

INSTANTIATE_TEST_SUITE_P(Textures, MeansAcrossDistances, ::testing::Values(0, 1),
                         [](const auto& test) { return test.param == 0 ? "Gravel" : "Strata"; });

TEST(BakedTexture, IsItsSourceToARoundingAndRepeats) {
  const MasonryOptions tiles{
      .cell = {0.25f, 0.25f}, .shift = 0.0f, .checker = true, .contrast = 0.0f};
  const MasonryTexture source(tiles);
  const BakedTexture baked(std::make_unique<MasonryTexture>(tiles), {-1.0f, -1.0f}, {4.0f, 4.0f},
                           0.004f);
  for (float s = 0.06f; s < 1.0f; s += 0.25f) {  // within tiles, away from joints
    for (float t = -0.94f; t < 1.0f; t += 0.25f) {
      const Colour expected = source.Albedo({s, t}, 0.004f);
      // The tolerance is half a step of eight bits.
      EXPECT_LT((baked.Albedo({s, t}, 0.004f) - expected).cwiseAbs().maxCoeff(),
                0.5f / 255 + 1e-5f);
      EXPECT_LT((baked.Albedo({s + 4.0f, t - 8.0f}, 0.004f) - expected).cwiseAbs().maxCoeff(),
                0.5f / 255 + 1e-5f);
    }
  }
}

TEST(BakedTexture, FillsEachTileOnceUnderThreads) {
  const BakedTexture baked(std::make_unique<GravelTexture>(GravelOptions{}), {0, 0}, {2, 2}, 0.01f);
  std::vector<Colour> colours(64);
  ParallelFor(64, 8, [&](int i) {
    colours[static_cast<std::size_t>(i)] = baked.Albedo({0.7f, 0.3f}, 0.01f);
  });
  for (const Colour& colour : colours) EXPECT_EQ(colour, colours.front());
}

TEST(Strata, RepeatEveryPeriodAndAreLevel) {
  const Strata strata(12.0f, 9);
  for (float s = 0.1f; s < 12.0f; s += 0.77f) {
    const Strata::Place here = strata.At({s, 1.3f}), there = strata.At({s + 12.0f, 1.3f});
    EXPECT_EQ(here.layer_tone, there.layer_tone);
    EXPECT_NEAR(here.recess, there.recess, 1e-6f);
    EXPECT_NEAR(here.to_joint, there.to_joint, 1e-4f);  // of 24 m in single precision
    EXPECT_GE(here.to_bedding, 0.0f);
    EXPECT_GE(here.to_joint, 0.0f);
  }
}

TEST(Course, MeasuresItsLengthAndTurnsWithIt) {
  constexpr int kPoints = 60;
  std::vector<Eigen::Vector3d> control;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    control.emplace_back(5.0 * std::cos(angle), 5.0 * std::sin(angle), 1.0);
  }
  const Course course(control);
  // A spline cuts corners by a fraction of (2 pi / n)^2 / 6 of the radius.
  const double radius = 5.0 * (1.0 - std::pow(2.0 * std::numbers::pi / kPoints, 2) / 6.0);
  EXPECT_NEAR(course.length(), 2.0 * std::numbers::pi * radius, 1e-3);
  for (double s = -3.0; s < 40.0; s += 1.7) {
    const Course::Frame frame = course.At(s);
    EXPECT_NEAR(frame.p_W.head<2>().norm(), radius, 1e-4);
    EXPECT_NEAR(frame.forward.dot(frame.p_W), 0.0, 1e-3);
    EXPECT_NEAR(frame.left.dot(frame.p_W), -radius, 1e-3);  // anticlockwise: the middle is left
    EXPECT_LT((course.At(s + 0.1).p_W - frame.p_W).norm(), 0.1001);
    EXPECT_GT((course.At(s + 0.1).p_W - frame.p_W).norm(), 0.0999);
  }
  EXPECT_THROW(Course(std::vector<Eigen::Vector3d>(3)), InvalidArgument);
}

TEST(Sunlight, LeavesTheShadowOfARoofToTheSky) {
  Scene scene;
  const int white =
      scene.AddTexture(std::make_unique<NoiseTexture>(Rgb(1, 1, 1), 0.0f, ValueNoise{}));
  scene.AddRectangle({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, white);  // vertices far outside
  scene.AddRectangle({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}, white);        // in the shadow
  scene.AddRectangle({-3, -3, 1}, {6, 0, 0}, {0, 6, 0}, white);        // the roof
  BakeSunlight({.to_sun = {0, 0, 1}, .sun = 1.0, .sky = 0.5}, &scene);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(scene.looks[i].light, 1.5f, 1e-6f);
  for (std::size_t i = 4; i < 8; ++i) {
    EXPECT_LT(scene.looks[i].light, 0.5f);
    EXPECT_GT(scene.looks[i].light, 0.1f);
  }
  for (std::size_t i = 8; i < 12; ++i) EXPECT_NEAR(scene.looks[i].light, 1.5f, 1e-6f);
}

TEST(RoadSurface, IsRoughWhereItsStretchesSayAndClosesAfterALap) {
  constexpr double kSpeed = 0.5, kLength = 40.0;
  const RoadSurface surface(
      {{StretchKind::kBumpy, 20.0, 30.0}, {StretchKind::kLowTexture, 50.0, 60.0}}, kSpeed, kLength,
      3);
  const auto roughness = [&](double begin, double end) {
    double sum = 0.0;
    int count = 0;
    for (double s = begin; s < end; s += 0.05, ++count) {
      sum += std::pow(surface.Height(s + 0.25, 0.0) - surface.Height(s, 0.0), 2);
    }
    return std::sqrt(sum / count);
  };
  EXPECT_GT(roughness(11.0, 14.0), 2.0 * roughness(2.0, 8.0));
  EXPECT_NEAR(surface.Height(1.3, 0.4), surface.Height(1.3 + kLength, 0.4), 1e-6);
  EXPECT_GT(surface.Dust(29.0, 0.0), 0.9);
  EXPECT_LT(surface.Dust(5.0, 0.0), 0.4);
}

}  // namespace
}  // namespace highwall::simulate::terrain_test
