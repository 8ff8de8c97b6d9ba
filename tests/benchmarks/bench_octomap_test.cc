// Runs highwall_bench_octomap in the same way as a user, on a few generated depth images.
#include <algorithm>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::bench_octomap_test {
namespace {

using nlohmann::json;

TEST(BenchOctomap, MeasuresEachModeOfStockInOneRunAndItsFastestIsNamed) {
  const testing::TemporaryDirectory folder;
  testing::WriteSmallRoom(folder / "room", 6);
  const testing::Outcome outcome = testing::RunProgram(
      testing::kBenchOctomap, "--dataset " + (folder / "room").string() +
                                  " --resolution 0.05 --stride 2 --rounds 0 --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const json report = json::parse(outcome.out);
  EXPECT_EQ(report["scans"], 3);
  for (const std::string mode : {"", "_discretized", "_lazy"}) {
    SCOPED_TRACE(mode);
    const double stock = report["stock" + mode + "_scan_ms"], ours = report["scan_ms"];
    EXPECT_GT(stock, 0.0);
    EXPECT_NEAR(report["speedup" + mode].get<double>(), stock / ours, 1e-9 * stock / ours);
  }
  // The leaves equal ours, with lazy or immediate updates of inner nodes; the default call casts
  // different rays.
  EXPECT_EQ(report["agreement_discretized"], 1.0);
  EXPECT_EQ(report["agreement_lazy"], 1.0);
  EXPECT_LT(report["agreement"], 1.0);
  // Without updates of inner nodes after each scan there is less work, and a ray per voxel costs
  // much less than a ray per point.
  EXPECT_LT(report["stock_discretized_scan_ms"], report["stock_scan_ms"]);
  EXPECT_EQ(report["stock_fastest_scan_ms"],
            std::min(report["stock_discretized_scan_ms"].get<double>(),
                     report["stock_lazy_scan_ms"].get<double>()));
}

}  // namespace
}  // namespace highwall::bench_octomap_test
