// Runs `highwall slam --report` and `highwall report` in the same way as a user, and opens their
// pages in Debian's chromium.
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "report/html_report.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::report_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::RunProgram;
using testing::TemporaryDirectory;

class ReportCommand : public ::testing::Test {
 protected:
  // Runs with points and lines, with a report, and runs with points alone.
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TemporaryDirectory>();
    testing::WriteSmallRoom(*folder_ / "dataset", 60);
    both_ = Highwall("slam --dataset dataset --out both --deterministic --report");
    points_ =
        Highwall("slam --dataset dataset --out points --deterministic --features points --no-map");
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static Outcome Highwall(const std::string& arguments) {
    return RunProgram(testing::kHighwallProgram, arguments, folder_->path());
  }
  static json DataOf(const fs::path& page) {
    const std::string text = ReadText(page), begin = "id=\"data\">";
    const std::size_t at = text.find(begin) + begin.size();
    return json::parse(text.substr(at, text.find("</script>", at) - at));
  }
  // Returns the page after its scripts, and the log of the browser. Its renderer draws nothing
  // with a C library that emulates another processor, as in scripts/compare_processors.
  static Outcome Browse(const std::string& page) {
    return RunProgram("env -u GLIBC_TUNABLES timeout 120 chromium",
                      "--headless --no-sandbox --disable-dev-shm-usage --disable-gpu-sandbox "
                      "--use-angle=swiftshader --enable-unsafe-swiftshader --hide-scrollbars "
                      "--window-size=1280,900 --user-data-dir='" +
                          (*folder_ / "profile").string() +
                          "' --enable-logging=stderr --dump-dom 'file://" +
                          (*folder_ / page).string() + "'",
                      folder_->path());
  }
  static bool HasBrowser() { return RunProgram("chromium", "--version").exit_code == 0; }
  // Returns the value of an attribute of the page's root element.
  static std::string Attribute(const std::string& dom, const std::string& name) {
    const std::string begin = name + "=\"";
    const std::size_t at = dom.find(begin);
    if (at == std::string::npos) return "";
    return dom.substr(at + begin.size(), dom.find('"', at + begin.size()) - at - begin.size());
  }
  static void ExpectDrawn(const Outcome& browser) {
    ASSERT_EQ(browser.exit_code, 0) << browser.err;
    EXPECT_EQ(Attribute(browser.out, "data-state"), "drawn");
    EXPECT_EQ(Attribute(browser.out, "data-error"), "");
    EXPECT_FALSE(Contains(browser.err, "Uncaught")) << browser.err;
    EXPECT_FALSE(Contains(browser.err, "Refused to")) << browser.err;
  }

  static std::unique_ptr<TemporaryDirectory> folder_;
  static Outcome both_, points_;
};

std::unique_ptr<TemporaryDirectory> ReportCommand::folder_;
Outcome ReportCommand::both_, ReportCommand::points_;

TEST_F(ReportCommand, SlamWritesThePageOfItsRun) {
  ASSERT_EQ(both_.exit_code, 0) << both_.err;
  const json data = DataOf(*folder_ / "both/report.html");
  ASSERT_EQ(data["runs"].size(), 1u);
  const json& run = data["runs"][0];
  EXPECT_EQ(run["name"], "both");
  EXPECT_EQ(run["frames"]["points"].size(), 60u);
  EXPECT_EQ(run["path"]["position"].size(), 60u);
  EXPECT_EQ(run["path"]["error"].size(), 60u);
  EXPECT_EQ(run["graph"]["keyframes"].size(), run["run"]["keyframes"]);
  EXPECT_GT(run["graph"]["covisible"].size(), 0u);
  EXPECT_GT(run["graph"]["line_count"], 0);
  EXPECT_GT(run["scene"]["cloud"]["count"], 1000);
  EXPECT_GT(run["scene"]["octree"]["count"], 100);
  EXPECT_EQ(run["pictures"].size(), 5u);
  EXPECT_FALSE(run["run"].contains("per_frame")) << "it is shown once, in its curves";
  const json eval =
      json::parse(Highwall("eval ape dataset/groundtruth.txt both/trajectory.txt --json").out);
  EXPECT_EQ(run["errors"]["ape"]["rmse"], eval["stats"]["rmse"]);
}

TEST_F(ReportCommand, ARunWithoutTheOptionHasNoPage) {
  ASSERT_EQ(points_.exit_code, 0) << points_.err;
  EXPECT_FALSE(fs::exists(*folder_ / "points/report.html"));
}

TEST_F(ReportCommand, SeveralRunsAreOnOnePage) {
  const Outcome outcome = Highwall("report both points --out compared.html");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "compared.html"));
  const json data = DataOf(*folder_ / "compared.html");
  ASSERT_EQ(data["runs"].size(), 2u);
  EXPECT_TRUE(data["runs"][1]["scene"].empty()) << "--no-map";
  EXPECT_EQ(data["runs"][1]["run"]["options"]["lines"], false);
}

TEST_F(ReportCommand, AnotherGroundTruthCanBeGiven) {
  fs::rename(*folder_ / "dataset/groundtruth.txt", *folder_ / "truth.txt");
  EXPECT_EQ(Highwall("report points --out without.html").exit_code, 0);
  EXPECT_EQ(Highwall("report points --groundtruth truth.txt --out with.html").exit_code, 0);
  fs::rename(*folder_ / "truth.txt", *folder_ / "dataset/groundtruth.txt");
  EXPECT_TRUE(DataOf(*folder_ / "without.html")["runs"][0]["errors"].is_null());
  EXPECT_TRUE(DataOf(*folder_ / "with.html")["runs"][0]["errors"].contains("ape"));
}

TEST_F(ReportCommand, RefusesFoldersWithoutARunInOneLine) {
  testing::ExpectRefused(Highwall("report nowhere --out x.html"), 2,
                         {"nowhere", "is no finished run"});
  testing::ExpectRefused(Highwall("report dataset --out x.html"), 2,
                         {"dataset", "is no finished run"});
  testing::ExpectRefused(Highwall("report both points"), 1, {"--out", "several runs"});
  fs::create_directories(*folder_ / "damaged");
  testing::WriteText(*folder_ / "damaged/run.json", R"({"lost_stamps": 7})");
  fs::copy_file(*folder_ / "both/trajectory.txt", *folder_ / "damaged/trajectory.txt");
  testing::ExpectRefused(Highwall("report damaged"), 2, {"run.json", "is damaged"});
  EXPECT_FALSE(fs::exists(*folder_ / "damaged/report.html"));
  EXPECT_FALSE(fs::exists(*folder_ / "x.html"));
}

TEST_F(ReportCommand, ABrowserDrawsThePage) {
  if (!HasBrowser()) GTEST_SKIP() << "needs Debian's chromium";
  const Outcome browser = Browse("both/report.html");
  ExpectDrawn(browser);
  for (const char* section : {"summary", "map3d", "trajectory", "errors", "features", "graph",
                              "times", "sensors", "pictures", "options"}) {
    EXPECT_TRUE(Contains(browser.out, "<section id=\"" + std::string(section) + "\"")) << section;
  }
  for (const char* section : {"imu", "losses", "maps"}) {
    EXPECT_FALSE(Contains(browser.out, "<section id=\"" + std::string(section) + "\""))
        << section << ": there was none, or nothing to report";
  }
  if (!apps::HasView3d()) {
    EXPECT_EQ(Attribute(browser.out, "data-view"), "absent");
    return;
  }
  // The map covers a part of a view of some 1150 x 590 pixels.
  EXPECT_GT(std::atoi(Attribute(browser.out, "data-view").c_str()), 20'000);
}

// The room has no IMU: the messages of a run with an IMU are added to its result.
TEST_F(ReportCommand, TheImuIsShownWithTheReadingsThatImagesContradict) {
  if (!HasBrowser()) GTEST_SKIP() << "needs Debian's chromium";
  fs::copy(*folder_ / "points", *folder_ / "inertial");
  json run = json::parse(ReadText(*folder_ / "inertial/run.json"));
  const json stamps = run["per_frame"]["stamp"];
  const std::vector<double> ones(stamps.size(), 1.0);
  run["imu"] = {{"initialized", stamps[0]},
                {"contradicted_intervals", 73},
                {"intervals", {{"stamp", stamps}, {"weight", ones}, {"innovation_per_dof", ones}}}};
  testing::WriteText(*folder_ / "inertial/run.json", run.dump());
  ASSERT_EQ(Highwall("report inertial").exit_code, 0);
  const Outcome browser = Browse("inertial/report.html");
  ExpectDrawn(browser);
  EXPECT_TRUE(Contains(browser.out, "<section id=\"imu\""));
  EXPECT_TRUE(
      Contains(browser.out, ">intervals whose readings the images contradict</th><td>73</td>"));
  EXPECT_TRUE(Contains(browser.out, "contradicted its readings in 73 intervals"));
}

// A script at the end of the page simulates the actions of a user.
TEST_F(ReportCommand, KeysTurnTheViewAndReadTheCurves) {
  if (!HasBrowser()) GTEST_SKIP() << "needs Debian's chromium";
  std::string page = ReadText(*folder_ / "both/report.html");
  page.insert(page.rfind("</body>"), R"(<script>
    const canvas = document.querySelector("canvas"), mark = document.documentElement.dataset;
    const press = (element, key) => element.dispatchEvent(new KeyboardEvent("keydown", { key }));
    const turn = () => {
      const at = () => Highwall.shown.camera.position.toArray().map((v) => v.toFixed(6)).join(" ");
      const places = [at()];
      const farthest = Highwall.shown.extent.points.map((p) => {
        const seen = new THREE.Vector3(...p).project(Highwall.shown.camera);
        return Math.max(Math.abs(seen.x), Math.abs(seen.y));
      });
      mark.farthest = Math.max(...farthest);
      for (const key of ["ArrowLeft", "ArrowUp", "+", "d"]) { press(canvas, key); places.push(at()); }
      press(canvas, "Home");
      mark.moves = new Set(places).size + (at() === places[0] ? " home" : "");
      Highwall.shown.toggle("cloud", false);
      Highwall.shown.toggle("octree", true);
      mark.octree = Highwall.shown.drawnPixels();
    };
    if (canvas) turn();
    const curve = document.querySelector("#features svg[tabindex]");
    press(curve, "End");
    mark.readout = curve.parentNode.querySelector(".readout").textContent;
  </script>)");
  testing::WriteText(*folder_ / "keys.html", page);
  const Outcome browser = Browse("keys.html");
  ExpectDrawn(browser);
  if (apps::HasView3d()) {
    EXPECT_EQ(Attribute(browser.out, "data-moves"), "5 home");
    const double farthest = std::atof(Attribute(browser.out, "data-farthest").c_str());
    EXPECT_LT(farthest, 1.0) << "all of the map is in the view";
    EXPECT_GT(farthest, 0.9) << "and fills it";
    EXPECT_GT(std::atoi(Attribute(browser.out, "data-octree").c_str()), 20'000);
  }
  const std::string readout = Attribute(browser.out, "data-readout");
  EXPECT_TRUE(readout.starts_with("1.97 s: points ")) << readout;  // the last of 60 frames
}

TEST_F(ReportCommand, ABrowserDrawsTwoRunsSideBySide) {
  if (!HasBrowser()) GTEST_SKIP() << "needs Debian's chromium";
  ASSERT_EQ(Highwall("report points both --out two.html").exit_code, 0);
  const Outcome browser = Browse("two.html");
  ExpectDrawn(browser);
  EXPECT_TRUE(Contains(browser.out, "option lines")) << "their options differ";
  // Lines appear once among the stages: in the run that detected them.
  const std::string bars = "text-anchor=\"end\">lines</text>";
  EXPECT_EQ(browser.out.find(bars), browser.out.rfind(bars));
  EXPECT_TRUE(Contains(browser.out, bars));
  if (apps::HasView3d()) {
    EXPECT_GT(std::atoi(Attribute(browser.out, "data-view").c_str()), 100) << "paths, no cloud";
  }
}

}  // namespace
}  // namespace highwall::report_test
