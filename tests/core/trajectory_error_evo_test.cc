#include <filesystem>
#include <fstream>
#include <map>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>
#include <highwall/core/trajectory_error.h>

#include "support/test_paths.h"

namespace highwall::trajectory_error_evo_test {
namespace {

TEST(TrajectoryErrorAgainstEvo, AllCasesAgreeToTheSixthDecimal) {
  const std::filesystem::path folder = std::filesystem::path(testing::kSharedData) / "trajectories";
  if (!std::filesystem::exists(folder / "expected_evo.json")) {
    GTEST_SKIP() << "shared/data/trajectories/expected_evo.json is not there";
  }
  const nlohmann::json expected =
      nlohmann::json::parse(std::ifstream(folder / "expected_evo.json"));
  const std::map<std::string, TrajectoryAlignment> alignments = {
      {"none", TrajectoryAlignment::kNone},
      {"se3", TrajectoryAlignment::kSe3},
      {"sim3", TrajectoryAlignment::kSim3},
      {"origin", TrajectoryAlignment::kOrigin}};
  const std::map<std::string, PoseRelation> relations = {{"trans_part", PoseRelation::kTranslation},
                                                         {"angle_deg", PoseRelation::kAngleDegrees},
                                                         {"full", PoseRelation::kFull}};
  std::map<std::string, Trajectory> trajectories;
  const auto load = [&](const std::string& name) -> const Trajectory& {
    if (!trajectories.contains(name)) trajectories[name] = ReadTumTrajectory(folder / name);
    return trajectories[name];
  };

  ASSERT_EQ(expected["cases"].size(), 112u);
  for (const nlohmann::json& c : expected["cases"]) {
    SCOPED_TRACE(c.dump());
    const Trajectory& reference = load(c["reference"]);
    const Trajectory& estimate = load(c["estimate"]);
    TrajectoryError result;
    if (c["metric"] == "ape") {
      result = AbsolutePoseError(reference, estimate,
                                 {.t_max_diff = c["t_max_diff"],
                                  .alignment = alignments.at(c["alignment"]),
                                  .relation = relations.at(c["relation"])});
    } else {
      result = RelativePoseError(
          reference, estimate,
          {.t_max_diff = c["t_max_diff"],
           .alignment = alignments.at(c["alignment"]),
           .relation = relations.at(c["relation"]),
           .delta = c["delta"],
           .delta_unit = c["delta_unit"] == "f" ? DeltaUnit::kFrames : DeltaUnit::kMetres,
           .all_pairs = c["all_pairs"]});
    }
    EXPECT_EQ(result.estimate.size(), c["associated"].get<std::size_t>());
    EXPECT_EQ(result.errors.size(), c["compared"].get<std::size_t>());
    EXPECT_NEAR(result.scale, c.value("scale", 1.0), 1e-12);
    const ErrorStatistics& s = result.statistics;
    const std::map<std::string, double> figures = {
        {"max", s.max},   {"mean", s.mean}, {"median", s.median}, {"min", s.min},
        {"rmse", s.rmse}, {"sse", s.sse},   {"std", s.std}};
    for (const auto& [name, figure] : figures) {
      EXPECT_NEAR(figure, c["stats"][name].get<double>(), 1e-6) << name;
    }
  }
}

}  // namespace
}  // namespace highwall::trajectory_error_evo_test
