// `highwall eval` with files of other tools: the formats that it reads and writes.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "files/trajectory_file.h"
#include "support/crc32.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::eval_formats_test {
namespace {

using nlohmann::json;
using testing::Contains;
using testing::Outcome;

constexpr std::int64_t kFirst = 1403715273262142976;  // [ns], not representable as a double

struct Sample {
  std::int64_t stamp;
  Eigen::Vector3d p;
  Eigen::Quaterniond q;
};

std::vector<Sample> Path(double error) {
  std::vector<Sample> path;
  for (int i = 0; i < 50; ++i) {
    const double t = 0.1 * i;
    path.push_back({kFirst + 100'000'000LL * i,
                    Eigen::Vector3d(t, std::sin(t), std::cos(t) + (i % 2 == 0 ? error : -error)),
                    Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * t, Eigen::Vector3d::UnitY()))});
  }
  return path;
}

template <class... Values>
std::string Print(const char* format, Values... values) {
  char line[600];
  std::snprintf(line, sizeof(line), format, values...);
  return line;
}

std::string Tum(const std::vector<Sample>& path) {
  std::string text = "# stamp tx ty tz qx qy qz qw\n";
  for (const auto& [stamp, p, q] : path) {
    text += Print("%lld.%09lld %.12f %.12f %.12f %.12f %.12f %.12f %.12f\n",
                  static_cast<long long>(stamp / 1'000'000'000),
                  static_cast<long long>(stamp % 1'000'000'000), p.x(), p.y(), p.z(), q.x(), q.y(),
                  q.z(), q.w());
  }
  return text;
}

std::string Euroc(const std::vector<Sample>& path) {
  std::string text = "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x []\n";
  for (const auto& [stamp, p, q] : path) {
    text += Print("%lld,%.12f,%.12f,%.12f,%.12f,%.12f,%.12f,%.12f,0.1,0.2,0.3,0,0,0,0,0,0\n",
                  static_cast<long long>(stamp), p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z());
  }
  return text;
}

std::string Kitti(const std::vector<Sample>& path) {
  std::string text;
  for (const auto& [stamp, p, q] : path) {
    const Eigen::Matrix3d R = q.toRotationMatrix();
    for (int row = 0; row < 3; ++row) {
      text += Print("%s%.12e %.12e %.12e %.12e", row > 0 ? " " : "", R(row, 0), R(row, 1),
                    R(row, 2), p[row]);
    }
    text += "\n";
  }
  return text;
}

// rostopic echo -p of nav_msgs/Odometry: received half a second late, stamped at the measurement.
std::string Ros1(const std::vector<Sample>& path) {
  std::string text =
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.child_frame_id,"
      "field.pose.pose.position.x,field.pose.pose.position.y,field.pose.pose.position.z,"
      "field.pose.pose.orientation.x,field.pose.pose.orientation.y,field.pose.pose.orientation.z,"
      "field.pose.pose.orientation.w,field.pose.covariance0\n";
  for (const auto& [stamp, p, q] : path) {
    text += Print("%lld,7,%lld,map,base,%.12f,%.12f,%.12f,%.12f,%.12f,%.12f,%.12f,0.5\n",
                  static_cast<long long>(stamp + 500'000'000), static_cast<long long>(stamp), p.x(),
                  p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

// ros2 topic echo --csv of PoseStamped or of Odometry, which names two frames.
std::string Ros2(const std::vector<Sample>& path, const char* frames) {
  std::string text;
  for (const auto& [stamp, p, q] : path) {
    text += Print("%lld,%lld,%s,%.12f,%.12f,%.12f,%.12f,%.12f,%.12f,%.12f\n",
                  static_cast<long long>(stamp / 1'000'000'000),
                  static_cast<long long>(stamp % 1'000'000'000), frames, p.x(), p.y(), p.z(), q.x(),
                  q.y(), q.z(), q.w());
  }
  return text;
}

class EvalFormats : public ::testing::Test {
 protected:
  void Write(const std::string& name, const std::string& text) const {
    testing::WriteText(folder_ / name, text);
  }
  Outcome Eval(const std::string& arguments) const {
    return testing::RunProgram(testing::kHighwallProgram, "eval " + arguments, folder_.path());
  }
  apps::TrajectoryFile Read(const std::string& name, const std::string& text) const {
    Write(name, text);
    return apps::ReadTrajectoryFile(folder_ / name);
  }
  void ExpectRefused(const std::string& name, const std::string& text,
                     const std::string& message) const {
    Write(name, text);
    Write("truth.txt", Tum(Path(0.0)));
    testing::ExpectRefused(Eval("ape truth.txt " + name), 2, {message});
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(EvalFormats, EveryFormatGivesTheSamePosesToTheNanosecond) {
  const std::vector<Sample> path = Path(0.0);
  const std::map<std::string, std::string> files = {{"tum", Tum(path)},
                                                    {"euroc", Euroc(path)},
                                                    {"ros1", Ros1(path)},
                                                    {"ros2", Ros2(path, "map")},
                                                    {"ros2_odometry", Ros2(path, "map,base")}};
  for (const auto& [name, text] : files) {
    SCOPED_TRACE(name);
    const apps::TrajectoryFile file = Read(name, text);
    EXPECT_TRUE(name.starts_with(ToString(file.format))) << ToString(file.format);
    ASSERT_EQ(file.poses.size(), path.size());
    for (std::size_t i = 0; i < path.size(); ++i) {
      EXPECT_EQ(file.poses[i].stamp, path[i].stamp);
      // The files have twelve decimals.
      EXPECT_LT((file.poses[i].pose.p() - path[i].p).norm(), 2e-12);
      EXPECT_LT(file.poses[i].pose.q().angularDistance(path[i].q), 1e-11);
    }
  }
}

TEST_F(EvalFormats, KittiHasNoStampsAndIsMatchedByPlace) {
  const apps::TrajectoryFile file = Read("kitti.txt", Kitti(Path(0.0)));
  EXPECT_EQ(file.format, apps::TrajectoryFormat::kKitti);
  ASSERT_EQ(file.poses.size(), 50u);
  EXPECT_EQ(file.poses[7].stamp, 7'000'000'000);
  EXPECT_LT((file.poses[7].pose.p() - Path(0.0)[7].p).norm(), 1e-12);
  EXPECT_LT(file.poses[7].pose.q().angularDistance(Path(0.0)[7].q), 1e-11);
  Write("estimate.txt", Kitti(Path(0.2)));
  const Outcome outcome = Eval("ape kitti.txt estimate.txt --align none --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(json::parse(outcome.out)["stats"]["rmse"], 0.2, 1e-11);
  EXPECT_TRUE(Contains(Eval("ape kitti.txt estimate.txt").out,
                       "evo_ape kitti kitti.txt estimate.txt -r trans_part -a\n"));
  std::vector<Sample> shorter = Path(0.2);
  shorter.pop_back();
  Write("shorter.txt", Kitti(shorter));
  testing::ExpectRefused(Eval("ape kitti.txt shorter.txt"), 2,
                         {"shorter.txt", "49 poses without stamps, the reference 50"});
  Write("tum.txt", Tum(Path(0.2)));
  testing::ExpectRefused(Eval("ape kitti.txt tum.txt"), 2, {"tum.txt", "one has no stamps"});
}

TEST_F(EvalFormats, AnEurocGroundTruthScoresATumEstimate) {
  Write("data.csv", Euroc(Path(0.0)));
  Write("estimate.txt", Tum(Path(0.25)));
  const Outcome outcome = Eval("ape data.csv estimate.txt --align none --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(json::parse(outcome.out)["stats"]["rmse"], 0.25, 1e-11);
  EXPECT_TRUE(Contains(Eval("rpe data.csv estimate.txt --delta 2 --all-pairs").out,
                       "evo_rpe euroc data.csv estimate.txt -r trans_part --t_max_diff 0.02 -d 2 "
                       "-u f --all_pairs\n"));
}

TEST_F(EvalFormats, BadLinesAreNamed) {
  ExpectRefused("a.csv", "1000,1,2,3,1,0,0\n", "a.csv:1: has 7 values");
  ExpectRefused("b.csv", "1000,1,2,3,1,0,0,0\n2000,1,x,3,1,0,0,0\n", "b.csv:2: ty 'x'");
  ExpectRefused("c.csv", "1000,1,2,3,0,0,0,0\n", "c.csv:1: the quaternion is zero");
  ExpectRefused("d.csv", "2000,1,2,3,1,0,0,0\n1000,1,2,3,1,0,0,0\n",
                "d.csv:2: the stamp goes back");
  ExpectRefused("e.csv", "1000,1,2,3,1,0,0,0\n1 2 3\n", "e.csv:2: expected values separated by");
  ExpectRefused("f.csv", "%time,field.data\n1000,1\n", "f.csv:2: the title names no 'position.x'");
  ExpectRefused("g.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1\n",
                "g.txt:2: expected the 12");
  ExpectRefused("h.txt", "2 0 0 0 0 1 0 0 0 0 1 0\n", "h.txt:1: the first 3 x 3");
  ExpectRefused("j.csv", "1e30,1,2,3,1,0,0,0\n", "j.csv:1: '1e30' is no stamp");
  ExpectRefused("k.csv", "10,1e9,map,1,2,3,0,0,0,1\n", "k.csv:1: '10' is no stamp");
  ExpectRefused("i.csv", "1000,1,nan,3,1,0,0,0\n", "i.csv:1: ty 'nan'");
}

TEST_F(EvalFormats, SeveralEstimatesAreOneTable) {
  Write("truth.txt", Tum(Path(0.0)));
  Write("good.txt", Tum(Path(0.01)));
  Write("bad, worse.txt", Tum(Path(0.5)));
  const std::string files = "truth.txt good.txt 'bad, worse.txt' --align none ";
  const json all = json::parse(Eval("ape " + files + "--json").out);
  ASSERT_EQ(all["estimates"].size(), 2u);
  EXPECT_EQ(all["reference"], "truth.txt");
  EXPECT_EQ(all["estimates"][1]["estimate"], "bad, worse.txt");
  json alone = json::parse(Eval("ape truth.txt good.txt --align none --json").out);
  alone["estimate"] = "good.txt";
  EXPECT_EQ(all["estimates"][0], alone);
  const std::string csv = Eval("ape " + files + "--csv").out;
  EXPECT_TRUE(csv.starts_with("estimate,rmse,mean,")) << csv;
  EXPECT_EQ(testing::CountLines(csv), 3u);
  const std::string last = "\n\"bad, worse.txt\",";
  ASSERT_TRUE(Contains(csv, last)) << csv;
  EXPECT_NEAR(std::stod(csv.substr(csv.find(last) + last.size())), 0.5, 1e-11);
  const std::string table = Eval("ape " + files).out;
  EXPECT_TRUE(Contains(table, "* good.txt")) << table;
  EXPECT_FALSE(Contains(table, "* bad")) << table;
  testing::ExpectRefused(Eval("ape truth.txt good.txt none.txt"), 2,
                         {"none.txt: cannot be opened"});
}

TEST_F(EvalFormats, PlotsOfSeveralNameEachAndHaveAScale) {
  Write("truth.txt", Tum(Path(0.0)));
  Write("good.txt", Tum(Path(0.01)));
  Write("bad.txt", Tum(Path(0.5)));
  ASSERT_EQ(Eval("ape truth.txt good.txt bad.txt --plot all.svg").exit_code, 0);
  const std::string svg = testing::ReadText(folder_ / "all.svg");
  EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
  for (const char* text : {"2 estimates against truth.txt", "reference", "good.txt: rmse 0.0",
                           "bad.txt: rmse 0.", "x [m]", "time [s]", "translation error [m]"}) {
    EXPECT_TRUE(Contains(svg, text)) << text;
  }
}

TEST_F(EvalFormats, APlotMayBeAPng) {
  Write("truth.txt", Tum(Path(0.0)));
  Write("bad.txt", Tum(Path(0.5)));
  for (const std::string estimates : {"bad.txt", "bad.txt bad.txt"}) {
    ASSERT_EQ(Eval("rpe truth.txt " + estimates + " --plot error.png").exit_code, 0);
    const cv::Mat image = cv::imread(folder_ / "error.png");
    ASSERT_EQ(image.cols, 2480) << "two pixels for one of the drawing";
    std::map<std::array<int, 3>, int> colours;
    for (int row = 0; row < image.rows; ++row) {
      for (int column = 0; column < image.cols; ++column) {
        const auto& pixel = image.at<cv::Vec3b>(row, column);
        ++colours[{pixel[2], pixel[1], pixel[0]}];
      }
    }
    const bool overlay = estimates != "bad.txt";
    // The colour of the first curve, and the viridis colours at both ends of the colour bar.
    EXPECT_GT((colours[overlay ? std::array{0, 114, 178} : std::array{74, 111, 165}]), 1000);
    EXPECT_EQ((colours[{68, 1, 84}]) > 100, !overlay);
    EXPECT_EQ((colours[{253, 231, 37}]) > 100, !overlay);
  }
}

// Returns the files of a zip archive, as listed in its central directory.
std::map<std::string, std::string> Unzipped(const std::string& bytes) {
  const auto number = [&](std::size_t at, int size) {
    std::uint32_t value = 0;
    for (int i = size; i-- > 0;)
      value = (value << 8) | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
    return value;
  };
  std::map<std::string, std::string> files;
  const std::size_t end = bytes.size() - 22;
  EXPECT_EQ(number(end, 4), 0x06054b50u);
  std::size_t at = number(end + 16, 4);
  for (std::uint32_t i = 0; i < number(end + 10, 2); ++i) {
    EXPECT_EQ(number(at, 4), 0x02014b50u);
    EXPECT_EQ(number(at + 10, 2), 0u) << "stored";
    const std::uint32_t size = number(at + 24, 4), name_size = number(at + 28, 2);
    const std::string name = bytes.substr(at + 46, name_size);
    const std::size_t local = number(at + 42, 4);
    EXPECT_EQ(number(local, 4), 0x04034b50u);
    EXPECT_EQ(bytes.substr(local + 30, name_size), name);
    const std::string content = bytes.substr(local + 30 + name_size, size);
    EXPECT_EQ(number(at + 16, 4), testing::Crc32(content));
    EXPECT_EQ(number(local + 14, 4), testing::Crc32(content));
    files[name] = content;
    at += 46 + name_size;
  }
  EXPECT_EQ(at, end);
  return files;
}

std::vector<double> FromNpy(const std::string& bytes) {
  EXPECT_EQ(bytes.substr(0, 8), std::string("\x93NUMPY\x01\x00", 8));
  const std::size_t header =
      static_cast<unsigned char>(bytes[8]) + 256u * static_cast<unsigned char>(bytes[9]);
  EXPECT_EQ((10 + header) % 64, 0u);
  EXPECT_TRUE(Contains(bytes.substr(10, header), "'descr': '<f8', 'fortran_order': False"));
  std::vector<double> values((bytes.size() - 10 - header) / 8);
  std::memcpy(values.data(), bytes.data() + 10 + header, 8 * values.size());
  EXPECT_TRUE(Contains(bytes, "'shape': (" + std::to_string(values.size()) + ",)"));
  return values;
}

TEST_F(EvalFormats, ResultsAreWrittenAsEvoSavesThem) {
  Write("truth.txt", Tum(Path(0.0)));
  Write("estimate.txt", Tum(Path(0.25)));
  const Outcome outcome =
      Eval("ape truth.txt estimate.txt --align none --evo-results a.zip --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto files = Unzipped(testing::ReadText(folder_ / "a.zip"));
  const json info = json::parse(files.at("info.json"));
  EXPECT_EQ(info["est_name"], "estimate.txt");
  EXPECT_EQ(info["ref_name"], "truth.txt");
  EXPECT_EQ(info["label"], "APE (m)");
  EXPECT_EQ(json::parse(files.at("stats.json")), json::parse(outcome.out)["stats"]);
  const std::vector<double> errors = FromNpy(files.at("error_array.npy"));
  const std::vector<double> seconds = FromNpy(files.at("seconds_from_start.npy"));
  ASSERT_EQ(errors.size(), 50u);
  ASSERT_EQ(seconds.size(), 50u);
  EXPECT_NEAR(errors[3], 0.25, 1e-11);
  EXPECT_NEAR(seconds[49], 4.9, 1e-9);
  EXPECT_EQ(FromNpy(files.at("timestamps.npy")).size(), 50u);
  testing::WriteText(folder_ / "again.txt", files.at("estimate.tum"));
  EXPECT_EQ(apps::ReadTrajectoryFile(folder_ / "again.txt").poses.size(), 50u);
}

TEST_F(EvalFormats, OfSeveralEstimatesEachHasAFileForEvo) {
  Write("truth.txt", Tum(Path(0.0)));
  Write("a.txt", Tum(Path(0.25)));
  ASSERT_EQ(Eval("rpe truth.txt a.txt a.txt --evo-results results").exit_code, 0);
  for (const char* name : {"results/1_a.zip", "results/2_a.zip"}) {
    const auto files = Unzipped(testing::ReadText(folder_ / name));
    EXPECT_EQ(json::parse(files.at("info.json"))["label"], "RPE (m)");
    EXPECT_EQ(FromNpy(files.at("error_array.npy")).size(), 49u);
  }
}

}  // namespace
}  // namespace highwall::eval_formats_test
