// Runs scripts/get_tum in the same way as a user; the "server" is a folder.
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "support/generated_tum.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::get_tum_test {
namespace {

using testing::Contains;
using testing::Outcome;
using testing::ReadText;
using testing::WriteText;

class GetTum : public ::testing::Test {
 protected:
  // Writes an archive of the folder on the "server".
  void Pack(const std::string& folder, const std::string& archive) const {
    std::filesystem::create_directories(server_.path());
    const Outcome outcome = testing::RunProgram(
        "tar", "-czf " + (server_ / archive).string() + " " + folder, work_.path());
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  void PackTum() const {
    testing::WriteTum(work_ / "rgbd_dataset_freiburg1_xyz", {.frames = 2});
    Pack("rgbd_dataset_freiburg1_xyz", "rgbd_dataset_freiburg1_xyz.tgz");
  }
  Outcome Get(const std::string& options) const {
    return testing::RunProgram(
        std::string(testing::kSourceFolder) + "/scripts/get_tum",
        "--to data --mirror file://" + server_.path().string() + " " + options, work_.path());
  }
  std::filesystem::path File(const std::string& name) const { return work_ / name; }

  testing::TemporaryDirectory server_{"server"}, work_{"work"};
};

TEST_F(GetTum, ASequenceOfTumIsReadyByItsShortName) {
  PackTum();
  Outcome outcome = Get("fr1_xyz");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.out, "fr1_xyz is in data/fr1_xyz"));
  EXPECT_EQ(ReadText(File("data/fr1_xyz/rgb.txt")),
            ReadText(File("rgbd_dataset_freiburg1_xyz/rgb.txt")));
  EXPECT_TRUE(std::filesystem::exists(File("data/fr1_xyz/rgb/100.png")));
  EXPECT_FALSE(std::filesystem::exists(File("data/rgbd_dataset_freiburg1_xyz.tgz")));
  std::filesystem::remove_all(server_.path());
  outcome = Get("fr1_xyz");
  EXPECT_EQ(outcome.exit_code, 0) << "what is there is not fetched again";
}

TEST_F(GetTum, ContinuesAnInterruptedDownload) {
  PackTum();
  const std::string name = "rgbd_dataset_freiburg1_xyz.tgz";
  const std::string whole = ReadText(server_ / name);
  std::filesystem::create_directories(File("data"));
  WriteText(File("data/" + name + ".part"), whole.substr(0, whole.size() / 2));
  EXPECT_EQ(Get("fr1_xyz").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(File("data/fr1_xyz/depth.txt")));
}

TEST_F(GetTum, AnArchiveThatIsDamagedIsRefusedAndOneThatIsTooLongFetchedAnew) {
  PackTum();
  const std::string name = "rgbd_dataset_freiburg1_xyz.tgz";
  std::filesystem::create_directories(File("data"));
  WriteText(File("data/" + name), ReadText(server_ / name).substr(0, 100));
  const Outcome outcome = Get("fr1_xyz");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "is damaged: remove it")) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(File("data/fr1_xyz")));
  std::filesystem::remove(File("data/" + name));
  WriteText(File("data/" + name + ".part"), ReadText(server_ / name) + "and more");
  EXPECT_EQ(Get("fr1_xyz").exit_code, 0);
}

TEST_F(GetTum, WithoutANetworkItAdvisesAndTakesLocalFiles) {
  const std::string unreachable = "--mirror http://127.0.0.1:9 fr1_xyz";
  Outcome outcome = Get(unreachable);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err,
                       "get_tum: cannot fetch http://127.0.0.1:9/rgbd_dataset_freiburg1_xyz.tgz; "
                       "without a network get it elsewhere, put it into data, and run this again"))
      << outcome.err;
  PackTum();
  std::filesystem::copy(server_ / "rgbd_dataset_freiburg1_xyz.tgz", File("data"));
  outcome = Get(unreachable);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(File("data/fr1_xyz/rgb.txt")));
}

TEST_F(GetTum, TheLeftHandedWorldOfIclIsMirrored) {
  testing::WriteTum(work_.path(), {.frames = 2, .width = 640, .height = 480});
  WriteText(File("associations.txt"),
            "0 depth/100.png 0 rgb/100.png\n3 depth/101.png 3 rgb/101.png\n");
  WriteText(File("traj1.gt.freiburg"), "0 1 2 3 0.1 0.2 0.3 0.9\n3 1 -2 3 0 0 0 1\n");
  Pack("rgb depth associations.txt traj1.gt.freiburg", "traj1_frei_png.tar.gz");
  const Outcome outcome = Get("icl_office_1");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::filesystem::path folder = File("data/icl_office_1");
  EXPECT_EQ(ReadText(folder / "rgb.txt"), "0.000000 rgb/100.png\n0.100000 rgb/101.png\n");
  EXPECT_EQ(ReadText(folder / "depth.txt"), "0.000000 depth/100.png\n0.100000 depth/101.png\n");
  EXPECT_EQ(ReadText(folder / "groundtruth.txt"),
            "0.000000 1 -2 3 -0.1 0.2 -0.3 0.9\n0.100000 1 2 3 -0 0 -0 1\n");
  EXPECT_TRUE(Contains(ReadText(folder / "calibration.yaml"), "fy: 480,"));
}

TEST_F(GetTum, PartsOfEth3dBecomeOneFolderWithACalibration) {
  testing::WriteTum(work_ / "cables", {.frames = 2, .width = 739, .height = 458});
  WriteText(File("cables/calibration.txt"), "726.2 726.3 359.2 202.4\n");
  const auto zip = [&](const std::string& archive, const std::string& files) {
    const Outcome outcome = testing::RunProgram(
        "python3", "-m zipfile -c " + (server_ / archive).string() + " " + files, work_.path());
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  };
  zip("cables_mono.zip", "cables");
  zip("cables_rgbd.zip", "cables");
  const Outcome outcome = Get("eth3d_cables");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(File("data/eth3d_cables/depth/100.png")));
  EXPECT_EQ(ReadText(File("data/eth3d_cables/calibration.yaml")),
            "camera: {width: 739, height: 458, fx: 726.2, fy: 726.3, cx: 359.2, cy: 202.4}\n"
            "depth_factor: 5000\n");
}

TEST_F(GetTum, RefusesUnknownSequencesInOneLine) {
  testing::ExpectRefused(Get("fr1_garden"), 2, {"fr1_garden", "docs/reference/sequences.md"});
  testing::ExpectRefused(Get("icl_office_4"), 2, {"icl_office_0 to 3"});
  testing::ExpectRefused(Get("kitti_00"), 2, {"kitti_00: unknown"});
  EXPECT_EQ(Get("").exit_code, 1);
}

TEST(Datasets, TheListHoldsAll47SequencesOfTum) {
  const std::string page = ReadText(std::string(testing::kSourceFolder) + "/docs/reference/sequences.md");
  int rows = 0;
  for (std::size_t at = 0; (at = page.find("\n| fr", at)) != std::string::npos; ++at) ++rows;
  EXPECT_EQ(rows, 47);
}

}  // namespace
}  // namespace highwall::get_tum_test
