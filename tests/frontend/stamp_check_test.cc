#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/frontend/input/stamp_check.h>

namespace highwall::stamp_check_test {
namespace {

constexpr Stamp kMillisecond = 1'000'000;  // [ns]
constexpr Stamp kDate = 1'305'031'102;     // [s] since 1970

std::vector<Stamp> Regular(double interval, std::size_t frames = 60, Stamp first = 0) {
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < frames; ++i) {
    stamps.push_back(first + FromSeconds(static_cast<double>(i) * interval));
  }
  return stamps;
}

// Returns the only finding.
StampFinding OnlyFinding(const std::vector<Stamp>& stamps) {
  const std::vector<StampFinding> findings = CheckStamps(stamps);
  EXPECT_EQ(findings.size(), 1U);
  return findings.empty() ? StampFinding() : findings.front();
}

TEST(StampCheck, SaysNothingOfCamerasOfAnyRate) {
  // 1, 2, 6, 15, 30, 60, 90, 240 and 500 Hz.
  for (const double rate : {1.0, 2.0, 6.0, 15.0, 30.0, 60.0, 90.0, 240.0, 500.0}) {
    EXPECT_TRUE(CheckStamps(Regular(1.0 / rate, 60, kDate * 1'000'000'000)).empty()) << rate;
    EXPECT_TRUE(CheckStamps(Regular(1.0 / rate, 60, 123'456'789)).empty()) << rate;
  }
}

TEST(StampCheck, SaysNothingOfJitterOmissionsAndPauses) {
  // Of a thousand draws none has a finding: the rate is below 3 in 1000 with 95 % confidence.
  for (std::uint32_t seed = 1; seed <= 1000; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const double rate = 5.0 + 85.0 * uniform(random);
    const double left_out = 0.6 * uniform(random), jitter = 0.3 * uniform(random) / rate;
    std::vector<Stamp> stamps;
    double pause = 0.0;
    for (int i = 0; i < 400; ++i) {
      if (uniform(random) < 0.01) pause += 100.0 * uniform(random);
      if (uniform(random) < left_out) continue;
      stamps.push_back(FromSeconds(i / rate + pause + jitter * uniform(random)));
    }
    EXPECT_TRUE(CheckStamps(stamps).empty()) << seed << ": " << CheckStamps(stamps).front().text;
  }
}

TEST(StampCheck, SaysNothingOfACameraThatHalvesItsRateInTheDark) {
  std::vector<Stamp> stamps = Regular(1.0 / 60.0, 200);
  for (const Stamp stamp : Regular(0.2, 100)) stamps.push_back(stamps[199] + 20'000'000 + stamp);
  EXPECT_TRUE(CheckStamps(stamps).empty());
}

TEST(StampCheck, NamesTheUnitOfStampsThatAreNotSeconds) {
  const StampFinding milliseconds = OnlyFinding(Regular(33.0));
  EXPECT_EQ(milliseconds.kind, StampFindingKind::kUnit);
  EXPECT_EQ(milliseconds.text, "stamps are likely milliseconds: they are 33 apart");
  EXPECT_EQ(milliseconds.remedy, "divide them by 1000 to have seconds");
  EXPECT_NE(OnlyFinding(Regular(33'333.0)).text.find("likely microseconds"), std::string::npos);
  EXPECT_NE(OnlyFinding(Regular(33'333'333.0)).text.find("likely nanoseconds"), std::string::npos);
  EXPECT_NE(OnlyFinding(Regular(33e-6)).text.find("too near together"), std::string::npos);
}

TEST(StampCheck, ImagesFarApartSince1970AreNoMilliseconds) {
  const StampFinding lapse = OnlyFinding(Regular(60.0, 20, kDate * 1'000'000'000));
  EXPECT_EQ(lapse.kind, StampFindingKind::kUnit);
  EXPECT_EQ(lapse.text, "images are 60 s apart in the median");
}

TEST(StampCheck, WholeStampsOneApartFromZeroAreFrameNumbers) {
  for (const Stamp first : {0, 1, 860}) {
    EXPECT_EQ(OnlyFinding(Regular(1.0, 60, first * 1'000'000'000)).kind,
              StampFindingKind::kFrameNumbers);
  }
  std::vector<Stamp> with_gap = Regular(1.0);
  with_gap.erase(with_gap.begin() + 20, with_gap.begin() + 25);
  EXPECT_EQ(OnlyFinding(with_gap).kind, StampFindingKind::kFrameNumbers);
}

TEST(StampCheck, ATimeLapseIsKnownByItsDateOrFractions) {
  EXPECT_TRUE(CheckStamps(Regular(1.0, 60, 1'000'500'000)).empty()) << "half seconds";
  EXPECT_TRUE(CheckStamps(Regular(1.0, 60, kDate * 1'000'000'000)).empty()) << "since 1970";
  EXPECT_TRUE(CheckStamps(Regular(1.0, 60, 100'000'000 * 1'000'000'000LL)).empty())
      << "since another day";
  // Without either it cannot be told from frame numbers: the remedy leaves the choice to the user.
  EXPECT_NE(OnlyFinding(Regular(1.0)).remedy.find("once a second"), std::string::npos);
}

TEST(StampCheck, CountsEqualAndDecreasingStamps) {
  std::vector<Stamp> equal = Regular(0.03);
  equal[7] = equal[6];
  equal[20] = equal[19];
  const StampFinding twice = OnlyFinding(equal);
  EXPECT_EQ(twice.kind, StampFindingKind::kEqual);
  EXPECT_EQ(twice.text, "2 frames have the stamp of the one before, the first is frame 7");
  std::vector<Stamp> back = Regular(0.03);
  std::swap(back[9], back[10]);
  const StampFinding one = OnlyFinding(back);
  EXPECT_EQ(one.kind, StampFindingKind::kDecreasing);
  EXPECT_EQ(one.text, "the stamps of 1 frame are smaller than those before, the first of frame 10");
}

TEST(StampCheck, SeveralImagesAtATimeAreStampedWhenTheyArrive) {
  for (const Stamp images : {2, 3, 6}) {
    std::vector<Stamp> stamps;
    for (Stamp i = 0; i < 120; ++i) {
      stamps.push_back((i / images) * images * 33 * kMillisecond + (i % images) * kMillisecond);
    }
    EXPECT_EQ(OnlyFinding(stamps).kind, StampFindingKind::kBursts) << images;
  }
}

TEST(StampCheck, DepthThatIsAFrameOffIsPairedWrongly) {
  const std::vector<Stamp> stamps = Regular(1.0 / 30.0);
  const auto check = [&](double delay) {
    return CheckStamps(stamps, std::vector<Stamp>(stamps.size(), FromSeconds(delay)));
  };
  EXPECT_TRUE(check(0.02).empty()) << "the limit by default";
  EXPECT_TRUE(check(-0.02).empty());
  ASSERT_EQ(check(-0.0333).size(), 1U);
  EXPECT_EQ(check(-0.0333).front().text,
            "depth is 33.3 ms earlier than the colour image it is paired with, in the median");
}

TEST(StampCheck, AFewFramesShowNothing) {
  EXPECT_TRUE(CheckStamps(Regular(33.0, 9)).empty());
  EXPECT_TRUE(CheckStamps(std::vector<Stamp>()).empty());
}

}  // namespace
}  // namespace highwall::stamp_check_test
