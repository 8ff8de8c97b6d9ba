// Checks that the command of docs/results.md gives a cell of its table.
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::results_test {
namespace {

using testing::Contains;

TEST(Results, ACellHoldsTheOutputOfItsCommand) {
  const std::string page =
      testing::ReadText(std::string(testing::kSourceFolder) + "/docs/results.md");
  const std::string scene =
      "--scenes room --duration 3 --fps 15 --scale 0.5 --runs 1 --deterministic";
  const std::string setting = "--setting lsd=\"--line-detector lsd\"";
  ASSERT_TRUE(Contains(page, "highwall_bench_tum --data datasets " + scene));
  ASSERT_TRUE(Contains(page, setting));
  const std::string row = "\n| room_3s_15fps_scale0.5 | lsd | 1 | ";
  const std::size_t at = page.find(row);
  ASSERT_NE(at, std::string::npos) << "scripts/results --only small";
  const double shown = std::atof(page.c_str() + at + row.size());  // [mm]

  const testing::TemporaryDirectory folder;
  const testing::Outcome outcome = testing::RunProgram(
      testing::kBenchTum, "--data . " + scene + " " + setting + " --json", folder.path());
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json report = nlohmann::json::parse(outcome.out)["sequences"];
  const double measured =
      1e3 * report["room_3s_15fps_scale0.5"]["lsd"]["median"]["ape_rmse_m"].get<double>();
  // Another processor sums in another order; the page has two decimals.
  EXPECT_NEAR(measured, shown, 0.05 * shown + 0.005) << "scripts/results --only small renews it";
}

}  // namespace
}  // namespace highwall::results_test
