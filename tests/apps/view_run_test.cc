// `highwall slam --view` as a user sees it: by HTTP, and in Debian's chromium.

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <httplib.h>
#undef _res  // of resolv.h, and a name in Eigen
#include <nlohmann/json.hpp>

#include "report/html_report.h"
#include "support/browser.h"
#include "support/free_port.h"
#include "support/run_program.h"
#include "support/small_room.h"
#include "support/test_paths.h"

namespace highwall::view_run_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::BackgroundProgram;
using testing::Browser;
using testing::Contains;
using testing::ReadText;

constexpr int kFrames = 60;

class ViewOfARun : public ::testing::Test {
 protected:
  ViewOfARun() : port_(testing::FreePort()), client_("127.0.0.1", port_) {
    testing::WriteSmallRoom(folder_ / "dataset", kFrames);
    client_.set_read_timeout(60);
  }

  // Replaces the lists of the dataset by many walks, forwards and backwards in turn, for a run that
  // a slow browser does not see end.
  void RepeatTheWalk(int times) const {
    for (const std::string kind : {"rgb", "depth"}) {
      const fs::path list = folder_ / "dataset" / (kind + ".txt");
      std::vector<std::string> images;
      std::istringstream lines(ReadText(list));
      for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with('#')) images.push_back(line.substr(line.find(' ') + 1));
      }
      ASSERT_EQ(images.size(), static_cast<std::size_t>(kFrames));
      std::ofstream out(list);
      for (int frame = 0; frame < times * kFrames; ++frame) {
        if (frame % kFrames == 0 && frame > 0) std::ranges::reverse(images);
        out << fmt::format("{:.6f} {}\n", 1 + frame / 30.0,
                           images[static_cast<std::size_t>(frame % kFrames)]);
      }
    }
  }

  // Paused before the second frame, so that what follows does not depend on time.
  void Start(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {
        "slam",         "--dataset",       (folder_ / "dataset").string(),   "--out",
        run().string(), "--deterministic", "--view=" + std::to_string(port_)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    program_ = std::make_unique<BackgroundProgram>(testing::kHighwallProgram, arguments);
    while (program_->IsRunning() && !Press("pause")) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(program_->IsRunning());
  }
  bool Press(const std::string& button) {
    const auto answer =
        client_.Post("/button/" + button, {{"X-Highwall-Button", "1"}}, "", "text/plain");
    return answer && answer->status == 204;
  }
  // Returns the events until `last`, on a connection of its own.
  std::string Receive(const std::string& last) const {
    httplib::Client client("127.0.0.1", port_);
    client.set_read_timeout(60);
    std::string received;
    client.Get("/events", [&](const char* data, std::size_t size) {
      received.append(data, size);
      return received.find(last) == std::string::npos;
    });
    return received;
  }
  std::string url() const { return "http://127.0.0.1:" + std::to_string(port_) + "/"; }
  fs::path run() const { return folder_ / "run"; }

  const testing::TemporaryDirectory folder_;
  const int port_;
  httplib::Client client_;
  std::unique_ptr<BackgroundProgram> program_;
};

TEST_F(ViewOfARun, TheStopButtonEndsItAsCtrlCDoes) {
  Start();
  EXPECT_TRUE(Contains(Receive("event: frame"), "\"jpeg\":"));
  ASSERT_TRUE(Press("stop"));
  EXPECT_EQ(program_->ExitCode(), 130);
  const json report = json::parse(ReadText(run() / "run.json"));
  const auto done = report["frames"].get<int>();
  EXPECT_GE(done, 1);
  EXPECT_LT(done, kFrames);
  EXPECT_EQ(report["complete"], true);
  EXPECT_EQ(report["stopped"]["signal"], "SIGINT");
  EXPECT_EQ(report["stopped"]["frames_done"], done);
  for (const char* file : {"trajectory.txt", "keyframes.txt", "map.hwmap"}) {
    EXPECT_TRUE(fs::exists(run() / file)) << file;
  }
}

TEST_F(ViewOfARun, StepsOneFrameAndSavesTheMapSoFar) {
  Start();
  std::string received = Receive("event: frame");
  ASSERT_TRUE(Press("step"));
  EXPECT_FALSE(fs::exists(run() / "map.hwmap"));
  ASSERT_TRUE(Press("save"));
  received = Receive("saved in map.hwmap");
  EXPECT_TRUE(fs::exists(run() / "map.hwmap"));
  ASSERT_TRUE(Press("resume"));
  EXPECT_EQ(program_->ExitCode(), 0);
  EXPECT_EQ(json::parse(ReadText(run() / "run.json"))["frames"], kFrames);
}

TEST_F(ViewOfARun, WhoeverLooksOnChangesNoResult) {
  Start();
  std::jthread watcher([this] { Receive("event: ended"); });
  ASSERT_TRUE(Press("resume"));
  EXPECT_EQ(program_->ExitCode(), 0);
  const testing::Outcome alone =
      testing::RunProgram(testing::kHighwallProgram,
                          "slam --dataset dataset --out alone --deterministic", folder_.path());
  ASSERT_EQ(alone.exit_code, 0) << alone.err;
  for (const char* file : {"trajectory.txt", "keyframes.txt", "map.hwmap", "cloud.ply", "map.bt"}) {
    EXPECT_EQ(ReadText(run() / file), ReadText(folder_ / "alone" / file)) << file;
  }
  EXPECT_FALSE(Contains(alone.err, "seen at")) << "without --view there is none";
}

TEST_F(ViewOfARun, AnotherAddressNeedsTheTokenThatIsPrinted) {
  const std::string port = std::to_string(port_);
  std::jthread guest([this] {
    httplib::Client client("127.0.0.1", port_);
    for (auto answer = client.Get("/"); !answer; answer = client.Get("/")) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    EXPECT_EQ(client.Get("/")->status, 403);
  });
  const testing::Outcome outcome = testing::RunProgram(
      testing::kHighwallProgram,
      "slam --dataset dataset --out run --view=" + port + " --view-address 0.0.0.0",
      folder_.path());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "seen at http://0.0.0.0:" + port + "/?token=")) << outcome.err;
}

TEST_F(ViewOfARun, APortInUseIsRefusedBeforeTheRun) {
  httplib::Server other;
  const int port = other.bind_to_any_port("127.0.0.1");
  const testing::Outcome outcome = testing::RunProgram(
      testing::kHighwallProgram, "slam --dataset dataset --out run --view=" + std::to_string(port),
      folder_.path());
  testing::ExpectRefused(outcome, 2, {"127.0.0.1:" + std::to_string(port), "--view=PORT"});
}

TEST_F(ViewOfARun, ABrowserShowsItAndItsButtonsAct) {
  if (!Browser::IsInstalled()) GTEST_SKIP() << "needs Debian's chromium";
  RepeatTheWalk(100);
  Start();
  Browser browser(folder_ / "profile");
  browser.Open(url());
  ASSERT_TRUE(browser.WaitFor("document.documentElement.dataset.state === 'open'"));
  const std::string frame = "+(document.querySelector('canvas.picture').dataset.frame || 0)";
  ASSERT_TRUE(browser.WaitFor(frame + " >= 1")) << "the image is drawn while the run is paused";
  EXPECT_EQ(browser.Evaluate("document.getElementById('state').textContent"), "paused");
  const int first = browser.Evaluate(frame);
  browser.Evaluate("document.getElementById('button-step').click()");
  EXPECT_TRUE(browser.WaitFor(frame + " === " + std::to_string(first + 1))) << "one step";
  browser.Evaluate("document.getElementById('button-save').click()");
  EXPECT_TRUE(browser.WaitFor("document.getElementById('notice').textContent.includes('saved')"));
  browser.Evaluate("document.getElementById('button-pause').click()");
  EXPECT_TRUE(browser.WaitFor(frame + " > " + std::to_string(first + 5))) << "the image moves on";
  browser.Evaluate("document.getElementById('button-pause').click()");
  EXPECT_TRUE(browser.WaitFor("document.getElementById('state').textContent === 'paused'"));
  const std::string pixels =
      "(() => { const c = document.querySelector('canvas.picture'), d = c.getContext('2d')"
      ".getImageData(0, 0, c.width, c.height).data; return new Set(d).size; })()";
  EXPECT_GT(browser.Evaluate(pixels).get<int>(), 30) << "the image is not of one colour";
  if (apps::HasView3d()) {
    EXPECT_TRUE(browser.WaitFor("Highwall.live.scene.view.drawnPixels() > 500"));
  }
  EXPECT_TRUE(browser.errors().empty()) << browser.errors().front();
  browser.Evaluate("document.getElementById('button-stop').click()");
  EXPECT_EQ(browser.Evaluate("document.getElementById('button-stop').textContent"), "Really stop?");
  browser.Evaluate("document.getElementById('button-stop').click()");
  EXPECT_TRUE(
      browser.WaitFor("location.pathname === '/report' && "
                      "document.documentElement.dataset.state === 'drawn'"))
      << "the page becomes the report";
  EXPECT_EQ(program_->ExitCode(), 130);
  EXPECT_TRUE(browser.errors().empty()) << browser.errors().front();
}

}  // namespace
}  // namespace highwall::view_run_test
