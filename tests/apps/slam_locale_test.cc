// Runs the program in a process with decimal commas, which a loaded library can set.
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "support/decimal_comma.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::slam_locale_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Outcome;
using testing::ReadText;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCanPreload = false;  // the sanitizer's own library has to be the first one
#else
constexpr bool kCanPreload = true;
#endif

using Files = std::map<std::string, std::string>;  // by their paths

Files FilesIn(const fs::path& folder) {
  Files files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    files[fs::relative(entry.path(), folder).string()] = ReadText(entry.path());
  }
  return files;
}

// Removes the clock times and memory sizes of a process, which differ between any two runs.
std::string WithoutMeasurements(const std::string& run_json) {
  const json flat = json::parse(run_json).flatten();
  std::string text;
  for (const auto& [path, value] : flat.items()) {
    const bool measured =
        std::regex_search(path, std::regex("milliseconds|_ms|seconds|memory|tight_updates"));
    text += path + " " + (measured ? value.type_name() : value.dump()) + "\n";
  }
  return text;
}

// A page contains measurements in many places: only the text between numbers is compared.
std::string WithoutNumbers(const std::string& page) {
  static const std::regex number("-?[0-9]+(\\.[0-9]+)?(e[-+]?[0-9]+)?");
  return std::regex_replace(page, number, "#");
}

class SlamLocale : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!kCanPreload) GTEST_SKIP() << "a sanitizer lets no library be preloaded";
    if (GetParam() == "facet") return;
    german_.emplace();
    if (!german_->IsMade()) GTEST_SKIP() << testing::kNoGermanLocale;
  }

  // Runs in a separate folder, so that the names in the output are the same.
  Outcome Run(const std::string& place, const std::string& arguments) const {
    fs::create_directories(folder_ / place);
    std::string program = testing::kHighwallProgram;
    if (place == kComma) {
      program = "env LD_PRELOAD=" + std::string(testing::kDecimalComma) +
                " DECIMAL_COMMA=" + GetParam() +
                " LOCPATH=" + (german_ ? german_->folder().string() : "") + " " + program;
    }
    return testing::RunProgram(program, arguments, folder_ / place);
  }
  // Expects success in both processes, and the same output.
  void RunBoth(const std::string& arguments, bool compare_output = true) const {
    SCOPED_TRACE(arguments);
    const Outcome plain = Run(kPlain, arguments), comma = Run(kComma, arguments);
    EXPECT_EQ(plain.exit_code, 0) << plain.err;
    EXPECT_EQ(comma.exit_code, 0) << comma.err;
    EXPECT_EQ(comma.err, plain.err);
    if (compare_output) {
      EXPECT_EQ(comma.out, plain.out);
    }
  }
  void ExpectSameFiles() const {
    const Files plain = FilesIn(folder_ / kPlain), comma = FilesIn(folder_ / kComma);
    for (const auto& [name, content] : comma) EXPECT_TRUE(plain.contains(name)) << name;
    for (const auto& [name, content] : plain) {
      SCOPED_TRACE(name);
      ASSERT_TRUE(comma.contains(name));
      const std::string& other = comma.at(name);
      if (name.ends_with(".json")) {
        EXPECT_EQ(WithoutMeasurements(other), WithoutMeasurements(content));
      } else if (name.ends_with(".html")) {
        EXPECT_TRUE(WithoutNumbers(other) == WithoutNumbers(content));
      } else {
        EXPECT_TRUE(other == content);
      }
    }
  }

  static constexpr const char* kPlain = "plain";
  static constexpr const char* kComma = "comma";
  const testing::TemporaryDirectory folder_;
  std::optional<testing::GermanLocale> german_;  // set if required
};

TEST_P(SlamLocale, AnImaginaryRecordingIsTheSameToTheByte) {
  RunBoth(
      "simulate room --out room --duration 0.2 --scale 0.25 --gps 5 --write-errors "
      "--depth-pattern 0.01 --blackout 0.1:0.05");
  ExpectSameFiles();
}

TEST_P(SlamLocale, AWholeRunWithItsReportIsTheSameToTheByte) {
  testing::WriteSmallRoom(folder_ / "room", 12);
  const std::string room = (folder_ / "room").string();
  testing::WriteText(folder_ / "settings.yaml", "frame: {orb: {pyramid: {scale_factor: 1.25}}}\n");
  RunBoth("slam --dataset " + room + " --out run --report --deterministic --resolution 0.075 " +
              "--adjust-all --set tracker.min_support=25 --settings ../settings.yaml",
          false);
  const json report = json::parse(ReadText(folder_ / kComma / "run" / "run.json"));
  EXPECT_EQ(report["map"]["octree"]["resolution_m"], 0.075);
  EXPECT_EQ(report["settings"]["frame.orb.pyramid.scale_factor"], "1.25");
  RunBoth("map run --resolution 0.1 --out map", false);
  RunBoth("info " + room + " --json");
  RunBoth("info " + room);
  RunBoth("eval ape " + room + "/groundtruth.txt run/trajectory.txt --plot error.svg");
  ExpectSameFiles();
}

INSTANTIATE_TEST_SUITE_P(Ways, SlamLocale, ::testing::Values("setlocale", "global", "facet"),
                         [](const auto& way) { return way.param; });

}  // namespace
}  // namespace highwall::slam_locale_test
