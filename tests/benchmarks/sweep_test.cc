#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>

#include "figures.h"
#include "paper_tables.h"
#include "reference.h"
#include "support/temporary_directory.h"
#include "sweep.h"
#include "sweep_tables.h"

namespace highwall::bench::sweep_test {
namespace {

using highwall::testing::TemporaryDirectory;
using highwall::testing::WriteText;

RunRecord MakeRecord(const std::string& sequence, int run, double ape) {
  RunRecord record;
  record.key = {sequence, 0, {"both", "--features both", MapChoice::kDefault}, run, true};
  record.figures = {{"ape_rmse_m", ape}, {"coverage", 1.0}};
  record.trajectory = {{1'000'000'000, Pose()}, {2'000'000'000, Pose()}};
  return record;
}

TEST(Shard, IsReadFromNumberAndCount) {
  const Shard shard = ParseShard("2/12");
  EXPECT_EQ(shard.number, 2U);
  EXPECT_EQ(shard.count, 12U);
  for (const char* wrong : {"", "2", "2/", "/2", "0/2", "3/2", "1/2x", "-1/2", "1 /2"}) {
    EXPECT_THROW(ParseShard(wrong), InvalidArgument) << wrong;
  }
}

TEST(SweepRecord, ComesBackAsItWasWritten) {
  const TemporaryDirectory folder;
  RunRecord record = MakeRecord("office/first", 3, 0.1 + 0.2);
  record.key.seed = 7;
  record.loss_reasons = {{"too fast", 4}};
  WriteRecord(folder.path(), record);
  const std::filesystem::path file = folder.path() / "runs/office_first/seed7/both/3.json";
  EXPECT_EQ(RecordFile(folder.path(), record.key), file);
  const RunRecord read = ReadRecord(file);
  EXPECT_EQ(read.key.sequence, "office/first");
  EXPECT_EQ(read.key.seed, 7);
  EXPECT_EQ(read.key.setting.name, "both");
  EXPECT_EQ(read.key.setting.switches, "--features both");
  EXPECT_EQ(read.key.setting.map, MapChoice::kDefault);
  EXPECT_EQ(read.key.run, 3);
  EXPECT_TRUE(read.key.synchronous);
  EXPECT_EQ(read.figures, record.figures);
  EXPECT_EQ(read.loss_reasons, record.loss_reasons);
  ASSERT_EQ(read.trajectory.size(), 2U);
  EXPECT_EQ(read.trajectory[1].stamp, 2'000'000'000);
}

TEST(SweepRecord, NamesAnInvalidRecord) {
  const TemporaryDirectory folder;
  EXPECT_THROW(MergeRecords({folder.path()}), IoError);
  std::filesystem::create_directories(folder.path() / "runs");
  WriteText(folder.path() / "runs/1.json", "{\"sequence\": \"a\"}");
  try {
    MergeRecords({folder.path()});
    FAIL() << "half a record was read";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("1.json: is no record"), std::string::npos);
  }
}

TEST(SweepRecord, SweepsAreMergedUnlessBothHaveARun) {
  const TemporaryDirectory a("a"), b("b");
  WriteRecord(a.path(), MakeRecord("office", 1, 0.1));
  WriteRecord(b.path(), MakeRecord("office", 2, 0.2));
  WriteRecord(b.path(), MakeRecord("hall", 1, 0.3));
  EXPECT_EQ(MergeRecords({a.path(), b.path()}).size(), 3U);
  EXPECT_EQ(MergeRecords({a.path(), b.path()}, {"office"}).size(), 2U);
  WriteRecord(b.path(), MakeRecord("office", 1, 0.1));
  EXPECT_THROW(MergeRecords({a.path(), b.path()}), IoError);
}

TEST(SweepTables, ARowHasTheMedianAndTheSpreadOfItsRuns) {
  std::vector<RunRecord> records{MakeRecord("office", 1, 0.003), MakeRecord("hall", 1, 0.5),
                                 MakeRecord("office", 2, 0.001), MakeRecord("office", 3, 0.0045)};
  records[0].loss_reasons = {{"dark", 2}};
  records[3].loss_reasons = {{"dark", 1}, {"too fast", 5}};
  const std::vector<SweepRow> rows = MakeRows(records);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].runs.size(), 3U);
  EXPECT_EQ(rows[0].median.at("ape_rmse_m"), 0.003);
  EXPECT_EQ(rows[0].low.at("ape_rmse_m"), 0.001);
  EXPECT_EQ(rows[0].high.at("ape_rmse_m"), 0.0045);
  EXPECT_EQ(rows[0].loss_reasons.at("dark"), 3U);
  EXPECT_EQ(ToMarkdown(rows),
            "| sequence | setting | runs | APE RMSE [mm] | coverage | why lost |\n"
            "|---|---|---|---|---|---|\n"
            "| office | both | 3 | 3.00 (1.00 to 4.50) | 1.000 | 3 dark, 5 too fast |\n"
            "| hall | both | 1 | 500.00 | 1.000 |  |\n");
  const std::vector<SweepRow> timed = [&] {
    std::vector<RunRecord> one{records[1]};
    one[0].figures["frame_ms"] = 20.0;
    return MakeRows(one);
  }();
  EXPECT_NE(ToMarkdown(timed).find("| 20.0 |"), std::string::npos);
  EXPECT_EQ(ToMarkdown(timed, false).find("| 20.0 |"), std::string::npos);
  const std::vector<SweepRow> in_units = [&] {
    std::vector<RunRecord> one{records[1]};
    one[0].figures["processor_over_orb"] = 7.5;
    return MakeRows(one);
  }();
  EXPECT_EQ(ToMarkdown(in_units).find("| 7.50 |"), std::string::npos);
  EXPECT_NE(ToMarkdown(in_units, true, true).find("| 7.50 |"), std::string::npos);
  EXPECT_EQ(ToMarkdown(in_units, false, true).find("| 7.50 |"), std::string::npos);
  EXPECT_NE(TextLine(in_units[0], {.unit = true}).find(" 7.50 "), std::string::npos);
  EXPECT_EQ(TextLine(in_units[0]).find(" 7.50 "), std::string::npos);
  EXPECT_NE(TextLine(in_units[0]).find(" - "), std::string::npos) << "without the newer figures";
  EXPECT_EQ(ToCsv({rows[1]}),
            "sequence,seed,setting,switches,lockstep,run,ape_rmse_m,coverage,loss_reasons\n"
            "\"hall\",0,\"both\",\"--features both\",1,1,0.5,1,\"\"\n");
}

// A walk along a curve at 30 Hz.
Trajectory Walk(int frames, double wobble) {
  Trajectory walk;
  for (int i = 0; i < frames; ++i) {
    const double t = i / 30.0;
    const Eigen::Vector3d p(std::sin(t) + wobble * std::sin(40.0 * t), std::cos(2.0 * t), 0.3 * t);
    walk.push_back({FromSeconds(100.0 + t), Pose(Eigen::Quaterniond::Identity(), p)});
  }
  return walk;
}

ScoredFrames FramesOf(const Trajectory& truth) {
  ScoredFrames frames{{}, truth};
  for (const StampedPose& pose : truth) frames.stamps.push_back(pose.stamp);
  return frames;
}

TEST(Reference, IsComparedOverTheFramesThatEveryRunOfBothHas) {
  const ScoredFrames frames = FramesOf(Walk(120, 0.0));
  Trajectory own = Walk(120, 0.01), other = Walk(120, 0.02);
  own.erase(own.begin(), own.begin() + 30);    // lost at the beginning
  other.erase(other.end() - 12, other.end());  // and at the end
  const Comparison result = Compare(frames, {own, Walk(120, 0.01)}, {other, other, other});
  EXPECT_EQ(result.problem, "");
  EXPECT_EQ(result.frames, 120U);
  EXPECT_EQ(result.common, 78U);
  EXPECT_EQ(result.own.runs, 2U);
  EXPECT_EQ(result.other.runs, 3U);
  EXPECT_DOUBLE_EQ(result.own.coverage, 1.0);  // the larger of two
  EXPECT_DOUBLE_EQ(result.other.coverage, 0.9);
  // Half the wobble gives half the error, except for the part that the alignment removes of each.
  ASSERT_TRUE(result.ratio);
  EXPECT_NEAR(Ratio(*result.ratio), 0.5, 1e-3);
  EXPECT_NEAR(Ratio(*result.ratio), result.own.ape / result.other.ape, 1e-12);
  EXPECT_NEAR(result.own.rpe_1, 0.5 * result.other.rpe_1, 1e-12);
}

TEST(Reference, WithoutFramesInCommonThereIsNoRatioButAReason) {
  const ScoredFrames frames = FramesOf(Walk(60, 0.0));
  const Trajectory walk = Walk(60, 0.01);
  const Comparison result = Compare(frames, {Trajectory(walk.begin(), walk.begin() + 20)},
                                    {Trajectory(walk.begin() + 20, walk.end())});
  EXPECT_EQ(result.common, 0U);
  EXPECT_FALSE(result.ratio);
  EXPECT_NE(result.problem, "");
}

TEST(Reference, RunsAreThoseOfTheSequenceAndNotOfALongerName) {
  const TemporaryDirectory folder;
  for (const char* name : {"fr1_desk_1.txt", "fr1_desk_2.txt", "fr1_desk2_1.txt",
                           "fr1_desk_slow_1.txt", "fr1_desk_slow.txt", "fr1_desk_1.csv"}) {
    WriteText(folder / name, "1 0 0 0 0 0 0 1\n");
  }
  const ReferenceSystem system = ParseReference("ORB=" + folder.path().string());
  EXPECT_EQ(system.name, "ORB");
  EXPECT_EQ(ReferenceRuns(system, "fr1_desk", {"fr1_desk", "fr1_desk_slow"}).size(), 2U);
  EXPECT_EQ(ReferenceRuns(system, "fr1_desk_slow", {"fr1_desk", "fr1_desk_slow"}).size(), 2U);
  EXPECT_TRUE(ReferenceRuns(system, "fr2_desk", {}).empty());
  EXPECT_THROW(ReferenceRuns({"ORB", folder.path() / "none"}, "fr1_desk", {}), IoError);
  EXPECT_THROW(ParseReference("ORB"), InvalidArgument);
}

// Welch: 0.1 +- and 0.3 +-, by hand. The variances of the means are 0.01 / 3 and 0.04 / 2.
TEST(Reference, TheDifferenceOfMeansHasWelchsDegreesOfFreedom) {
  const MeanLog a = MeanOf({0.0, 0.1, 0.2}), b = MeanOf({0.1, 0.5});
  const MeanLog difference = DifferenceOf(a, b);
  EXPECT_NEAR(difference.mean, -0.2, 1e-15);
  const double va = 0.01 / 3.0, vb = 0.08 / 2.0;
  EXPECT_NEAR(difference.variance, va + vb, 1e-15);
  EXPECT_NEAR(difference.degrees_of_freedom, (va + vb) * (va + vb) / (va * va / 2.0 + vb * vb),
              1e-12);
  EXPECT_FALSE(RatioInterval(DifferenceOf(a, MeanOf({0.1}))));
}

TEST(PaperTables, ASequenceIsKnownByItsLongNameAsWell) {
  EXPECT_EQ(PaperNameOf("rgbd_dataset_freiburg2_desk_with_person"), "fr2_desk_with_person");
  EXPECT_EQ(PaperNameOf("freiburg3_long_office_household"), "fr3_long_office");
  EXPECT_EQ(PaperNameOf("fr3_walking_rpy"), "fr3_walk_rpy");
  EXPECT_EQ(PaperNameOf("fr1_xyz"), "fr1_xyz");
}

TEST(Figures, NamesChangesBeyondTheToleranceWithBothValues) {
  const nlohmann::json tolerances{{"ape_rmse_m", 0.1}, {"lost_frames", 0.0}};
  const nlohmann::json expected{
      {"room", {{"both", {{"ape_rmse_m", 0.010}, {"lost_frames", 0.0}, {"seconds", 1.0}}}}}};
  nlohmann::json measured = expected;
  measured["room"]["both"]["ape_rmse_m"] = 0.0109;
  measured["room"]["both"]["seconds"] = 9.0;
  EXPECT_TRUE(FindMoved(expected, measured, tolerances).empty());
  measured["room"]["both"]["ape_rmse_m"] = 0.0089;
  measured["room"]["both"]["lost_frames"] = 1.0;
  measured["room"]["lines"]["ape_rmse_m"] = 0.02;  // which the file does not contain
  const std::vector<MovedFigure> moved = FindMoved(expected, measured, tolerances);
  ASSERT_EQ(moved.size(), 3U);
  EXPECT_EQ(moved[0].name, "room/both/ape_rmse_m");
  EXPECT_EQ(moved[0].expected, 0.010);
  EXPECT_EQ(moved[0].measured, 0.0089);
  EXPECT_EQ(moved[1].name, "room/both/lost_frames");
  EXPECT_EQ(moved[2].name, "room/lines/ape_rmse_m");
  EXPECT_TRUE(std::isnan(moved[2].expected));
}

TEST(Figures, ASettingOfASequenceMayHaveTolerancesOfItsOwn) {
  const nlohmann::json expected = {
      {"room", {{"both", {{"ape_rmse_m", 0.010}}}, {"paper", {{"ape_rmse_m", 0.010}}}}}};
  nlohmann::json measured = expected;
  for (const char* setting : {"both", "paper"}) measured["room"][setting]["ape_rmse_m"] = 0.0115;
  const nlohmann::json tolerances = {{"ape_rmse_m", 0.05}, {"room/paper", {{"ape_rmse_m", 0.25}}}};
  const std::vector<MovedFigure> moved = FindMoved(expected, measured, tolerances);
  ASSERT_EQ(moved.size(), 1U);
  EXPECT_EQ(moved[0].name, "room/both/ape_rmse_m");
  measured["room"]["paper"]["ape_rmse_m"] = 0.0126;
  EXPECT_EQ(FindMoved(expected, measured, tolerances).size(), 2U);
}

}  // namespace
}  // namespace highwall::bench::sweep_test
