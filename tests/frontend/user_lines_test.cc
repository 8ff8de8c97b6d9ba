// Lines of a user's extractor in SlamSystem, and the rejection of invalid ones.
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/features/lbd_line_extractor.h>
#include <highwall/frontend/system/slam_system.h>

#include "features/frame_builder.h"
#include "support/message_of.h"
#include "support/moving_wall.h"

namespace highwall::user_lines_test {
namespace {

using testing::MovingWall;

// Detects segments by another method, which neither orders ends nor describes, and returns them in
// the same memory each time.
class UserLines final : public LineExtractor {
 public:
  int calls = 0, segments = 0;

  LineFeatures Extract(const cv::Mat& gray) override {
    ++calls;
    std::vector<LineSegment> found = detector_.Extract(gray).segments;
    for (LineSegment& segment : found) std::swap(segment.s, segment.e);
    segments += static_cast<int>(found.size());
    LineFeatures lines = DescribeLines(gray, std::move(found));
    cv::Mat own = memory_.rowRange(0, lines.descriptors.rows);
    lines.descriptors.copyTo(own);
    lines.descriptors = own;
    return lines;
  }

 private:
  LbdLineExtractor detector_{{.descriptors = false}};
  cv::Mat memory_ = cv::Mat(1000, 32, CV_8U);
};

// Returns the lines that it was given.
class Parrot final : public LineExtractor {
 public:
  LineFeatures lines{{{{10.0F, 20.0F}, {60.0F, 20.0F}}}, cv::Mat(1, 32, CV_8U, cv::Scalar(7))};

  LineFeatures Extract(const cv::Mat&) override { return lines; }
};

// Tracks ten frames of the wall.
std::unique_ptr<SlamSystem> Track(std::shared_ptr<LineExtractor> lines,
                                  std::vector<FrameResult>* results = nullptr) {
  auto slam = std::make_unique<SlamSystem>(MovingWall::Sensor(), Deterministic({}),
                                           SlamInputs{.lines = std::move(lines)});
  const MovingWall wall;
  for (int frame = 0; frame < 10; ++frame) {
    const FrameResult result = slam->Track(wall.View(frame));
    EXPECT_EQ(result.state, TrackingState::kTracking) << frame;
    if (results != nullptr) results->push_back(result);
  }
  slam->Finish();
  return slam;
}

TEST(UserLines, AreThoseOfEveryFrameAndOfTheMap) {
  const auto lines = std::make_shared<UserLines>();
  std::vector<FrameResult> results;
  const auto slam = Track(lines, &results);
  EXPECT_EQ(lines->calls, 10);
  int extracted = 0, matched = 0;
  for (const FrameResult& result : results) {
    extracted += result.lines;
    matched += result.matched_lines;
  }
  EXPECT_EQ(extracted, lines->segments);
  EXPECT_GT(matched, 0);
  EXPECT_GT(slam->map().num<MapLine>(), 0U);
}

TEST(UserLines, OfTheBuiltInExtractorGiveTheSameBitForBit) {
  const Trajectory a = Track(nullptr)->trajectory(),
                   b = Track(std::make_shared<LbdLineExtractor>())->trajectory();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].pose.Matrix(), b[i].pose.Matrix());
}

TEST(UserLines, AreRefusedNamingTheFault) {
  const auto message = [](const std::function<void(LineFeatures*)>& spoil) {
    const auto parrot = std::make_shared<Parrot>();
    spoil(&parrot->lines);
    FrameBuilder builder(MovingWall::Sensor(), {}, nullptr, parrot);
    return testing::MessageOf<InvalidArgument>([&] { builder.Build(MovingWall().View(0)); });
  };
  EXPECT_EQ(message([](LineFeatures*) {}), "");
  EXPECT_EQ(message([](LineFeatures* lines) { *lines = {}; }), "");
  EXPECT_EQ(message([](LineFeatures* lines) { lines->segments[0].e.x() = 320.0F; }),
            "lines: segment 0 ends at (320, 20), outside of the image of 320 x 240");
  EXPECT_EQ(message([](LineFeatures* lines) {
              lines->segments[0].s.y() = std::numeric_limits<float>::quiet_NaN();
            }),
            "lines: segment 0 ends at no finite place");
  EXPECT_EQ(message([](LineFeatures* lines) {
              lines->segments[0].e = {10.5F, 20.0F};
            }),
            "lines: segment 0 is shorter than a pixel");
  EXPECT_EQ(message([](LineFeatures* lines) { lines->descriptors.release(); }),
            "lines: 1 segments have 0 rows of descriptors; DescribeLines() makes them");
  EXPECT_EQ(message([](LineFeatures* lines) { lines->descriptors = cv::Mat::zeros(1, 8, CV_32F); }),
            "lines: descriptors must be CV_8U with 32 columns; DescribeLines() makes them");
}

TEST(DescribeLines, RefusesASegmentWithoutADirection) {
  const cv::Mat gray(48, 64, CV_8U, cv::Scalar(9));
  testing::ExpectError("segment 1 is shorter than a pixel", [&] {
    DescribeLines(gray, {{{1.0F, 1.0F}, {9.0F, 1.0F}}, {{5.0F, 5.0F}, {5.0F, 5.0F}}});
  });
  testing::ExpectError("must be CV_8UC1", [&] { DescribeLines({}, {}); });
  EXPECT_TRUE(DescribeLines(gray, {}).segments.empty());
}

}  // namespace
}  // namespace highwall::user_lines_test
