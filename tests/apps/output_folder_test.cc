// Tests how commands that write a folder of results treat a folder that contains other files.
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "run/folder_lock.h"
#include "run/output_checks.h"
#include "support/message_of.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::apps::output_folder_test {
namespace {

namespace fs = std::filesystem;
using testing::ReadText;
using testing::WriteText;
using Files = std::map<std::string, std::string>;

constexpr const char* kLogTitle = "# stamp tx ty tz qx qy qz qw\n";
const Files kRun = {{"run.json", R"({"versions": {"highwall": "0.2.0"}})"},
                    {"cloud.ply", "of the run"}};
const Files kMaps = {{"map.json", R"({"frames": 2, "cloud_over_octree": 9.5})"},
                     {"cloud.ply", "of the maps"}};

class OutputFolder : public ::testing::Test {
 protected:
  // Writes a recording that can be mapped.
  void SetUp() override { Fill("recording", {{"groundtruth.txt", "1 0 0 0 0 0 0 1\n"}}); }

  fs::path out() const { return folder_ / "out"; }
  fs::path Fill(const std::string& name, const Files& files) const {
    const fs::path folder = folder_ / name;
    fs::remove_all(folder);
    fs::create_directories(folder);
    for (const auto& [file, text] : files) WriteText(folder / file, text);
    return folder;
  }
  Files Content(const fs::path& folder) const {
    Files files;
    for (const auto& entry : fs::directory_iterator(folder)) {
      files[entry.path().filename().string()] = ReadText(entry.path());
    }
    return files;
  }
  testing::Outcome Highwall(const std::string& arguments) const {
    return testing::RunProgram(testing::kHighwallProgram, arguments, folder_.path());
  }
  // Commands that write to "out". Each fails for lack of data when it first reads them.
  static std::vector<std::pair<std::string, std::string>> Commands() {
    return {{"slam --dataset nowhere --out out", "nowhere: does not exist"},
            {"merge nothing nowhere --out out", "nothing: is not there"},
            {"map recording --out out", "recording"}};
  }
  void ExpectRefused(const std::string& command, const std::string& why) const {
    SCOPED_TRACE(command);
    const Files before = Content(out());
    testing::ExpectRefused(Highwall(command), 2, {why});
    EXPECT_EQ(Content(out()), before);
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(OutputFolder, OfOtherFilesIsRefusedAndStaysAsItWas) {
  const std::vector<Files> foreign = {
      {{"rgb.txt", "# a recording\n"}, {"trajectory.txt", "precious"}},
      {{"cloud.ply", "of another program"}},
      {{"notes.txt", "mine"}},
      {{"run.json", R"({"jobs": 3})"}, {"report.html", "of another program"}},
      {{"run.json", ""}},
      {{"run.json", R"(["versions", "highwall"])"}},
      {{"map.json", R"({"tiles": []})"}, {"map.bt", "of another program"}},
      {{"trajectory_causal.txt", "stamp,x,y,z\n"}},
  };
  for (const Files& files : foreign) {
    Fill("out", files);
    EXPECT_EQ(ContentOf(out()), FolderContent::kForeign) << files.begin()->first;
    for (const auto& [command, why] : Commands()) {
      ExpectRefused(command,
                    "out: holds files that are not of a run of Highwall: choose another folder, or "
                    "give --overwrite");
    }
  }
}

TEST_F(OutputFolder, OfAnythingButAFileInPlaceOfAReportIsRefused) {
  Fill("out", {});
  fs::create_directories(out() / "run.json" / "in the way");
  ::mkfifo((out() / "map.json").c_str(), 0600);
  ::mkfifo((out() / "trajectory_causal.txt").c_str(), 0600);
  EXPECT_EQ(ContentOf(out()), FolderContent::kForeign);
}

TEST_F(OutputFolder, InPlaceOfAReportIsSaidInOneLine) {
  fs::create_directories(folder_ / "run" / "run.json");
  for (const char* command :
       {"map run --out out", "report run", "merge run recording --out out", "calibrate run"}) {
    SCOPED_TRACE(command);
    testing::ExpectRefused(Highwall(command), 2, {"run"});
  }
}

TEST_F(OutputFolder, OfHighwallOrWithoutFilesIsWrittenTo) {
  using Content = FolderContent;
  const std::vector<std::pair<Files, FolderContent>> own = {
      {{}, Content::kNothing},
      {{{".directory", "of a desktop"}}, Content::kNothing},
      {kRun, Content::kRun},
      {{{"trajectory_causal.txt", kLogTitle}, {"keyframes.txt", kLogTitle}}, Content::kRun},
      {{{kLockFile, ""}, {"cloud.ply", "of a map that was killed"}}, Content::kUnfinished},
      {kMaps, Content::kMaps},
  };
  EXPECT_EQ(ContentOf(folder_ / "new"), Content::kNothing);
  for (const auto& [files, content] : own) {
    Fill("out", files);
    EXPECT_EQ(ContentOf(out()), content) << (files.empty() ? "empty" : files.begin()->first);
    for (const auto& [command, why] : Commands()) {
      const bool is_map = command.starts_with("map");
      if (content == (is_map ? Content::kRun : Content::kMaps)) continue;
      ExpectRefused(command, why);
    }
  }
}

TEST_F(OutputFolder, OfMapsIsNotThatOfARun) {
  Fill("out", kMaps);
  ExpectRefused("slam --dataset nowhere --out out", "out: holds the maps of highwall map");
}

TEST_F(OutputFolder, OfOtherFilesIsWrittenToWhereOverwriteIsGiven) {
  for (const Files& files : {Files{{"notes.txt", "mine"}}, kRun, kMaps}) {
    Fill("out", files);
    for (const auto& [command, why] : Commands()) ExpectRefused(command + " --overwrite", why);
  }
}

TEST_F(OutputFolder, OfADemoIsCheckedBeforeItsRecordingIsMade) {
  Fill("demo/run", {{"notes.txt", "mine"}});
  testing::ExpectRefused(Highwall("demo --out demo"), 2, {"demo/run: holds files that are not"});
  EXPECT_FALSE(fs::exists(folder_ / "demo" / "mine"));
}

TEST_F(OutputFolder, OfARunTakesNoMapsOfAnotherWorld) {
  Fill("out", kRun);
  ExpectRefused("map recording --out out", "out: holds a run, whose maps are of another world");
  Fill("other", kRun);
  WriteText(folder_ / "other" / "keyframes.txt", kLogTitle);
  ExpectRefused("map other --dataset recording --out out", "out: holds a run");
  // The output folder is the run itself, with its own poses or with others.
  const std::string itself = "map out --dataset recording --out ../" +
                             folder_.path().filename().string() + "/out --trajectory ";
  for (const char* file : {"keyframes.txt", "trajectory.txt", "trajectory_adjusted.txt",
                           "trajectory_2.txt", "trajectory_causal.txt"}) {
    WriteText(out() / file, kLogTitle);
  }
  ExpectRefused(itself + "recording/groundtruth.txt", "out: holds a run");
  ExpectRefused(itself + "out/trajectory_2.txt", "out: holds a run");
  ExpectRefused(itself + "out/trajectory_causal.txt", "out: holds a run");
  ExpectRefused(itself + "out/trajectory.txt", "highwall map: recording");
  ExpectRefused(itself + "out/trajectory_adjusted.txt", "highwall map: recording");
  ExpectRefused("map out --dataset recording --out out", "highwall map: recording");
}

TEST_F(OutputFolder, RefusesToWriteIntoTheFolderOfTheMapThatItContinues) {
  Fill("out", kRun);
  WriteText(out() / "map.hwmap", "of the first session");
  WriteText(out() / "saved.hwmap", "of the first session");
  fs::create_symlink(out() / "saved.hwmap", folder_ / "link.hwmap");
  fs::create_hard_link(out() / "map.hwmap", folder_ / "same.hwmap");
  const std::string slam = "slam --dataset nowhere --out out --load-map ";
  for (const char* map :
       {"out/map.hwmap", "out/saved.hwmap", "./out/../out/map.hwmap", "link.hwmap", "same.hwmap"}) {
    ExpectRefused(slam + map, std::string(map) + ": is in the folder of --out");
    ExpectRefused(slam + map + " --localize", "is in the folder of --out");
    ExpectRefused(slam + map + " --overwrite", "nowhere: does not exist");
  }
  fs::copy_file(out() / "map.hwmap", folder_ / "apart.hwmap");
  ExpectRefused(slam + "apart.hwmap", "nowhere: does not exist");
}

TEST_F(OutputFolder, IsNotALinkToNowhere) {
  fs::create_symlink("gone", folder_ / "link");
  for (const char* name : {"link", "link/", "link/run"}) {
    const auto outcome = Highwall(std::string("slam --dataset nowhere --out ") + name);
    testing::ExpectRefused(outcome, 2, {"link: is a link to gone, which is not there"});
  }
}

// A command that waits for its data until it is killed.
class WaitingCommand {
 public:
  WaitingCommand(const fs::path& folder, const fs::path& out)
      : program_(testing::kHighwallProgram,
                 {"slam", "--dataset", Recording(folder), "--out", out.string()}) {
    while (program_.IsRunning() && !fs::exists(out / kLockFile)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void Kill() { program_.Kill(); }

 private:
  // Its list of images is a pipe that has no writer.
  static std::string Recording(const fs::path& folder) {
    const fs::path recording = folder / "waiting";
    fs::create_directories(recording);
    ::mkfifo((recording / "rgb.txt").c_str(), 0600);
    return recording.string();
  }

  testing::BackgroundProgram program_;
};

TEST_F(OutputFolder, IsOfOneCommandAtATime) {
  WaitingCommand first(folder_.path(), out());
  for (const auto& [command, why] : Commands()) {
    ExpectRefused(command, "out: another command of Highwall is writing to this folder");
    ExpectRefused(command + " --overwrite", "out: another command of Highwall");
  }
  testing::ExpectRefused(Highwall("slam --dataset nowhere --out elsewhere"), 2,
                         {"nowhere: does not exist"});
  first.Kill();
  for (const auto& [command, why] : Commands()) {
    testing::ExpectRefused(Highwall(command), 2, {why});
  }
}

TEST_F(OutputFolder, LockLeavesNothingBehindWhereNothingWasWritten) {
  const fs::path deep = folder_ / "a" / "b";
  {
    const FolderLock lock(deep);
    EXPECT_TRUE(fs::exists(deep / kLockFile));
    EXPECT_NE(testing::MessageOf<IoError>([&] { FolderLock second(deep); }).find("another command"),
              std::string::npos);
    EXPECT_TRUE(fs::exists(deep / kLockFile)) << "it is that of the first";
  }
  EXPECT_FALSE(fs::exists(folder_ / "a"));
  fs::create_directories(folder_ / "a");
  {
    const FolderLock lock(deep.string() + "/");
    for (const auto& [file, text] : kRun) WriteText(deep / file, text);
  }
  EXPECT_EQ(Content(deep), kRun);
  fs::remove(deep / "run.json");
  { const FolderLock lock(deep); }
  EXPECT_EQ(Content(deep), (Files{{"cloud.ply", "of the run"}})) << "of another program";
  fs::remove_all(deep);
  { const FolderLock lock(deep); }
  EXPECT_EQ(Content(folder_ / "a"), Files());
}

TEST_F(OutputFolder, LockStaysAsTheMarkOfResultsThatAreNotFinished) {
  {
    const FolderLock lock(out());
    WriteText(out() / "cloud.ply", "half of a map");
  }
  EXPECT_EQ(ContentOf(out()), FolderContent::kUnfinished);
  { const FolderLock lock(out()); }
  EXPECT_EQ(ContentOf(out()), FolderContent::kUnfinished);
  {
    const FolderLock lock(out());
    WriteText(out() / "map.json", kMaps.at("map.json"));
  }
  EXPECT_EQ(Content(out()).size(), 2U);
}

}  // namespace
}  // namespace highwall::apps::output_folder_test
