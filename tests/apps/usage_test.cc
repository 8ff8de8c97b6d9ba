// Tests the program's answers to users who do not know its commands.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::usage_test {
namespace {

using testing::Contains;
using testing::ExpectRefused;
using testing::Outcome;

Outcome Highwall(const std::string& arguments) {
  return testing::RunProgram(testing::kHighwallProgram, arguments);
}

TEST(Usage, WithoutArgumentsItNamesTheFirstStep) {
  const Outcome outcome = Highwall("");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_EQ(outcome.out, "");
  EXPECT_LT(testing::CountLines(outcome.err), 8u);
  for (const char* text : {"highwall demo", "highwall info", "highwall slam", "highwall --help"}) {
    EXPECT_TRUE(Contains(outcome.err, text)) << outcome.err;
  }
}

TEST(Usage, AMisspeltCommandOptionOrWordIsNamedWithTheOneThatIsMeant) {
  ExpectRefused(Highwall("slm"), 1, {"highwall: unknown command slm; did you mean 'slam'?"});
  ExpectRefused(Highwall("elephant"), 1, {"highwall: unknown command elephant (see"});
  ExpectRefused(Highwall("slam --datset x --out y"), 1,
                {"highwall slam: unknown option --datset; did you mean '--dataset'?"});
  ExpectRefused(Highwall("slam --datset=x --out y"), 1, {"did you mean '--dataset'?"});
  ExpectRefused(Highwall("map compare a b --spaceing 3"), 1,
                {"unknown option --spaceing; did you mean '--spacing'?"});
  ExpectRefused(Highwall("slam --dataset x --out y --features pionts"), 1,
                {"--features: must be points, lines or both, is pionts; did you mean 'points'?"});
  ExpectRefused(Highwall("eval ap a b"), 1, {"metric: must be ape or rpe, is ap"});
}

TEST(Usage, HelpShowsWordsAndNoneOfTheCode) {
  for (const char* command :
       {"slam", "calibrate", "convert", "demo", "eval", "imu-noise", "info", "live", "map",
        "map compare", "merge", "posegraph", "report", "simulate"}) {
    const Outcome outcome = Highwall(std::string(command) + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    for (const char* code : {"ENUM", "->", "value in", "BOOLEAN"}) {
      EXPECT_FALSE(Contains(outcome.out, code)) << outcome.out;
    }
  }
  const std::string help = Highwall("slam --help").out;
  for (const char* words : {"--features {points,lines,both}", "--point-detector {orb,sift}",
                            "--line-detector {lsd,edlines}", "--moving-objects {on,off}",
                            "--gps {on,off}", "--set NAME=VALUE"}) {
    EXPECT_TRUE(Contains(help, words)) << help;
  }
}

TEST(Usage, SettingsArePrintedAndReadBack) {
  const testing::TemporaryDirectory folder("usage");
  const Outcome all = Highwall("slam --print-settings --set tracker.min_support=31");
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_TRUE(Contains(all.out, "\n  min_support: 31  # >= 6\n")) << all.out;
  testing::WriteText(folder.path() / "settings.yaml", all.out);
  const std::string file = (folder.path() / "settings.yaml").string();
  EXPECT_EQ(Highwall("slam --print-settings --settings " + file).out, all.out);
}

}  // namespace
}  // namespace highwall::usage_test
