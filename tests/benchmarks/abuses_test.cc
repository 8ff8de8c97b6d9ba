// Each way to degrade a recording has the effect that its name states.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include <highwall/core/error.h>

#include "abused_sequence.h"
#include "abuses.h"
#include "depth_changes.h"
#include "frame_order.h"
#include "image_changes.h"

namespace highwall::bench::abuses_test {
namespace {

constexpr Stamp kInterval = 100'000'000;  // [ns]

Stamp StampOf(std::size_t frame) {
  return 1'000'000'000 + static_cast<Stamp>(frame) * kInterval;
}

// Frame i of a camera at (i, 0, 0) has the given colour and depth.
class Recording final : public Dataset {
 public:
  explicit Recording(std::size_t frames, cv::Mat bgr = {}, cv::Mat depth = {})
      : bgr_(std::move(bgr)), depth_(std::move(depth)) {
    for (std::size_t i = 0; i < frames; ++i) {
      truth_.push_back({StampOf(i), Pose::FromTangent({static_cast<double>(i), 0, 0}, {0, 0, 0})});
    }
  }

  std::size_t size() const override { return truth_.size(); }
  Stamp stamp(std::size_t index) const override { return StampOf(index); }
  const Trajectory* groundtruth() const override { return &truth_; }

  Trajectory truth_;

 private:
  // A frame without an image is filled with its index, and its depth is the index plus 1 m.
  RgbdImage DoLoad(std::size_t index) const override {
    const auto i = static_cast<double>(index);
    return {StampOf(index), bgr_.empty() ? cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(i)) : bgr_,
            depth_.empty() ? cv::Mat(24, 32, CV_32FC1, cv::Scalar(1.0 + i)) : depth_};
  }

  cv::Mat bgr_, depth_;
};

AbusedSequence Reordered(const Dataset& recording, const OrderChange& order,
                         std::uint64_t seed = 1) {
  return AbusedSequence(FramesOf(recording), {"reordered", order, {}}, seed);
}

RgbdImage Spoil(const RgbdImage& image, const ImageChange& change, std::size_t frame = 0,
                std::uint64_t seed = 1) {
  RgbdImage spoiled{image.stamp, image.bgr.clone(), image.depth.clone()};
  change(frame, simulate::CounterRandom(seed), &spoiled);
  return spoiled;
}

bool Same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

RgbdImage Grey(double level, int width = 320, int height = 240) {
  return {0, cv::Mat(height, width, CV_8UC3, cv::Scalar::all(level)),
          cv::Mat(height, width, CV_32FC1, cv::Scalar(2.0))};
}

// A wall at 2 m and, on the right, one at 3 m; the first column has no measurement.
RgbdImage Step() {
  RgbdImage image = Grey(100.0);
  image.depth.colRange(160, 320).setTo(3.0);
  image.depth.col(0).setTo(0.0);
  return image;
}

int LevelOf(const RgbdImage& image) {
  return image.bgr.at<cv::Vec3b>(0, 0)[0];
}

double LightOf(const cv::Mat& bgr) {
  double sum = 0.0;
  for (const cv::Vec3b& pixel : cv::Mat_<cv::Vec3b>(bgr)) {
    for (int c = 0; c < 3; ++c) sum += std::pow(pixel[c] / 255.0, 2.2);
  }
  return sum;
}

// --- The order of frames ---

TEST(FrameOrder, EveryNthKeepsTheFirstOfN) {
  const Recording recording(10);
  const AbusedSequence kept = Reordered(recording, EveryNth(4));
  ASSERT_EQ(kept.size(), 3U);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept.stamp(i), StampOf(4 * i));
    EXPECT_EQ(LevelOf(*kept.Load(i)), static_cast<int>(4 * i));
  }
}

TEST(FrameOrder, GapsFollowEachOneAndAHalfSeconds) {
  const Recording recording(45);  // 15 frames are shown, 5 are not
  const AbusedSequence kept = Reordered(recording, Gaps(0.5));
  std::vector<Stamp> expected;
  for (std::size_t i = 0; i < 45; ++i) {
    if (i % 20 < 15) expected.push_back(StampOf(i));
  }
  ASSERT_EQ(kept.size(), expected.size());
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept.stamp(i), expected[i]);
}

TEST(FrameOrder, LateDepthIsThatOfFramesBefore) {
  const Recording recording(6);
  const AbusedSequence late = Reordered(recording, DepthLags(2));
  ASSERT_EQ(late.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const RgbdImage image = *late.Load(i);
    EXPECT_EQ(LevelOf(image), static_cast<int>(i));
    EXPECT_EQ(image.depth.at<float>(0, 0), i < 2 ? 1.0F : static_cast<float>(i) - 1.0F);
    EXPECT_EQ(late.groundtruth()->at(i).pose.p().x(), static_cast<double>(i));
  }
}

TEST(FrameOrder, SwappedFramesChangePlacesWithANeighbourAndKeepTheStamps) {
  const Recording recording(250);
  const AbusedSequence swapped = Reordered(recording, SwappedFrames(5.0));
  ASSERT_EQ(swapped.size(), 250U);
  std::size_t swaps = 0;
  for (std::size_t i = 0; i < 250; ++i) {
    EXPECT_EQ(swapped.stamp(i), StampOf(i));
    const RgbdImage image = *swapped.Load(i);
    const auto shown = static_cast<std::size_t>(LevelOf(image));
    EXPECT_EQ(image.depth.at<float>(0, 0), static_cast<float>(shown) + 1.0F);
    EXPECT_EQ(swapped.groundtruth()->at(i).stamp, StampOf(i));
    EXPECT_EQ(swapped.groundtruth()->at(i).pose.p().x(), static_cast<double>(shown));
    if (shown == i) continue;
    if (shown == i + 1) {
      ++swaps;
      EXPECT_EQ(LevelOf(*swapped.Load(i + 1)), static_cast<int>(i));
    } else {
      EXPECT_EQ(shown + 1, i);
    }
  }
  // A draw of 1/5 for each frame that is not the second of a pair: 250 / 6 = 42, sigma 5.
  EXPECT_GE(swaps, 27U);
  EXPECT_LE(swaps, 57U);
}

TEST(FrameOrder, DoubledFramesShowTheOneBeforeWhileTheCameraMovesOn) {
  const Recording recording(250);
  const AbusedSequence doubled = Reordered(recording, DoubledFrames(5.0));
  int before = LevelOf(*doubled.Load(0));
  EXPECT_EQ(before, 0);
  int repeats = 0;
  for (std::size_t i = 1; i < 250; ++i) {
    const int shown = LevelOf(*doubled.Load(i));
    EXPECT_TRUE(shown == before || shown == static_cast<int>(i)) << i;
    EXPECT_EQ(doubled.groundtruth()->at(i).pose.p().x(), static_cast<double>(i));
    repeats += shown == before ? 1 : 0;
    before = shown;
  }
  EXPECT_NEAR(repeats, 50, 19);  // 3 sigma of a binomial distribution
}

TEST(FrameOrder, AKidnappedCameraIsElsewhereInTheMiddle) {
  const Recording home(10), elsewhere(4, cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(200)));
  const AbusedSequence sequence = Reordered(home, CutIn(FramesOf(elsewhere)));
  ASSERT_EQ(sequence.size(), 14U);
  ASSERT_EQ(sequence.groundtruth()->size(), 10U);
  std::size_t at_home = 0;
  for (std::size_t i = 0; i < 14; ++i) {
    EXPECT_EQ(sequence.stamp(i), StampOf(i));
    EXPECT_EQ(sequence.IsElsewhere(i), i >= 5 && i < 9);
    if (sequence.IsElsewhere(i)) {
      EXPECT_EQ(LevelOf(*sequence.Load(i)), 200);
      continue;
    }
    EXPECT_EQ(LevelOf(*sequence.Load(i)), static_cast<int>(at_home));
    EXPECT_EQ(sequence.groundtruth()->at(at_home).stamp, sequence.stamp(i));
    EXPECT_EQ(sequence.groundtruth()->at(at_home).pose.p().x(), static_cast<double>(at_home));
    ++at_home;
  }
}

TEST(AbusedSequence, TheTruthOfAFrameIsTheNearestWithinTwentyMilliseconds) {
  Recording recording(4);
  recording.truth_[1].stamp += 20'000'000;
  recording.truth_[2].stamp += 20'000'001;
  const AbusedSequence same(FramesOf(recording), {"untouched", {}, {}}, 1);
  ASSERT_EQ(same.groundtruth()->size(), 3U);
  EXPECT_EQ(same.groundtruth()->at(1).stamp, StampOf(1));
  EXPECT_EQ(same.groundtruth()->at(2).stamp, StampOf(3));
}

TEST(AbusedSequence, RefusesOrdersThatLeaveNothingOrGoBackInTime) {
  const Recording recording(3);
  const auto none = [](const auto&, const auto&) { return std::vector<AbusedFrame>(); };
  const auto back = [](std::vector<AbusedFrame> frames, const auto&) {
    frames[2].stamp = frames[1].stamp;
    return frames;
  };
  EXPECT_THROW(Reordered(recording, none), InvalidArgument);
  EXPECT_THROW(Reordered(recording, back), InvalidArgument);
}

TEST(AbusedSequence, HoldsTheFirstFramesAlone) {
  const Recording recording(9);
  EXPECT_EQ(FramesOf(recording).size(), 9U);
  EXPECT_EQ(FramesOf(recording, 5).size(), 5U);
  EXPECT_EQ(FramesOf(recording, 50).size(), 9U);
}

// --- Colour ---

TEST(MotionBlur, SpreadsAPointAlongAPathOfItsLength) {
  RgbdImage image = Grey(0.0);
  image.bgr.at<cv::Vec3b>(120, 160) = {255, 255, 255};
  std::set<int> directions;
  for (std::size_t frame = 0; frame < 20; ++frame) {
    const cv::Mat blurred = Spoil(image, MotionBlur(15.0), frame).bgr;
    double longest = 0.0;
    cv::Point from, to;
    std::vector<cv::Point> lit;
    for (int v = 0; v < blurred.rows; ++v) {
      for (int u = 0; u < blurred.cols; ++u) {
        if (blurred.at<cv::Vec3b>(v, u)[0] > 20) lit.emplace_back(u, v);
      }
    }
    for (const cv::Point& a : lit) {
      for (const cv::Point& b : lit) {
        if (cv::norm(a - b) > longest)
          std::tie(longest, from, to) = std::tuple(cv::norm(a - b), a, b);
      }
    }
    EXPECT_NEAR(longest, 15.0, std::sqrt(2.0)) << "ends lie between pixels";
    EXPECT_LE(lit.size(), 50U) << "a line three pixels wide at most";
    EXPECT_LE(cv::norm(0.5 * cv::Point2d(from + to) - cv::Point2d(160, 120)), 1.0);
    const double angle = std::atan2(to.y - from.y, to.x - from.x) / std::numbers::pi;
    directions.insert(static_cast<int>(std::floor(4.0 * (angle - std::floor(angle)))));
    // Total light is preserved, except for the rounding of some fifty dark pixels.
    EXPECT_NEAR(LightOf(blurred) / LightOf(image.bgr), 1.0, 0.03);
  }
  EXPECT_EQ(directions.size(), 4U) << "every quarter of the half circle";
}

TEST(MotionBlur, ChangesNothingWhereTheImageIsPlainNorDepth) {
  const RgbdImage image = Step();
  const RgbdImage blurred = Spoil(image, MotionBlur(30.0));
  EXPECT_TRUE(Same(blurred.bgr, image.bgr));
  EXPECT_TRUE(Same(blurred.depth, image.depth));
}

TEST(Gamma, JumpsBetweenTwoExponentsByTurns) {
  for (const std::size_t frame : {0U, 14U, 15U, 29U, 30U}) {
    const double gamma = frame / 15 == 1 ? 2.5 : 0.4;
    const int expected = static_cast<int>(std::lround(255.0 * std::pow(100.0 / 255.0, gamma)));
    EXPECT_EQ(LevelOf(Spoil(Grey(100.0), GammaJumps(0.4, 2.5, 15), frame)), expected) << frame;
  }
}

TEST(Gamma, IsDrawnForEachFrameBetweenTheTwo) {
  std::set<int> levels;
  for (std::size_t frame = 0; frame < 50; ++frame) {
    levels.insert(LevelOf(Spoil(Grey(100.0), RandomGamma(0.4, 2.5), frame)));
  }
  EXPECT_GE(*levels.begin(), 25);    // 255 (100 / 255)^2.5 = 24.6
  EXPECT_LE(*levels.rbegin(), 175);  // to the power of 0.4: 175.3
  EXPECT_GE(levels.size(), 30U);
}

TEST(Exposure, MultipliesLightAndClips) {
  const ImageChange twice = ExposureJumps(2.0, 2.0, 15);
  EXPECT_EQ(LevelOf(Spoil(Grey(0.0), twice)), 0);
  EXPECT_EQ(LevelOf(Spoil(Grey(100.0), twice)), std::lround(100.0 * std::pow(2.0, 1.0 / 2.2)));
  EXPECT_EQ(LevelOf(Spoil(Grey(200.0), twice)), 255);
}

TEST(Exposure, HoldsForASpellAndThenJumps) {
  const ImageChange jumps = ExposureJumps(0.125, 8.0, 15);
  std::set<int> levels;
  for (std::size_t spell = 0; spell < 20; ++spell) {
    const int level = LevelOf(Spoil(Grey(60.0), jumps, 15 * spell));
    EXPECT_EQ(LevelOf(Spoil(Grey(60.0), jumps, 15 * spell + 14)), level);
    EXPECT_GE(level, 23);   // 60 / 8^(1 / 2.2) = 23.3
    EXPECT_LE(level, 155);  // 60 * 8^(1 / 2.2) = 154.4
    levels.insert(level);
  }
  EXPECT_GE(levels.size(), 15U);
}

TEST(ColourNoise, HasItsSigmaAndNoMean) {
  const RgbdImage image = Grey(128.0);
  const RgbdImage noisy = Spoil(image, ColourNoise(10.0), 3);
  cv::Scalar mean, sigma;
  cv::meanStdDev(noisy.bgr, mean, sigma);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(mean[c], 128.0, 0.15);  // 4 sigma of 76800 pixels
    EXPECT_NEAR(sigma[c], 10.0, 0.15);
  }
  EXPECT_FALSE(Same(Spoil(image, ColourNoise(10.0), 4).bgr, noisy.bgr));
  EXPECT_TRUE(Same(noisy.depth, image.depth));
}

TEST(HalfCovered, HalfIsDarkAndWithoutDepthAndTheOtherAsItWas) {
  const RgbdImage image = Grey(128.0);
  std::set<std::pair<int, int>> corners;
  for (std::size_t frame = 0; frame < 120; frame += 30) {
    const RgbdImage covered = Spoil(image, HalfCovered(30), frame);
    const cv::Mat dark = covered.depth == 0.0F;
    EXPECT_EQ(cv::countNonZero(dark), 320 * 120);
    EXPECT_NEAR(cv::mean(covered.bgr, dark)[0], 4.0, 0.1);
    EXPECT_TRUE(Same(Spoil(image, HalfCovered(30), frame + 29).depth, covered.depth));
    const cv::Mat clear = covered.depth > 0.0F;
    cv::Mat difference;
    cv::absdiff(covered.bgr, image.bgr, difference);
    EXPECT_EQ(cv::mean(difference, clear), cv::Scalar());
    const cv::Rect half = cv::boundingRect(dark);
    EXPECT_EQ(half.area(), 320 * 120) << "a rectangle";
    corners.insert({half.x + half.width, half.y + half.height});
  }
  EXPECT_EQ(corners.size(), 3U) << "left, right, upper, lower: the last ends where the second does";
}

// --- Depth ---

TEST(DepthHoles, TakeTheirShareOfTheReadingsAndLeaveTheRest) {
  const RgbdImage image = Step();
  const int readings = cv::countNonZero(image.depth);
  for (const double share : {0.1, 0.3, 0.6, 0.9}) {
    const RgbdImage holed = Spoil(image, DepthHoles(share), 7);
    const cv::Mat left = holed.depth > 0.0F;
    // The tolerance covers equal scores: in a plain image, rows with the same distance to the edge.
    EXPECT_NEAR(cv::countNonZero(left), (1.0 - share) * readings, 10) << share;
    cv::Mat difference;
    cv::absdiff(holed.depth, image.depth, difference);
    difference.setTo(0.0, holed.depth == 0.0F);
    EXPECT_EQ(cv::countNonZero(difference), 0) << "what is left is as it was";
    EXPECT_TRUE(Same(holed.bgr, image.bgr));
  }
  EXPECT_TRUE(Same(Spoil(image, DepthHoles(0.0)).depth, image.depth));
  EXPECT_EQ(cv::countNonZero(Spoil(image, DepthHoles(1.0)).depth), 0);
}

TEST(DepthHoles, OpenAlongEdgesFirst) {
  const cv::Mat holed = Spoil(Step(), DepthHoles(0.3)).depth;
  // The depth step, and the border of the existing hole.
  EXPECT_EQ(cv::countNonZero(holed.colRange(159, 161)), 0);
  EXPECT_EQ(cv::countNonZero(holed.col(1)), 0);
  const auto taken = [&](int begin, int end) {
    const cv::Mat part = holed.colRange(begin, end);
    return 1.0 - static_cast<double>(cv::countNonZero(part)) / static_cast<double>(part.total());
  };
  EXPECT_GT(taken(154, 166), 0.7);
  EXPECT_LT(taken(60, 100), 0.5);
}

TEST(DepthHoles, AreBlobsThatLastForAWhile) {
  const cv::Mat holed = Spoil(Grey(100.0), DepthHoles(0.3), 0).depth == 0.0F;
  cv::Mat inner;  // holes whose neighbours are all holes: 0.3^8 for salt and pepper
  cv::erode(holed, inner, {});
  EXPECT_GT(cv::countNonZero(inner), 0.7 * cv::countNonZero(holed));
  const auto shared = [&](std::size_t frame) {
    const cv::Mat other = Spoil(Grey(100.0), DepthHoles(0.3), frame).depth == 0.0F;
    return static_cast<double>(cv::countNonZero(holed & other)) / cv::countNonZero(holed);
  };
  EXPECT_GT(shared(1), 0.85);
  EXPECT_LT(shared(60), 0.55);  // 0.3 by chance
}

TEST(DepthCut, KeepsNearerDepth) {
  const RgbdImage image = Step();
  const cv::Mat cut = Spoil(image, DepthCut(2.0)).depth;
  EXPECT_EQ(cv::countNonZero(cut.colRange(160, 320)), 0);
  EXPECT_TRUE(Same(cut.colRange(0, 160), image.depth.colRange(0, 160)));
}

TEST(NoDepth, BeginsWithItsFrame) {
  const RgbdImage image = Step();
  EXPECT_TRUE(Same(Spoil(image, NoDepthFrom(50), 49).depth, image.depth));
  EXPECT_EQ(cv::countNonZero(Spoil(image, NoDepthFrom(50), 50).depth), 0);
  EXPECT_EQ(cv::countNonZero(Spoil(image, NoDepthFrom(50), 51).depth), 0);
  EXPECT_TRUE(Same(Spoil(image, NoDepthFrom(50), 51).bgr, image.bgr));
}

TEST(DepthNoise, GrowsWithTheSquareOfTheDistance) {
  const RgbdImage image = Step();
  const cv::Mat noisy = Spoil(image, DepthNoiseOf(0.005)).depth;
  const auto expect = [](const cv::Mat& part, double z) {
    cv::Scalar mean, sigma;
    cv::meanStdDev(part, mean, sigma);
    EXPECT_NEAR(mean[0], z, 0.001);
    EXPECT_NEAR(sigma[0] / (0.005 * z * z), 1.0, 0.015);  // 4 sigma of 38000 readings
  };
  expect(noisy.colRange(1, 160), 2.0);
  expect(noisy.colRange(160, 320), 3.0);
  EXPECT_EQ(cv::countNonZero(noisy.col(0)), 0);
}

// --- All of them ---

// Texture and a step, so that each degradation has an effect.
Recording TexturedRecording(std::size_t frames) {
  cv::Mat bgr(240, 320, CV_8UC3);
  cv::RNG(7).fill(bgr, cv::RNG::UNIFORM, 0, 256);
  return Recording(frames, bgr, Step().depth);
}

TEST(AllAbuses, HaveNamesOfTheirOwnAndBeginWithNone) {
  const Recording second(3);
  const std::vector<Abuse> abuses = AllAbuses(&second);
  EXPECT_EQ(abuses.front().name, "untouched");
  EXPECT_FALSE(abuses.front().order);
  EXPECT_FALSE(abuses.front().image);
  std::set<std::string> names;
  for (const Abuse& abuse : abuses) names.insert(abuse.name);
  EXPECT_EQ(names.size(), abuses.size());
  EXPECT_TRUE(names.contains("kidnapped"));
  EXPECT_EQ(AllAbuses(nullptr).size() + 1, abuses.size());
}

TEST(AllAbuses, GiveTheSameBytesForTheSameSeedInAnyOrderOfLoading) {
  const Recording recording = TexturedRecording(60), second = TexturedRecording(5);
  const RgbdImage before = *recording.Load(0);
  const RgbdImage kept{before.stamp, before.bgr.clone(), before.depth.clone()};
  for (const Abuse& abuse : AllAbuses(&second)) {
    SCOPED_TRACE(abuse.name);
    const AbusedSequence a(FramesOf(recording), abuse, 5), b(FramesOf(recording), abuse, 5);
    ASSERT_EQ(a.size(), b.size());
    const std::size_t last = a.size() - 1;
    const RgbdImage a_first = *a.Load(0), a_last = *a.Load(last);
    EXPECT_EQ(a_last.stamp, a.stamp(last));
    const RgbdImage b_last = *b.Load(last), b_first = *b.Load(0);
    EXPECT_TRUE(Same(a_first.bgr, b_first.bgr) && Same(a_first.depth, b_first.depth));
    EXPECT_TRUE(Same(a_last.bgr, b_last.bgr) && Same(a_last.depth, b_last.depth));
    for (std::size_t i = 0; i < a.size(); ++i) {
      EXPECT_EQ(a.stamp(i), b.stamp(i));
      EXPECT_TRUE(i == 0 || a.stamp(i) > a.stamp(i - 1));
      EXPECT_EQ(a.frames()[i].colour, b.frames()[i].colour);
    }
  }
  EXPECT_TRUE(Same(before.bgr, kept.bgr) && Same(before.depth, kept.depth))
      << "the recording's own";
}

TEST(AllAbuses, ThatAreRandomDifferFromSeedToSeed) {
  const Recording recording = TexturedRecording(60);
  const std::set<std::string> random{
      "blur 15 px",       "gamma 0.4 to 2.5 each frame", "exposure 1/8 to 8", "noise 10",
      "depth holes 60 %", "depth noise 5 mm at 1 m",     "swapped frames",    "doubled frames"};
  std::size_t found = 0;
  for (const Abuse& abuse : AllAbuses(nullptr)) {
    if (!random.contains(abuse.name)) continue;
    ++found;
    SCOPED_TRACE(abuse.name);
    const AbusedSequence a(FramesOf(recording), abuse, 1), b(FramesOf(recording), abuse, 2);
    if (abuse.order) {
      EXPECT_FALSE(std::ranges::equal(a.frames(), b.frames(), {}, &AbusedFrame::colour,
                                      &AbusedFrame::colour));
    } else {
      EXPECT_FALSE(Same(a.Load(0)->bgr, b.Load(0)->bgr) &&
                   Same(a.Load(0)->depth, b.Load(0)->depth));
    }
  }
  EXPECT_EQ(found, random.size());
}

}  // namespace
}  // namespace highwall::bench::abuses_test
