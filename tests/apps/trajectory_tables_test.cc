// Tables of poses by any program: identifies the column, unit and order of each value.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "files/trajectory_file.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::trajectory_tables_test {
namespace {

using testing::Contains;
using testing::Outcome;

constexpr std::int64_t kUnix = 1'403'636'580'000'000'000;  // [ns]

// The format in which a program writes its poses.
struct Form {
  std::string heading{};  // with its end of line, or empty
  char separator = ' ';
  double unit = 1e9;           // [ns] of a stamp
  int decimals = 9;            // of a stamp
  std::int64_t start = kUnix;  // [ns] the first stamp
  bool w_first = false;
  std::string before{}, behind{};  // further columns, with their separators
};

Pose PoseAt(int i, double error) {
  const double t = 0.1 * i;
  const Eigen::Quaterniond q(
      Eigen::AngleAxisd(0.4 + 0.3 * t, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
  return Pose(q, {t, std::sin(t), std::cos(t) + (i % 2 == 0 ? error : -error)});
}

std::string Number(const char* format, double value) {
  std::array<char, 400> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string StampText(const Form& form, std::int64_t nanoseconds) {
  const auto unit = static_cast<std::int64_t>(form.unit);
  std::string text = std::to_string(nanoseconds / unit);
  if (form.decimals == 0) return text;
  std::string rest = std::to_string(1'000'000'000 + nanoseconds % unit * (1'000'000'000 / unit));
  return text + "." + rest.substr(1, static_cast<std::size_t>(form.decimals));
}

// 40 poses, 0.1 s apart.
std::string Table(const Form& form, double error = 0.0) {
  std::string text = form.heading;
  for (int i = 0; i < 40; ++i) {
    const Pose pose = PoseAt(i, error);
    text += form.before + StampText(form, form.start + 100'000'000LL * i);
    const auto add = [&](double value) { text += form.separator + Number("%.12f", value); };
    for (int k = 0; k < 3; ++k) add(pose.data()[k]);
    if (form.w_first) add(pose.q().w());
    for (int k = 3; k < (form.w_first ? 6 : 7); ++k) add(pose.data()[k]);
    text += form.behind + "\n";
  }
  return text;
}

class TrajectoryTables : public ::testing::Test {
 protected:
  apps::TrajectoryFile Read(const std::string& text) const {
    testing::WriteText(folder_ / "poses.txt", text);
    return apps::ReadTrajectoryFile(folder_ / "poses.txt");
  }
  Outcome Eval(const std::string& arguments) const {
    return testing::RunProgram(testing::kHighwallProgram, "eval " + arguments, folder_.path());
  }
  // Stamps match to the nanosecond, poses to the digits of the file.
  void ExpectPoses(const std::string& text, std::int64_t start = kUnix) const {
    const apps::TrajectoryFile file = Read(text);
    ASSERT_EQ(file.poses.size(), 40u);
    for (int i = 0; i < 40; ++i) {
      const StampedPose& pose = file.poses[static_cast<std::size_t>(i)];
      EXPECT_EQ(pose.stamp, start + 100'000'000LL * i);
      EXPECT_LT((pose.pose.p() - PoseAt(i, 0.0).p()).norm(), 2e-12);
      EXPECT_LT(pose.pose.q().angularDistance(PoseAt(i, 0.0).q()), 1e-11);
    }
  }
  std::string Refusal(const std::string& text) const {
    try {
      Read(text);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  const testing::TemporaryDirectory folder_;
};

TEST_F(TrajectoryTables, AHeadingNamesColumnsAndUnit) {
  const std::map<std::string, Form> forms = {
      {"TUM", {.heading = "# timestamp tx ty tz qx qy qz qw\n"}},
      {"TUM with w first", {.heading = "# timestamp tx ty tz qw qx qy qz\n", .w_first = true}},
      {"no #", {.heading = "timestamp tx ty tz qx qy qz qw\n"}},
      {"no #, commas", {.heading = "timestamp,tx,ty,tz,qx,qy,qz,qw\n", .separator = ','}},
      {"seconds, commas, w first",
       {.heading = "#time(s),px,py,pz,qw,qx,qy,qz\n", .separator = ',', .w_first = true}},
      {"semicolons",
       {.heading = "t [s]; x [m]; y [m]; z [m]; qx; qy; qz; qw\r\n", .separator = ';'}},
      {"EuRoC",
       {.heading = "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x "
                   "[], q_RS_y [], q_RS_z [], v_RS_R_x [m s^-1]\n",
        .separator = ',',
        .unit = 1,
        .decimals = 0,
        .w_first = true,
        .behind = ",0.5"}},
      {"nanoseconds with w last",
       {.heading = "#timestamp [ns],tx,ty,tz,qx,qy,qz,qw\n",
        .separator = ',',
        .unit = 1,
        .decimals = 0}},
      {"counter", {.heading = "num t x y z qx qy qz qw\n", .before = "7 "}},
      {"Stray Scanner",
       {.heading = "timestamp, frame, x, y, z, qx, qy, qz, qw\n", .separator = ','}},
      {"RTAB-Map", {.heading = "#timestamp x y z qx qy qz qw id\n", .behind = " 12"}},
      {"OpenVINS",
       {.heading = "# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12\n", .behind = " 0.1 0.2 0.3"}},
      {"words in front of it", {.heading = "# columns are: timestamp tx ty tz qx qy qz qw\n"}},
      {"ROS's names",
       {.heading = "Time,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,"
                   "pose.orientation.y,pose.orientation.z,pose.orientation.w\n",
        .separator = ','}},
      {"milliseconds", {.heading = "t_ms x y z qx qy qz qw\n", .unit = 1e6, .decimals = 0}}};
  for (auto [name, form] : forms) {
    SCOPED_TRACE(name);
    std::string text = Table(form);
    if (name == "Stray Scanner") {
      for (std::size_t at = text.find('\n'); at + 1 < text.size(); at = text.find('\n', at + 1)) {
        text.insert(text.find(',', at), ",000007");
      }
    }
    ExpectPoses(text);
    EXPECT_EQ(Read(text).assumed, "");
  }
}

TEST_F(TrajectoryTables, ValuesDecideTheUnitAndSayTheOrderThatIsTaken) {
  const Form commas{.separator = ','};
  ExpectPoses(Table(commas));
  EXPECT_TRUE(Contains(Read(Table(commas)).assumed, "in seconds and quaternions as x y z w"));

  Form small = commas;
  small.start = 1'000'000'000;
  small.decimals = 6;
  ExpectPoses(Table(small), small.start);
  EXPECT_TRUE(Contains(Read(Table(small)).assumed, "in seconds and quaternions as x y z w"));

  Form euroc{.separator = ',', .unit = 1, .decimals = 0, .w_first = true};
  ExpectPoses(Table(euroc));
  EXPECT_TRUE(Contains(Read(Table(euroc)).assumed, "in nanoseconds and quaternions as w x y z"));
  euroc.behind = ",0,0,0,0,0,0,0,0,0";
  ExpectPoses(Table(euroc));
  EXPECT_EQ(Read(Table(euroc)).assumed, "") << "17 columns are EuRoC's ground truth";
}

TEST_F(TrajectoryTables, AFirstPoseWithoutRotationRevealsTheOrder) {
  const std::string pose = ",0.1,0.2,0.3,";
  for (const std::string& stamp : {std::string("1.5"), std::string("1403636580000000000")}) {
    for (const bool w_first : {false, true}) {
      const apps::TrajectoryFile file = Read(stamp + pose + (w_first ? "1,0,0,0\n" : "0,0,0,1\n"));
      EXPECT_LT(file.poses[0].pose.Angle(), 1e-15);
      EXPECT_TRUE(Contains(file.assumed, w_first ? "w x y z" : "x y z w")) << file.assumed;
    }
  }
}

TEST_F(TrajectoryTables, TheUnitFollowsFromYearsAndFromThePace) {
  // ORB-SLAM3 writes EuRoC's poses so: nanoseconds with a fraction, separated by blanks, w last.
  ExpectPoses(Table({.unit = 1, .decimals = 6}));
  ExpectPoses(Table({.unit = 1, .decimals = 0}));
  ExpectPoses(Table({.unit = 1e3, .decimals = 0}));
  ExpectPoses(Table({.unit = 1e6, .decimals = 3}));
  for (const double unit : {1.0, 1e3, 1e6, 1e9}) {
    EXPECT_EQ(Read(Table({.unit = unit, .decimals = unit > 1e8 ? 9 : 0})).assumed, "");
  }
  // Stamps count from the start of a recording, or of a machine eight days ago: only the rate gives
  // the unit.
  for (const std::int64_t start : {std::int64_t{0}, 700'000'000'000'000}) {
    ExpectPoses(Table({.unit = 1, .decimals = 0, .start = start}), start);
    EXPECT_TRUE(Contains(Read(Table({.unit = 1, .decimals = 0, .start = start})).assumed,
                         "stamps in nanoseconds"));
    ExpectPoses(Table({.start = start}), start);
    EXPECT_EQ(Read(Table({.start = start})).assumed, "");
  }
}

TEST_F(TrajectoryTables, AssumesSecondsWhereTheHeadingStatesAnImpossibleUnit) {
  const Form form{
      .heading = "#timestamp [ns],px,py,pz,qw,qx,qy,qz\n", .separator = ',', .w_first = true};
  ExpectPoses(Table(form));
  EXPECT_TRUE(Contains(Read(Table(form)).assumed, "stamps in seconds"));
}

TEST_F(TrajectoryTables, ColumnsBehindThePoseNeedAUnitQuaternionOrAHeading) {
  ExpectPoses(Table({.behind = " 17"}));
  EXPECT_TRUE(Contains(Read(Table({.behind = " 17"})).assumed, "tx ty tz qx qy qz qw"));
  EXPECT_TRUE(Contains(Refusal(Table({.before = "7 "})), "poses.txt:1: its values 5 to 8"));
}

TEST_F(TrajectoryTables, SixteenNumbersAreAMatrix) {
  const std::string pose = "0 -1 0 1.5 1 0 0 2.5 0 0 1 3.5 ";
  const apps::TrajectoryFile file = Read(pose + "0 0 0 1\n" + pose + "0 0 0 1\n");
  ASSERT_EQ(file.poses.size(), 2u);
  EXPECT_FALSE(apps::HasStamps(file.format));
  EXPECT_EQ(file.poses[1].stamp, 1'000'000'000);
  EXPECT_EQ(file.poses[1].pose.p(), Eigen::Vector3d(1.5, 2.5, 3.5));
  EXPECT_NEAR(file.poses[1].pose.Angle(), M_PI / 2.0, 1e-12);
  EXPECT_TRUE(Contains(Refusal(pose + "0 0 0 1\n" + pose + "0 0 1 1\n"),
                       "poses.txt:2: the last row of the matrix"));
  EXPECT_TRUE(Contains(Refusal(pose + "0 0 0 1\n" + pose + "\n"), "poses.txt:2: expected the 16"));
}

TEST_F(TrajectoryTables, EncodingsAndEndsOfLinesOfAnySystemAreRead) {
  ExpectPoses("\xef\xbb\xbf" + Table({}));
  ExpectPoses("\xef\xbb\xbf" + Table({.heading = "# timestamp tx ty tz qx qy qz qw\n"}));
  std::string utf16 = "\xff\xfe", mac = Table({});
  for (const char c : mac) utf16 += {c, '\0'};
  ExpectPoses(utf16);
  ExpectPoses(utf16.substr(2));
  std::ranges::replace(mac, '\n', '\r');
  ExpectPoses(mac);
}

TEST_F(TrajectoryTables, DecimalCommasAndQuotesOfSpreadsheetsAreRead) {
  const std::string heading = "timestamp;tx;ty;tz;qx;qy;qz;qw\n";
  for (const Form& form : {Form{.heading = heading, .separator = ';'}, Form{.separator = '\t'}}) {
    std::string text = Table(form);
    std::ranges::replace(text, '.', ',');
    ExpectPoses(text);
  }
  std::string quoted;
  for (const char c : "timestamp,tx,ty,tz,qx,qy,qz,qw\n" + Table({.separator = ','})) {
    if (quoted.empty() || quoted.back() == '\n') quoted += '"';
    quoted += c == ',' ? "\",\"" : c == '\n' ? "\"\n" : std::string{c};
  }
  ExpectPoses(quoted);
}

// The first pose of these happens to resemble a position and a quaternion.
TEST_F(TrajectoryTables, OtherNumbersThanPositionAndQuaternionAreRefusedWithTheirLine) {
  const std::string matrices =
      "1 1 0 0 0 0 1 0 0 0 0 1 0\n2 0 -1 0 0.5 1 0 0 0.7 0 0 1 0.3\n3 0 -1 0 1 1 0 0 1 0 0 1 1\n";
  EXPECT_TRUE(Contains(Refusal(matrices), "poses.txt:2: its values 5 to 8")) << Refusal(matrices);
  EXPECT_TRUE(Contains(Refusal("# time r11 r12 r13 tx r21 r22 r23 ty r31 r32 r33 tz\n" + matrices),
                       "poses.txt:3: its values 5 to 8"));
  for (const std::string separator : {" ", ","}) {
    std::string text;
    for (const std::string values : {"1 0 0 0 1 0 0 0", "2 0.6 0.8 0 0 0.3 0.4 0.5"}) {
      for (const char c : values) text += c == ' ' ? separator : std::string{c};
      text += "\n";
    }
    EXPECT_TRUE(Contains(Refusal(text), "poses.txt:2: its values 5 to 8")) << Refusal(text);
  }
}

TEST_F(TrajectoryTables, RefusesOtherTextNamingItsLine) {
  EXPECT_TRUE(Contains(Refusal("hello world\n" + Table({})), "poses.txt:1: is neither a pose nor"));
  EXPECT_TRUE(Contains(Refusal("a b c\n"), "poses.txt:1: is neither a pose nor"));
  EXPECT_TRUE(Contains(Refusal(Table({}) + "timestamp tx ty tz qx qy qz qw\n"),
                       "poses.txt:41: the stamp 'timestamp' is not a number"));
  EXPECT_TRUE(
      Contains(Refusal("1-5;0,5;0;0;0;0;0;1\n"), "poses.txt:1: the stamp '1-5' is not a number"));
  EXPECT_TRUE(Contains(Refusal("1e19 0 0 0 0 0 0 1\n"), "poses.txt:1: '1e19' is no stamp"));
  EXPECT_TRUE(
      Contains(Refusal("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"), "poses.txt:2: the stamp goes"));
}

TEST_F(TrajectoryTables, EvalGivesOneFigureForEveryForm) {
  testing::WriteText(folder_ / "truth.txt", Table({}));
  testing::WriteText(folder_ / "truth.csv", Table({.separator = ','}));
  const std::map<std::string, Form> forms = {
      {"tum.txt", {}},
      {"commas.csv", {.separator = ','}},
      {"euroc.csv", {.separator = ',', .unit = 1, .decimals = 0, .w_first = true}},
      {"orb_slam3.txt", {.unit = 1, .decimals = 6}},
      {"rtabmap.txt", {.heading = "#timestamp x y z qx qy qz qw id\n", .behind = " 3"}}};
  for (const auto& [name, form] : forms) {
    testing::WriteText(folder_ / name, Table(form, 0.2));
    for (const std::string reference : {"truth.txt ", "truth.csv "}) {
      const Outcome outcome = Eval("ape " + reference + name + " --align none --json");
      ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
      EXPECT_NEAR(nlohmann::json::parse(outcome.out)["stats"]["rmse"], 0.2, 1e-11) << name;
      const Outcome angle =
          Eval("ape " + reference + name + " --align none --relation angle_deg --json");
      EXPECT_LT(nlohmann::json::parse(angle.out)["stats"]["max"], 1e-8) << name;
      const bool open = name == "commas.csv" || name == "euroc.csv" || reference == "truth.csv ";
      EXPECT_EQ(Contains(outcome.err, "highwall eval: warning: "), open) << outcome.err;
    }
  }
}

TEST_F(TrajectoryTables, EvalRefusesEqualStampsWithTheirLine) {
  testing::WriteText(folder_ / "truth.txt", Table({}));
  const std::string heading = "# timestamp tx ty tz qx qy qz qw\n";
  std::string doubled = Table({.heading = heading});
  const std::size_t third = doubled.find('\n', doubled.find('\n', heading.size()) + 1) + 1;
  doubled.insert(third, doubled.substr(third, doubled.find('\n', third) + 1 - third));
  testing::WriteText(folder_ / "doubled.txt", doubled);
  testing::WriteText(folder_ / "rounded.txt", Table({.unit = 1e9, .decimals = 0}));
  for (const std::string metric : {"ape ", "rpe "}) {
    for (const std::string files : {"truth.txt doubled.txt", "doubled.txt truth.txt"}) {
      testing::ExpectRefused(Eval(metric + files), 2,
                             {"doubled.txt:5: has the stamp of the pose before it, as 1 of 41"});
    }
    testing::ExpectRefused(Eval(metric + "rounded.txt rounded.txt --align origin"), 2,
                           {"rounded.txt:2: has the stamp of the pose before it, as 36 of 40"});
  }
}

// As in fr2_desk's motion capture, which rounds to a tenth of a millisecond.
TEST_F(TrajectoryTables, OneEqualStampAmongThousandsIsLeftOutAndSaid) {
  std::string text;
  for (int i = 0; i < 1500; ++i) {
    const double t = 0.01 * (i == 700 ? 699 : i);
    text +=
        Number("%.6f ", t) + Number("%.6f ", 0.02 * i) + Number("%.6f 0 0 0 0 1\n", std::sin(i));
  }
  testing::WriteText(folder_ / "truth.txt", text);
  const Outcome outcome = Eval("ape truth.txt truth.txt --align none --json");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "truth.txt: left out 1 of 1500 poses")) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "in line 701")) << outcome.err;
  const nlohmann::json json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["stats"]["max"], 0.0);
  EXPECT_EQ(json["associated"], 1499);
}

TEST_F(TrajectoryTables, OnlyWhatEvoReadsHasACommandOfEvo) {
  testing::WriteText(folder_ / "tum.txt", Table({}));
  testing::WriteText(folder_ / "bare.txt", Table({.heading = "t tx ty tz qx qy qz qw\n"}));
  EXPECT_TRUE(Contains(Eval("ape tum.txt tum.txt").out, "evo_ape tum tum.txt tum.txt"));
  const Outcome outcome = Eval("ape bare.txt bare.txt");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(Contains(outcome.out, "evo_ape")) << outcome.out;
}

}  // namespace
}  // namespace highwall::trajectory_tables_test
