// Each switch of `highwall live` means what it says, and those of `highwall slam` mean the same.
#include "run/live_arguments.h"

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "run/run_report.h"

namespace highwall::apps::live_arguments_test {
namespace {

LiveArguments Parse(const std::string& switches) {
  LiveArguments arguments;
  CLI::App app;
  AddLiveOptions(&app, &arguments);
  app.parse(switches);
  return arguments;
}

TEST(LiveArguments, ACameraHasAKindAndADevice) {
  EXPECT_EQ(ReadCameraChoice("openni2").kind, "openni2");
  EXPECT_EQ(ReadCameraChoice("openni2").device, "");
  EXPECT_EQ(ReadCameraChoice("openni2:1d27/0601@1/5").device, "1d27/0601@1/5");
  EXPECT_EQ(ReadCameraChoice("openni2:a:b.oni").device, "a:b.oni");
  for (const char* const camera : {"webcam", ":openni2", "openni2.oni"}) {
    EXPECT_THROW(Parse("--out o --camera " + std::string(camera)), CLI::ValidationError) << camera;
  }
}

TEST(LiveArguments, ItsOwnSwitchesAreThoseOfTheCamera) {
  const LiveArguments plain = Parse("--camera openni2 --out o");
  EXPECT_EQ(plain.record, "");
  EXPECT_EQ(plain.seconds, 0.0);
  EXPECT_FALSE(plain.list);
  EXPECT_TRUE(MakeOptions(plain.slam).live);
  const LiveArguments given =
      Parse("--camera openni2 --out o --record r --seconds 2.5 --config tum1");
  EXPECT_EQ(given.record, "r");
  EXPECT_EQ(given.seconds, 2.5);
  EXPECT_EQ(given.slam.config, "tum1");
  for (const char* const wrong : {"--seconds 0", "--seconds -1", "--seconds x", "--record ''"}) {
    EXPECT_THROW(Parse("--camera openni2 --out o " + std::string(wrong)), CLI::ParseError) << wrong;
  }
}

TEST(LiveArguments, AListAndTheSettingsNeedNeitherCameraNorFolder) {
  EXPECT_TRUE(Parse("--list").list);
  EXPECT_TRUE(Parse("--print-settings").slam.print_settings);
  EXPECT_THROW(Parse("--out o"), CLI::RequiredError);
  EXPECT_THROW(Parse("--camera openni2"), CLI::RequiredError);
}

TEST(LiveArguments, SharedSwitchesMeanTheSameAsForARecording) {
  const std::string shared =
      "--out o --features points --resolution 0.1 --no-loops --no-map --set tracker.min_support=31";
  SlamArguments slam;
  CLI::App app;
  AddSlamOptions(&app, &slam);
  app.parse("--dataset d --live " + shared);
  const LiveArguments live = Parse("--camera openni2 " + shared);
  EXPECT_EQ(ToJson(MakeOptions(live.slam)), ToJson(MakeOptions(slam)));
  EXPECT_EQ(MakeOptions(live.slam).slam.tracker.min_support, 31);
}

TEST(LiveArguments, SwitchesOfRecordingsAreUnknown) {
  for (const char* const wrong : {"--dataset d", "--deterministic", "--live", "--gps off",
                                  "--fps 30", "--max-pair-difference 0.1"}) {
    EXPECT_THROW(Parse("--camera openni2 --out o " + std::string(wrong)), CLI::ExtrasError)
        << wrong;
  }
}

}  // namespace
}  // namespace highwall::apps::live_arguments_test
