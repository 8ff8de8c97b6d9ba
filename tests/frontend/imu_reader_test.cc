#include <highwall/frontend/input/dataset.h>

#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <highwall/core/error.h>

#include "support/generated_tum.h"

namespace highwall::imu_reader_test {
namespace {

using testing::TemporaryDirectory;
using testing::WriteText;

constexpr Stamp kSecond = 1'000'000'000;
constexpr VideoSpan kToday{1403715273 * kSecond, 1403715280 * kSecond};
constexpr VideoSpan kFromOne{1 * kSecond, 9 * kSecond};
constexpr const char* kHeader =
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";

ImuRecording ReadText(const std::string& text, const VideoSpan& video = kToday) {
  const TemporaryDirectory folder("text");
  WriteText(folder.path() / "imu.csv", text);
  return ReadImu(folder.path() / "imu.csv", video);
}

// Returns the message of the error, without the path of the file.
std::string Message(const std::string& text, const VideoSpan& video = kToday) {
  const TemporaryDirectory folder("message");
  const std::string path = (folder.path() / "imu.csv").string();
  WriteText(path, text);
  try {
    ReadImu(path, video);
  } catch (const IoError& error) {
    const std::string message = error.what();
    EXPECT_TRUE(message.starts_with(path)) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message.substr(path.size());
  }
  return "accepted";
}

TEST(ReadImu, ReadsTheColumnsOfEuroc) {
  const ImuRecording imu = ReadText(std::string(kHeader) +
                                    "1403715273262142976,-0.1,0.2,3e-1,9.5,-0.25,-3\n"
                                    "1403715273267142912,1,2,3,4,5,6\n");
  EXPECT_EQ(imu.warning, "");
  ASSERT_EQ(imu.samples.size(), 2U);
  EXPECT_EQ(imu.samples[0].stamp, 1403715273262142976);
  EXPECT_EQ(imu.samples[0].gyroscope, Eigen::Vector3d(-0.1, 0.2, 0.3));
  EXPECT_EQ(imu.samples[0].accelerometer, Eigen::Vector3d(9.5, -0.25, -3.0));
  EXPECT_EQ(imu.samples[1].stamp, 1403715273267142912);
}

TEST(ReadImu, ToleratesHeadingsCommentsBlanksAndCarriageReturns) {
  const std::string line = "1403715274000000000, 1, 2, 3, 4, 5, 6\r\n";
  for (const std::string& head :
       {std::string(), std::string("timestamp,wx,wy,wz,ax,ay,az\r\n"), std::string("\"t\",x\n"),
        std::string("# a\n\n  \n# b\n"), std::string("\xef\xbb\xbf#t\n")}) {
    EXPECT_EQ(ReadText(head + line + "# end\n").samples.size(), 1U) << head;
  }
}

// Reads a heading and a line, whose reading must be gyroscope 1 2 3, accelerometer 4 5 6.
void ExpectTheReading(const std::string& heading, const std::string& line) {
  SCOPED_TRACE(heading);
  const ImuRecording imu = ReadText(heading + "\n" + line + "\n");
  ASSERT_EQ(imu.samples.size(), 1U);
  EXPECT_EQ(imu.samples[0].stamp, 1403715274 * kSecond);
  EXPECT_EQ(imu.samples[0].gyroscope, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(imu.samples[0].accelerometer, Eigen::Vector3d(4, 5, 6));
}

TEST(ReadImu, FindsTheColumnsByTheirHeading) {
  const std::string t = "1403715274000000000";
  // The file has additional columns: a magnetometer, an orientation.
  ExpectTheReading(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]",
      t + ",1,2,3,4,5,6,0.2,0.1,0.4");
  ExpectTheReading("timestamp,wx,wy,wz,ax,ay,az,qw,qx,qy,qz", t + ",1,2,3,4,5,6,1,0,0,0");
  // Acceleration comes first, and the magnetometer before both.
  ExpectTheReading("# t ax ay az gx gy gz", t + " 4 5 6 1 2 3");
  ExpectTheReading(
      "time,mag_x,mag_y,mag_z,acc_x (m/s^2),acc_y (m/s^2),acc_z (m/s^2),"
      "gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s)",
      t + ",9,9,9,4,5,6,1,2,3");
  // rostopic echo -p
  ExpectTheReading(
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,"
      "field.orientation.x,field.orientation.y,field.orientation.z,"
      "field.orientation.w,field.orientation_covariance0,field.angular_velocity.x,"
      "field.angular_velocity.y,field.angular_velocity.z,"
      "field.angular_velocity_covariance0,field.linear_acceleration.x,"
      "field.linear_acceleration.y,field.linear_acceleration.z",
      t + ",7," + t + ",imu_link,0,0,0,1,-1,1,2,3,0.1,4,5,6");
  // A phone that also logs computed quantities.
  ExpectTheReading(
      "stamp;motionUserAccelerationX(G);motionUserAccelerationY(G);"
      "motionUserAccelerationZ(G);gyroRotationX(rad/s);gyroRotationY(rad/s);"
      "gyroRotationZ(rad/s);accelerometerAccelerationX;accelerometerAccelerationY;"
      "accelerometerAccelerationZ",
      t + ";0;0;0;1;2;3;4;5;6");
  // An unnamed index column comes before the stamp.
  ExpectTheReading("\"\",\"timestamp\",\"gyroX\",\"gyroY\",\"gyroZ\",\"accX\",\"accY\",\"accZ\"",
                   "0," + t + ",1,2,3,4,5,6");
  ExpectTheReading(",timestamp,wx,wy,wz,ax,ay,az", "0," + t + ",1,2,3,4,5,6");
  // ROS stamps have two parts.
  ExpectTheReading(
      "header.stamp.secs,header.stamp.nsecs,angular_velocity.x,angular_velocity.y,"
      "angular_velocity.z,linear_acceleration.x,linear_acceleration.y,linear_acceleration.z",
      "1403715274,0,1,2,3,4,5,6");
  // A heading that names no column: the usual order applies.
  ExpectTheReading("# a comment about time", t + ",1,2,3,4,5,6");
}

TEST(ReadImu, AddsTheNanosecondsOfRosToItsSeconds) {
  const std::string heading =
      "header.stamp.sec,header.stamp.nanosec,w.x,w.y,w.z,acc.x,acc.y,acc.z\n";
  const auto samples = ReadText(heading +
                                "1403715274,5000000,1,2,3,4,5,6\n"
                                "1403715274,900000000,1,2,3,4,5,6\n")
                           .samples;
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].stamp, 1'403'715'274'005'000'000);
  EXPECT_EQ(samples[1].stamp, 1'403'715'274'900'000'000);
  EXPECT_THROW(ReadText(heading + "1403715274,1000000000,1,2,3,4,5,6\n"), IoError);
}

TEST(ReadImu, ReadsSemicolonsDecimalCommasAndUtf16) {
  ExpectTheReading("t;wx;wy;wz;ax;ay;az", "1403715274000000000;1;2;3;4;5;6");
  ExpectTheReading("t;wx;wy;wz;ax;ay;az", "1403715274,000;1,0;2,0;3;4,00;5;6,0;");
  std::string utf16 = "\xff\xfe";
  for (const char c : std::string("1403715274000000000,1,2,3,4,5,6,,\r\n,,,,,,\r\n")) {
    utf16 += {c, '\0'};
  }
  EXPECT_EQ(ReadText(utf16).samples.size(), 1U) << "empty fields at the end are none";
}

TEST(ReadImu, AnEmptyFieldIsNoNumberForTheCheckToFind) {
  const ImuRecording imu = ReadText(
      "1403715274000000000,1,,3,4,5,6\n1403715274005000000,1,2,3,4,5,\n"
      "1403715274010000000,1,2,3,4,5,6\n");
  ASSERT_EQ(imu.samples.size(), 2U + 1U);
  EXPECT_TRUE(std::isnan(imu.samples[0].gyroscope.y()));
  EXPECT_EQ(imu.samples[0].gyroscope.z(), 3.0);
  EXPECT_TRUE(std::isnan(imu.samples[1].accelerometer.z()));
  EXPECT_FALSE(std::isnan(imu.samples[2].accelerometer.z()));
}

TEST(ReadImu, ReadsSecondsBetweenBlanksAsEth3dHasThem) {
  const ImuRecording imu =
      ReadText("1403715273.262142976 1 2 3 4 5 6\n1403715273.267143\t1 2 3  4 5 6 \n");
  EXPECT_EQ(imu.warning, "");
  ASSERT_EQ(imu.samples.size(), 2U);
  EXPECT_EQ(imu.samples[0].stamp, 1403715273262142976);
  EXPECT_EQ(imu.samples[1].stamp, 1403715273267143000);
}

TEST(ReadImu, KeepsReadingsForTheCheckToJudge) {
  const ImuRecording imu = ReadText(
      "1403715273005000000,nan,2,3,4,5,6\n1403715273000000000,1,2,3,4,5,-inf\n"
      "1403715273000000000,1,2,3,4,5,6\n");
  ASSERT_EQ(imu.samples.size(), 3U);
  EXPECT_TRUE(std::isnan(imu.samples[0].gyroscope.x()));
  EXPECT_TRUE(std::isinf(imu.samples[1].accelerometer.z()));
  EXPECT_EQ(imu.samples[1].stamp, imu.samples[2].stamp);
}

// Returns two readings 5 ms apart with the given stamps, whose number of zeros gives the unit.
std::string Lines(const std::string& first, const std::string& second) {
  const std::string rest = ",1,2,3,4,5,6\n";
  return first + rest + second + rest;
}

TEST(ReadImu, ConvertsStampsInAnotherUnitAndSaysSo) {
  struct Case {
    std::string text, unit;
    VideoSpan video;
    Stamp first;
  };
  for (const Case& c :
       {Case{Lines("1403715274000000", "1403715274005000"), "in microseconds, not in nanoseconds",
             kToday, 1403715274 * kSecond},
        Case{Lines("1403715274000", "1403715274005"), "in milliseconds, not in nanoseconds", kToday,
             1403715274 * kSecond},
        Case{Lines("1403715274", "1403715275"), "in seconds, not in nanoseconds", kToday,
             1403715274 * kSecond},
        Case{Lines("1403715274000000000.0", "1403715274005000000.0"),
             "in nanoseconds, not in seconds", kToday, 1403715274 * kSecond},
        Case{Lines("1403715274000.5", "1403715274005.5"), "in milliseconds, not in seconds", kToday,
             1403715274 * kSecond + 500'000},
        // Interpreted as nanoseconds or as microseconds, they overlap the video: 200 Hz decides.
        Case{Lines("2000000", "2005000"), "in microseconds, not in nanoseconds", kFromOne,
             2 * kSecond},
        Case{Lines("2e0", "2.005e0"), "", kFromOne, 2 * kSecond}}) {
    const ImuRecording imu = ReadText(c.text, c.video);
    EXPECT_EQ(imu.samples[0].stamp, c.first) << c.text;
    if (c.unit.empty()) {
      EXPECT_EQ(imu.warning, "");
    } else {
      EXPECT_NE(imu.warning.find("imu.csv: its stamps are " + c.unit + "; converted"),
                std::string::npos)
          << imu.warning;
    }
  }
}

TEST(ReadImu, TakesNanosecondsWhereTheyMeetTheVideoWhateverElseDoes) {
  // 200 Hz in nanoseconds; in microseconds it would span hours and overlap the video too.
  const ImuRecording imu = ReadText(Lines("2000000000", "2005000000"), {0, 9000 * kSecond});
  EXPECT_EQ(imu.samples[0].stamp, 2 * kSecond);
  EXPECT_EQ(imu.warning, "");
}

TEST(ReadImu, RefusesAnotherClock) {
  EXPECT_EQ(Message(Lines("2000000000", "2005000000")),
            ": its stamps (2.000000 to 2.005000 s) do not meet those of the video "
            "(1403715273.000000 to 1403715280.000000 s): another clock; write both in one clock, "
            "or run with --imu off");
  EXPECT_NE(Message(Lines("12.000", "12.005"), kFromOne).find("(12.000000 to 12.005000 s)"),
            std::string::npos);
}

TEST(ReadImu, NamesTheLineThatIsMalformed) {
  const std::string good = "1403715274000000000,1,2,3,4,5,6\n";
  EXPECT_EQ(Message(std::string(kHeader) + good + "1403715274005000000,1,2,3,4,5\n"),
            ":3: has 6 fields; a reading is a stamp, three of the gyroscope [rad/s] and three of "
            "the accelerometer [m/s^2]");
  EXPECT_EQ(Message(good + "14o3,1,2,3,4,5,6\n"),
            ":2: '14o3' is not a time stamp; write whole nanoseconds or decimal seconds");
  EXPECT_EQ(Message(good + "1403715274005000000,1,2,3,4,5 6,7\n"),
            ":2: '5 6' is not a number; correct the line or remove it");
  EXPECT_EQ(Message(good + "1403715274005000000,1,2,3,4,5,6,7\n"),
            ":2: has 8 fields; a reading is a stamp, three of the gyroscope [rad/s] and three of "
            "the accelerometer [m/s^2]; of more a heading must name these: "
            "t,w_x,w_y,w_z,a_x,a_y,a_z");
  EXPECT_EQ(Message("t,w_x,w_y,w_z,a_x,a_y,a_z,m_x\n" + good + "1403715274005000000,1,2,3,4,5\n"),
            ":3: has 6 fields; a reading is a stamp, three of the gyroscope [rad/s] and three of "
            "the accelerometer [m/s^2]");
  EXPECT_EQ(Message(good + "timestamp,1,2,3,4,5,6\n"),
            ":2: 'timestamp' is not a time stamp; write whole nanoseconds or decimal seconds");
  EXPECT_NE(Message("99999999999999999999,1,2,3,4,5,6\n").find(":1: "), std::string::npos);
}

// For two such stamps not even the step between them can be computed.
TEST(ReadImu, RefusesStampsBeyondAnyClock) {
  for (const std::string stamp : {"9223372036854775807", "-9223372036854775807", "8e18"}) {
    EXPECT_NE(Message(stamp + ",1,2,3,4,5,6\n-9000000000000000000,1,2,3,4,5,6\n")
                  .find("is not a time stamp"),
              std::string::npos)
        << stamp;
  }
}

TEST(ReadImu, RefusesAFileWithoutReadings) {
  EXPECT_EQ(Message(kHeader), ": holds no reading; remove it to run without an IMU");
  EXPECT_THROW(ReadImu("/nowhere/imu.csv", kToday), IoError);
  EXPECT_THROW(ReadImu("/nowhere/imu.csv", {2, 1}), InvalidArgument);
}

TEST(FindImuFile, KnowsTheNamesInUse) {
  const TemporaryDirectory folder;
  EXPECT_FALSE(FindImuFile(folder.path()).has_value());
  for (const char* name : {"mav0/imu0/data.csv", "imu0/data.csv", "imu.txt", "imu.csv"}) {
    std::filesystem::create_directories((folder.path() / name).parent_path());
    WriteText(folder.path() / name, "");
    EXPECT_EQ(FindImuFile(folder.path()), folder.path() / name);
  }
}

}  // namespace
}  // namespace highwall::imu_reader_test
