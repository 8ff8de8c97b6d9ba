// Patches of landmarks aligned to images taken from elsewhere.
#include "local/corner_patch.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "local/corner_refiner.h"

namespace highwall::corner_patch_test {
namespace {

constexpr PyramidOptions kPyramid{};

// Returns an image of blobs of some six pixels.
cv::Mat Texture(int seed) {
  cv::RNG rng(static_cast<std::uint64_t>(seed));
  cv::Mat noise(240, 320, CV_32FC1), image;
  rng.fill(noise, cv::RNG::NORMAL, 0.0, 1.0);
  cv::GaussianBlur(noise, noise, cv::Size(), 2.5);
  noise.convertTo(image, CV_8UC1, 250.0, 128.0);
  return image;
}

// Returns the image whose pixel `A (x - from) + to` shows what `image` shows at x.
cv::Mat Warped(const cv::Mat& image, const Eigen::Matrix2d& A, const Eigen::Vector2d& from,
               const Eigen::Vector2d& to) {
  const Eigen::Vector2d t = to - A * from;
  const cv::Mat warp = (cv::Mat_<double>(2, 3) << A(0, 0), A(0, 1), t.x(), A(1, 0), A(1, 1), t.y());
  cv::Mat warped;
  cv::warpAffine(image, warped, warp, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return warped;
}

// Returns a darker image with the noise of a sensor.
cv::Mat SeenBy(const cv::Mat& image, int seed) {
  cv::RNG rng(static_cast<std::uint64_t>(seed));
  cv::Mat seen, noise(image.size(), CV_32FC1);
  rng.fill(noise, cv::RNG::NORMAL, 0.0, 2.0);
  image.convertTo(seen, CV_32FC1, 0.8, -10.0);
  seen += noise;
  seen.convertTo(seen, CV_8UC1);
  return seen;
}

// Returns the sharpest corner near the middle of the image.
Eigen::Vector2d Corner(const cv::Mat& image) {
  cv::Mat mask = cv::Mat::zeros(image.size(), CV_8UC1);
  mask(cv::Rect(100, 80, 120, 80)) = 255;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(image, corners, 1, 0.01, 1.0, mask, 7);
  return {corners.at(0).x, corners.at(0).y};
}

const Eigen::Matrix2d kTurnedAndNearer = 1.1 * Eigen::Rotation2Dd(0.2).toRotationMatrix();

TEST(CornerPatch, IsFoundInATurnedAndDarkerImageToATenthOfAPixelOfItsLevel) {
  for (const int octave : {0, 2, 4}) {
    const double scale = std::pow(kPyramid.scale_factor, octave);
    for (int seed = 1; seed <= 10; ++seed) {
      const cv::Mat first = Texture(seed);
      const Eigen::Vector2d from = Corner(first), to = from + Eigen::Vector2d(11.4, -7.4);
      const ImageLevels image(SeenBy(Warped(first, kTurnedAndNearer, from, to), seed + 100),
                              kPyramid);
      const auto patch = CutPatch(ImageLevels(first, kPyramid), octave, from, KeyFrameId(0));
      ASSERT_TRUE(patch);
      const Eigen::Vector2d start = to + scale * Eigen::Vector2d(0.9, -0.7);
      const auto found = AlignPatch(*patch, kTurnedAndNearer.inverse(), image, octave, start);
      ASSERT_TRUE(found) << "level " << octave << ", seed " << seed;
      EXPECT_LT((*found - to).norm(), 0.1 * scale) << "level " << octave << ", seed " << seed;
    }
  }
}

TEST(CornerPatch, IsNotFoundWhereTheImageShowsSomethingElse) {
  const Eigen::Vector2d pixel(150.0, 120.0);
  const auto patch = CutPatch(ImageLevels(Texture(1), kPyramid), 0, pixel, KeyFrameId(0));
  ASSERT_TRUE(patch);
  for (int seed = 2; seed < 30; ++seed) {
    const ImageLevels other(Texture(seed), kPyramid);
    EXPECT_FALSE(AlignPatch(*patch, Eigen::Matrix2d::Identity(), other, 0, pixel)) << seed;
  }
  const ImageLevels plain(cv::Mat(240, 320, CV_8UC1, cv::Scalar(90)), kPyramid);
  EXPECT_FALSE(AlignPatch(*patch, Eigen::Matrix2d::Identity(), plain, 0, pixel));
}

TEST(CornerPatch, IsNotSoughtFartherThanTwoPixelsNorBeyondTheImage) {
  const ImageLevels image(Texture(1), kPyramid);
  const Eigen::Vector2d pixel(150.0, 120.0);
  const Eigen::Matrix2d same = Eigen::Matrix2d::Identity();
  const auto patch = CutPatch(image, 0, pixel, KeyFrameId(0));
  ASSERT_TRUE(patch);
  EXPECT_TRUE(AlignPatch(*patch, same, image, 0, pixel + Eigen::Vector2d(1.5, 0.0)));
  EXPECT_FALSE(AlignPatch(*patch, same, image, 0, pixel + Eigen::Vector2d(2.5, 0.0)));
  EXPECT_FALSE(AlignPatch(*patch, same, image, 0, {2.0, 120.0}));
  EXPECT_FALSE(AlignPatch(*patch, same, image, 0, {400.0, -7.0}));
  // Rotated by 45 degrees and twice as large, the patch would need more pixels than are stored.
  EXPECT_FALSE(AlignPatch(*patch, 2.5 * same, image, 0, pixel));
  EXPECT_FALSE(CutPatch(image, 0, {8.0, 120.0}, KeyFrameId(0)));
  EXPECT_FALSE(CutPatch(image, 0, {150.0, 232.0}, KeyFrameId(0)));
  EXPECT_FALSE(CutPatch(image, kPyramid.levels, pixel, KeyFrameId(0)));
}

// A wall 2 m in front of a camera that moves along it by `shift` [m]; every keyframe sees the same
// corners on it.
struct Wall {
  static constexpr double kDepth = 2.0;
  PinholeCamera camera{
      .width = 320, .height = 240, .fx = 260.0, .fy = 260.0, .cx = 159.5, .cy = 119.5};
  cv::Mat first = Texture(7);
  Eigen::Vector3d shift{0.05, -0.03, 0.0};
  Eigen::Vector2d moved = -260.0 / kDepth * shift.head<2>();  // [px] motion of the image
  std::vector<Eigen::Vector2d> corners;                       // [px] in the first image

  Wall() {
    for (int v = 40; v <= 200; v += 20) {
      for (int u = 40; u <= 280; u += 20) corners.emplace_back(u + 0.3, v - 0.2);
    }
  }

  cv::Mat Second() const {
    return Warped(first, Eigen::Matrix2d::Identity(), Eigen::Vector2d::Zero(), moved);
  }

  // Adds observations found `off` from the true positions.
  TrackedFrame See(const cv::Mat& gray, const Pose& T_WC, const Eigen::Vector2d& at,
                   const Eigen::Vector2d& off) const {
    auto features = std::make_shared<FrameFeatures>();
    features->gray = gray;
    for (const Eigen::Vector2d& corner : corners) {
      PointFeature feature;
      feature.pixel = (corner + at + off).cast<float>();
      feature.uv = camera.UndistortPixel(feature.pixel.cast<double>());
      feature.noise.px = 1.5F;
      feature.refined_noise_px = 0.5F;
      features->points.push_back(feature);
    }
    features->point_descriptors = cv::Mat::zeros(static_cast<int>(corners.size()), 32, CV_8UC1);
    TrackedFrame tracked;
    tracked.frame.features = features;
    tracked.T_WC = T_WC;
    tracked.points.assign(corners.size(), kNoId);
    return tracked;
  }
};

TEST(CornerRefiner, MovesCornersOfLandmarksToWhereTheyLookAsTheyDidFirst) {
  const Wall wall;
  const CornerRefiner refiner(wall.camera);
  Map map;
  const TrackedFrame first =
      wall.See(wall.first, Pose(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero());
  KeyFrame& keyframe = map.AddKeyFrame(first.frame, first.T_WC);
  std::vector<PointId> points;
  for (std::size_t i = 0; i < wall.corners.size(); ++i) {
    const Eigen::Vector3d p_W = wall.camera.Unproject(wall.corners[i], Wall::kDepth);
    points.push_back(map.Add<MapPoint>(p_W, 0).id);
    map.Observe(keyframe.id, static_cast<int>(i), points.back());
  }
  refiner.Remember(keyframe, ImageLevels(wall.first, kPyramid), &map);

  const Pose T_WC(Eigen::Quaterniond::Identity(), wall.shift);
  const Eigen::Vector2d off(0.7, 0.6);
  TrackedFrame second = wall.See(wall.Second(), T_WC, wall.moved, off);
  second.points = points;
  second.points.front() = kNoId;  // without a landmark it stays where it is
  const auto refined =
      refiner.Refine(second, ImageLevels(second.frame.features->gray, kPyramid), map);
  EXPECT_TRUE(refined->gray.empty());
  int found = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const double error = (refined->points[i].uv - wall.corners[i] - wall.moved).norm();
    EXPECT_TRUE(error < 0.1 || std::abs(error - off.norm()) < 1e-6) << error;
    EXPECT_EQ(refined->points[i].refined, error < 0.1);
    EXPECT_EQ(refined->points[i].noise.px, error < 0.1 ? 0.5F : 1.5F);
    EXPECT_EQ(refined->point_grid.Query(refined->points[i].uv, 1e-3, 0, 0),
              std::vector<int>{static_cast<int>(i)});
    if (error < 0.1) ++found;
  }
  EXPECT_GT(found, 0.9 * static_cast<double>(points.size()));
  EXPECT_EQ(refined->points.front().uv, second.frame.features->points.front().uv);

  // After the keyframe with the patches is removed, another one anchors its pose.
  const KeyFrame& other = map.AddKeyFrame(second.frame, T_WC);
  for (std::size_t i = 1; i < points.size(); ++i) {
    map.Observe(other.id, static_cast<int>(i), points[i]);
  }
  map.RemoveKeyFrame(keyframe.id, other.id);
  ASSERT_NE(map.Find(points[1]), nullptr);
  const auto again =
      refiner.Refine(second, ImageLevels(second.frame.features->gray, kPyramid), map);
  EXPECT_EQ(again->points[1].uv, refined->points[1].uv);
}

// Returns which of the wall's corners get a patch with that depth around them.
std::vector<bool> Remembered(const Wall& wall, const cv::Mat& depth, int octave = 0) {
  const CornerRefiner refiner(wall.camera);
  Map map;
  TrackedFrame seen =
      wall.See(wall.first, Pose(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero());
  auto features = std::make_shared<FrameFeatures>(*seen.frame.features);
  for (PointFeature& point : features->points) point.octave = octave;
  features->depth_grid = DepthGrid(wall.camera).Sample(depth, 0.1, 10.0);
  seen.frame.features = features;
  const KeyFrame& keyframe = map.AddKeyFrame(seen.frame, seen.T_WC);
  for (std::size_t i = 0; i < wall.corners.size(); ++i) {
    const Eigen::Vector3d p_W = wall.camera.Unproject(wall.corners[i], Wall::kDepth);
    map.Observe(keyframe.id, static_cast<int>(i), map.Add<MapPoint>(p_W, 0).id);
  }
  refiner.Remember(keyframe, ImageLevels(wall.first, kPyramid), &map);
  std::vector<bool> has;
  for (const PointId id : map.ids<MapPoint>()) has.push_back(map.Find(id)->patch != nullptr);
  return has;
}

TEST(CornerRefiner, TakesNoPatchAcrossAnEdgeOfDepth) {
  const Wall wall;
  cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(Wall::kDepth));
  depth(cv::Rect(160, 0, 160, 240)) = 3.0F;
  depth(cv::Rect(0, 0, 320, 90)) = 0.0F;  // unmeasured depth contradicts nothing
  const std::vector<bool> has = Remembered(wall, depth);
  for (std::size_t i = 0; i < has.size(); ++i) {
    // Half a patch and a cell of 4 px away from the edge a corner has a patch; beyond it, none.
    const double u = wall.corners[i].x(), v = wall.corners[i].y();
    const bool apart = u < 160 - 9 || v<90 - 9, beside = u> 160 - 4 && v > 90 + 9;
    EXPECT_TRUE(has[i] || !apart) << u << ", " << v;
    EXPECT_FALSE(has[i] && beside) << u << ", " << v;
  }
}

TEST(CornerRefiner, TakesNoPatchThatSpansTooWideAnAngle) {
  const Wall wall;  // focal length 260 px: 4.5 px at level 0 are 1 degree
  const cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(Wall::kDepth));
  const auto count = [&](int octave) {
    return std::ranges::count(Remembered(wall, depth, octave), true);
  };
  EXPECT_EQ(count(0), std::ssize(wall.corners));
  EXPECT_EQ(count(1), std::ssize(wall.corners)) << "4.5 * 1.2 < 0.0215 * 260";
  EXPECT_EQ(count(2), 0);
}

}  // namespace
}  // namespace highwall::corner_patch_test
