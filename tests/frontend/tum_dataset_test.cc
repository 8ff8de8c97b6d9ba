#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/image_io.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "support/generated_tum.h"
#include "support/message_of.h"
#include "support/test_paths.h"

namespace highwall::tum_dataset_test {
namespace {

using testing::GeneratedTum;
using testing::MessageOf;
using testing::TemporaryDirectory;
using testing::Truncate;
using testing::WriteText;
using testing::WriteTum;

void ExpectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text << "\nlacks: " << part;
}

std::string OpenMessage(const std::filesystem::path& directory) {
  const std::string message = MessageOf<IoError>([&] { const TumDataset dataset(directory); });
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

std::vector<TumImageFile> List(const std::vector<Stamp>& stamps) {
  std::vector<TumImageFile> list;
  for (const Stamp stamp : stamps) list.push_back({stamp, {}});
  return list;
}

TEST(TumDataset, LoadsColourAndMetricDepth) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.raw_depth = 10400});
  const TumDataset dataset(folder.path(), RgbdSensor{.depth_factor = 5200.0}, {.any_size = true});
  ASSERT_EQ(dataset.size(), 6U);
  EXPECT_EQ(dataset.stamp(3), 100'300'000'000);
  const std::optional<RgbdImage> image = dataset.Load(3);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->stamp, dataset.stamp(3));
  ASSERT_EQ(image->bgr.type(), CV_8UC3);
  EXPECT_EQ(image->bgr.at<cv::Vec3b>(5, 6), cv::Vec3b(3, 2, 3));
  ASSERT_EQ(image->depth.type(), CV_32FC1);
  EXPECT_FLOAT_EQ(image->depth.at<float>(5, 6), 2.0F);
  EXPECT_EQ(image->depth.at<float>(5, 0), 0.0F);
  EXPECT_NEAR(dataset.median_depth(), 2.0, 1e-6);  // the precision of a float
  EXPECT_TRUE(dataset.problems().empty());
  EXPECT_TRUE(dataset.warnings().empty());
  EXPECT_EQ(dataset.groundtruth(), nullptr);
}

TEST(TumDataset, RegistersDepthOfItsOwnCamera) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());  // 64 x 48
  for (int i = 0; i < 6; ++i) {
    cv::imwrite((folder.path() / "depth" / (testing::FrameName(i) + ".png")).string(),
                cv::Mat(24, 32, CV_16UC1, cv::Scalar(2000)));
  }
  RgbdSensor sensor{.depth_factor = 1000.0};
  sensor.camera = {.width = 64, .height = 48, .fx = 60, .fy = 60, .cx = 31.5, .cy = 23.5};
  sensor.depth_camera = DepthCameraCalibration{
      .camera = {.width = 32, .height = 24, .fx = 20, .fy = 20, .cx = 15.5, .cy = 11.5}};
  sensor.depth_camera->T_CD = Pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, 0.1));
  const TumDataset dataset(folder.path(), sensor);
  EXPECT_TRUE(dataset.is_registered());
  const std::optional<RgbdImage> image = dataset.Load(3);
  ASSERT_TRUE(image);
  ASSERT_EQ(image->depth.size(), cv::Size(64, 48));
  EXPECT_FLOAT_EQ(image->depth.at<float>(20, 30), 2.1F);  // 2 m in front of it, which is 0.1 m ahead

  sensor.depth_camera->camera.width = 33;
  ExpectContains(MessageOf<IoError>([&] { const TumDataset other(folder.path(), sensor); }),
                 "depth/100.png: is 32 x 24, but the depth camera is set to 33 x 24");
}

TEST(TumDataset, RefusesAnIndexBeyondTheEnd) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  EXPECT_THROW(TumDataset(folder.path()).Load(6), InvalidArgument);
}

TEST(TumDataset, ReadsTheGroundTruthWhereThereIsOne) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  WriteText(folder.path() / "groundtruth.txt", "# t\n100.0 1 2 3 0 0 0 1\n100.1 4 5 6 0 0 0 1\n");
  const TumDataset dataset(folder.path());
  ASSERT_NE(dataset.groundtruth(), nullptr);
  ASSERT_EQ(dataset.groundtruth()->size(), 2U);
  EXPECT_EQ(dataset.groundtruth()->at(1).pose.p(), Eigen::Vector3d(4, 5, 6));
}

TEST(TumDataset, WarnsOnceOfAGroundTruthThatCannotBeReadAndGoesWithoutIt) {
  const std::string good = "100.0 1 2 3 0 0 0 1\n";
  for (const std::string bad : {"100.1 nan 5 6 0 0 0 1\n", "100.1,4,5,6,0,0,0,1\n",
                                "99.9 4 5 6 0 0 0 1\n", "time x y z\n", "100.1 4 5 6 0 0 0 0\n"}) {
    SCOPED_TRACE(bad);
    const TemporaryDirectory folder;
    WriteTum(folder.path());
    WriteText(folder.path() / "groundtruth.txt", good + bad);
    const TumDataset dataset(folder.path());
    EXPECT_EQ(dataset.size(), 6U);
    EXPECT_EQ(dataset.groundtruth(), nullptr);
    ASSERT_EQ(dataset.warnings().size(), 1U);
    ExpectContains(dataset.warnings()[0], "groundtruth.txt:2: ");
    ExpectContains(dataset.warnings()[0], "; the ground truth is not used");
  }
}

TEST(TumDataset, WarnsOfAGroundTruthThatIsAFolder) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  std::filesystem::create_directory(folder.path() / "groundtruth.txt");
  const TumDataset dataset(folder.path());
  EXPECT_EQ(dataset.groundtruth(), nullptr);
  EXPECT_EQ(dataset.warnings().size(), 1U);
}

TEST(TumDataset, WarnsOfAnEmptyGroundTruth) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  WriteText(folder.path() / "groundtruth.txt", "# nothing\n");
  const TumDataset dataset(folder.path());
  EXPECT_EQ(dataset.groundtruth(), nullptr);
  ASSERT_EQ(dataset.warnings().size(), 1U);
  ExpectContains(dataset.warnings()[0], "groundtruth.txt: holds no pose");
}

TEST(TumDataset, NamesAMissingOrEmptyDirectory) {
  const TemporaryDirectory folder;
  const auto nowhere = folder.path() / "nowhere";
  EXPECT_EQ(OpenMessage(nowhere), nowhere.string() + ": does not exist");
  EXPECT_EQ(OpenMessage(folder.path()), folder.path().string() + ": is empty");
  WriteText(folder.path() / "file", "x");
  ExpectContains(OpenMessage(folder.path() / "file"), "file: is not a directory");
}

TEST(TumDataset, NamesAMissingList) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  std::filesystem::remove(folder.path() / "rgb.txt");
  ExpectContains(OpenMessage(folder.path()), "rgb.txt: is missing");
}

// Makes the depth stamps of WriteTum() 5 ms later than those of colour.
void ShiftDepth(const std::filesystem::path& folder, double seconds, int frames = 6) {
  std::string list;
  for (int i = 0; i < frames; ++i) {
    list += FormatStamp(FromSeconds(100.0 + 0.1 * i + seconds)) + " depth/" +
            testing::FrameName(i) + ".png\n";
  }
  WriteText(folder / "depth.txt", list);
}

TEST(TumDataset, SaysByHowMuchDepthIsLateAndWhatHelps) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  for (const auto& [seconds, advice] :
       {std::pair{0.025, "0.025 s later in the median; give --max-pair-difference 0.03"},
        {-0.031, "0.031 s earlier in the median; give --max-pair-difference 0.035"},
        {800.0, "800 s later in the median; write both lists in one clock"}}) {
    ShiftDepth(folder.path(), seconds);
    const std::string message = OpenMessage(folder.path());
    ExpectContains(message, "no stamp of rgb.txt has one of depth.txt within 0.02 s: depth is ");
    ExpectContains(message, advice);
  }
  ShiftDepth(folder.path(), 800.0, 1);
  ExpectContains(OpenMessage(folder.path()), "later in the median; write both lists in one clock");
  ShiftDepth(folder.path(), 0.025);
  const TumDataset dataset(folder.path(), std::nullopt, {.max_stamp_difference = 0.03});
  EXPECT_EQ(dataset.size(), 6U);
  EXPECT_TRUE(dataset.warnings().empty());
  EXPECT_EQ(dataset.Load(0)->depth_stamp, dataset.stamp(0) + 25'000'000);
}

TEST(TumDataset, WarnsWhereSomeColourImagesHaveNoDepthInTime) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  WriteText(folder.path() / "depth.txt",
            "100.005 depth/100.png\n100.105 depth/101.png\n100.23 depth/102.png\n"
            "100.33 depth/103.png\n100.43 depth/104.png\n100.53 depth/105.png\n");
  const TumDataset late(folder.path());
  EXPECT_EQ(late.size(), 2U);
  ASSERT_EQ(late.warnings().size(), 1U);
  ExpectContains(late.warnings()[0],
                 "4 of 6 colour images have no depth image within 0.02 s: depth is 0.03 s later "
                 "in the median; give --max-pair-difference 0.035");
  EXPECT_EQ(late.stamps_without_depth(), (std::vector<Stamp>{100'200'000'000, 100'300'000'000,
                                                             100'400'000'000, 100'500'000'000}));
  // If depth images are missing, no limit helps.
  WriteText(folder.path() / "depth.txt", "100.005 depth/100.png\n100.105 depth/101.png\n");
  const TumDataset few(folder.path());
  ASSERT_EQ(few.warnings().size(), 1U);
  EXPECT_TRUE(few.warnings()[0].ends_with("4 of 6 colour images have no depth image within 0.02 s"))
      << few.warnings()[0];
}

TEST(TumDataset, ReadsAssociationsWhereTheListsAreNotThere) {
  for (const bool depth_first : {false, true}) {
    for (const char* name : {"associations.txt", "assoc.txt"}) {
      const TemporaryDirectory folder;
      WriteTum(folder.path());
      std::filesystem::remove(folder.path() / "rgb.txt");
      std::string list = "# both\n";
      for (int i = 0; i < 5; ++i) {
        const std::string n = std::to_string(i), file = "/" + testing::FrameName(i) + ".png";
        const std::string colour = "100." + n + "0 rgb" + file,
                          depth = "100." + n + "1 depth" + file;
        list += depth_first ? depth + " " + colour + "\n" : colour + " " + depth + "\n";
      }
      WriteText(folder.path() / name, list);
      const TumDataset dataset(folder.path());
      ASSERT_EQ(dataset.size(), 5U);
      EXPECT_TRUE(dataset.warnings().empty());
      EXPECT_EQ(dataset.stamp(4), 100'400'000'000);
      const auto image = dataset.Load(4);
      ASSERT_TRUE(image);
      EXPECT_EQ(image->bgr.at<cv::Vec3b>(5, 6), cv::Vec3b(4, 2, 3));
      EXPECT_EQ(image->depth_stamp, 100'410'000'000);
    }
  }
}

TEST(TumDataset, SkipsAndCountsFramesItCannotUse) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.frames = 8});
  const auto depth = folder.path() / "depth", rgb = folder.path() / "rgb";
  Truncate(rgb / "100.png");
  Truncate(depth / "101.png");
  std::filesystem::remove(rgb / "102.png");
  WriteText(depth / "103.png", "this is no image");
  WriteText(depth / "104.png", "");
  cv::imwrite((depth / "105.png").string(), cv::Mat(24, 32, CV_16UC1, cv::Scalar(5000)));
  cv::imwrite((depth / "106.png").string(), cv::Mat(48, 64, CV_16UC1, cv::Scalar(0)));

  const TumDataset dataset(folder.path());
  ASSERT_EQ(dataset.size(), 8U);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_FALSE(dataset.Load(i)) << i;
  EXPECT_TRUE(dataset.Load(7));
  dataset.Load(0);  // a second failure is not counted again
  const std::vector<Dataset::Problem> problems = dataset.problems();
  ASSERT_EQ(problems.size(), 7U);
  const std::vector<std::string> expected = {
      "rgb/100.png: is truncated",    "depth/101.png: is truncated",
      "rgb/102.png: cannot be read",  "depth/103.png: is not an image",
      "depth/104.png: is empty",      "depth/105.png: is 32 x 24, but its colour image is 64 x 48",
      "depth/106.png: holds no depth"};
  for (std::size_t i = 0; i < 7; ++i) {
    EXPECT_EQ(problems[i].frame, i);
    ExpectContains(problems[i].what, expected[i]);
  }
}

TEST(TumDataset, RefusesADatasetWithoutAnyUsableFrame) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.raw_depth = 0});
  const std::string message = OpenMessage(folder.path());
  ExpectContains(message, "none of its 6 frames can be used");
  ExpectContains(message, "depth/100.png: holds no depth");
}

TEST(TumDataset, RefusesImagesOfAnotherSizeThanTheCamera) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  const RgbdSensor sensor;
  ExpectContains(MessageOf<IoError>([&] { const TumDataset dataset(folder.path(), sensor); }),
                 "is 64 x 48, but the camera is set to 640 x 480");
}

TEST(TumDataset, WarnsOfAWrongDepthFactorAndNamesTheLikelyOne) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.raw_depth = 2000});
  const TumDataset dataset(folder.path(), RgbdSensor{.depth_factor = 50000.0}, {.any_size = true});
  ASSERT_EQ(dataset.warnings().size(), 1U);
  ExpectContains(dataset.warnings()[0], "the median depth is 0.04 m with depth factor 5e+04");
  ExpectContains(dataset.warnings()[0], "the factor is likely 1000");
}

TEST(TumDataset, TakesTheOffsetOffTheInverseOfDepth) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.raw_depth = 10200});
  const auto depth = [&](double offset) {
    const TumDataset dataset(folder.path(), RgbdSensor{.inverse_depth_offset = offset},
                             {.any_size = true});
    double most = 0.0;
    cv::minMaxLoc(dataset.Load(0)->depth, nullptr, &most);
    return most;
  };
  EXPECT_NEAR(depth(0.0), 2.04, 1e-6);
  EXPECT_NEAR(depth(1.0 / 2.04 - 1.0 / 2.0), 2.0, 1e-6);  // it reads 2 % too long
}

TEST(MetricDepth, IsZeroWithoutAReadingOrBeyondInfinity) {
  const cv::Mat stored = (cv::Mat_<std::uint16_t>(1, 4) << 0, 1000, 9990, 10010);
  const cv::Mat depth = MetricDepth(stored, 1000.0, 0.1);
  ASSERT_EQ(depth.type(), CV_32FC1);
  EXPECT_EQ(depth.at<float>(0), 0.0F);
  EXPECT_NEAR(depth.at<float>(1), 1.0 / 0.9, 1e-6);
  EXPECT_NEAR(depth.at<float>(2), 9.99 / 0.001, 1.0);  // a float's eighth digit of 0.001
  EXPECT_EQ(depth.at<float>(3), 0.0F);
  // The values are already metres.
  const cv::Mat metres = (cv::Mat_<float>(1, 2) << 2.0F, 0.0F);
  EXPECT_NEAR(MetricDepth(metres, 1.0, -0.01).at<float>(0), 2.0 / 1.02, 1e-6);
  EXPECT_EQ(MetricDepth(metres, 1.0, -0.01).at<float>(1), 0.0F);
  EXPECT_THROW(MetricDepth(cv::Mat(2, 2, CV_8UC1), 1000.0), InvalidArgument);
  EXPECT_THROW(MetricDepth(stored, 0.0), InvalidArgument);
  EXPECT_THROW(MetricDepth(stored, 1000.0, std::nan("")), InvalidArgument);
}

TEST(MetricDepth, TakesAPatternOffWhereItIs) {
  const cv::Mat stored(481, 641, CV_16UC1, cv::Scalar(2000));
  DepthPattern pattern;
  pattern.nodes[DepthPattern::kNodes - 1] = -0.01;  // the last row's right end reads too long
  const cv::Mat depth = MetricDepth(stored, 1000.0, 0.002, pattern);
  EXPECT_NEAR(depth.at<float>(0, 0), 1.0 / (0.5 - 0.002), 1e-6);
  EXPECT_NEAR(depth.at<float>(480, 640), 1.0 / (0.5 - 0.002 + 0.01), 1e-6);
  EXPECT_NEAR(depth.at<float>(400, 560), 1.0 / (0.5 - 0.002 + 0.0025), 1e-6);  // half and half
  pattern.nodes[0] = std::nan("");
  EXPECT_THROW(MetricDepth(stored, 1000.0, 0.0, pattern), InvalidArgument);
}

TEST(TumDataset, TakesThePatternOffTheInverseOfDepth) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.raw_depth = 10000});
  DepthPattern pattern;
  pattern.nodes.setConstant(0.5 - 0.4);
  const TumDataset dataset(folder.path(), RgbdSensor{.depth_pattern = pattern}, {.any_size = true});
  double most = 0.0;
  cv::minMaxLoc(dataset.Load(0)->depth, nullptr, &most);
  EXPECT_NEAR(most, 2.5, 1e-6);
}

TEST(TumDataset, NamesTheBadOption) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  const auto message = [&](const RgbdSensor& sensor, const DatasetOptions& options) {
    return MessageOf<InvalidArgument>([&] { TumDataset(folder.path(), sensor, options); });
  };
  const DatasetOptions any{.any_size = true};
  ExpectContains(message({.depth_factor = 0.0}, any), "RgbdSensor::depth_factor");
  ExpectContains(message({.inverse_depth_offset = 1.0}, any), "RgbdSensor::inverse_depth_offset");
  ExpectContains(message({.camera = {.width = 0}}, any), "PinholeCamera::width");
  ExpectContains(message({}, {.max_stamp_difference = -1.0}),
                 "DatasetOptions::max_stamp_difference");
}

TEST(LikelyDepthFactor, IsEmptyForPlausibleDepths) {
  EXPECT_FALSE(LikelyDepthFactor(0.1, 5000.0));
  EXPECT_FALSE(LikelyDepthFactor(20.0, 5000.0));
}

TEST(LikelyDepthFactor, ChoosesTheFactorThatBringsTheMedianNearTwoMetres) {
  EXPECT_EQ(LikelyDepthFactor(2000.0, 1.0), 1000.0);   // millimetres taken for metres
  EXPECT_EQ(LikelyDepthFactor(10000.0, 1.0), 5000.0);  // TUM taken for metres
  EXPECT_EQ(LikelyDepthFactor(0.05, 100000.0), 5000.0);
  EXPECT_EQ(LikelyDepthFactor(1e-4, 1000.0), 0.0);  // nothing helps
}

TEST(TumImageList, AllowsCommentsBlankLinesTabsAndCarriageReturns) {
  const TemporaryDirectory folder;
  const auto list = folder.path() / "rgb.txt";
  WriteText(list,
            "# head\r\n\r\n1.5 rgb/a.png\r\n  \t\n 2.5\trgb/b.png extra\n#3 x\n3.5 /abs/c.png");
  const std::vector<TumImageFile> files = ReadTumImageList(list);
  ASSERT_EQ(files.size(), 3U);
  EXPECT_EQ(files[0].stamp, 1'500'000'000);
  EXPECT_EQ(files[0].path, folder.path() / "rgb/a.png");
  EXPECT_EQ(files[1].path, folder.path() / "rgb/b.png");
  EXPECT_EQ(files[2].path, "/abs/c.png");
}

TEST(TumImageList, NamesTheLineThatIsMalformed) {
  const TemporaryDirectory folder;
  const auto list = folder.path() / "rgb.txt";
  const auto message = [&](const std::string& text) {
    WriteText(list, text);
    return MessageOf<IoError>([&] { ReadTumImageList(list); });
  };
  ExpectContains(message("# c\n1.0 a\nabc b\n"), "rgb.txt:3: 'abc' is not a time stamp");
  ExpectContains(message("1.0 a\nnan b\n"), "rgb.txt:2: 'nan' is not a time stamp");
  ExpectContains(message("1.0\n"), "rgb.txt:1: a file name is missing");
  ExpectContains(message("# only a comment\n"), "rgb.txt: lists no image");
}

TEST(AssociateNearest, PairsTheClosestFirstAndUsesEachOnce) {
  // b[0] is within reach of both a[0] (15) and a[1] (3): it is assigned to a[1], and a[0] stays
  // unpaired.
  const auto pairs = AssociateNearest(List({0, 18, 100}), List({15, 104, 119}), 20);
  EXPECT_EQ(pairs, (std::vector<std::pair<std::size_t, std::size_t>>{{1, 0}, {2, 1}}));
}

TEST(AssociateNearest, KeepsThePairAtTheLimitAndDropsTheOneBeyond) {
  EXPECT_EQ(AssociateNearest(List({0}), List({20}), 20).size(), 1U);
  EXPECT_EQ(AssociateNearest(List({0}), List({-20}), 20).size(), 1U);
  EXPECT_TRUE(AssociateNearest(List({0}), List({21}), 20).empty());
}

TEST(ImageIo, DetectsAJpegThatWasCutShort) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "a.jpg";
  cv::Mat image(48, 64, CV_8UC3);
  cv::theRNG().state = 7;
  cv::randu(image, 0, 255);
  cv::imwrite(path.string(), image);
  EXPECT_EQ(ReadColourImage(path).size(), image.size());
  std::ofstream(path, std::ios::app) << std::string(8, '\0');  // padding of some cameras
  EXPECT_EQ(ReadColourImage(path).size(), image.size());
  for (const double share : {0.97, 0.5, 0.1}) {
    Truncate(path, share);
    ExpectContains(MessageOf<IoError>([&] { ReadColourImage(path); }), "a.jpg: is truncated");
  }
}

TEST(ImageIo, DetectsAPngCutShortAnywhere) {
  const TemporaryDirectory folder;
  const auto whole = folder.path() / "whole.png", cut = folder.path() / "cut.png";
  cv::Mat image(48, 64, CV_16UC1);
  cv::theRNG().state = 7;
  cv::randu(image, 0, 65535);
  cv::imwrite(whole.string(), image);
  EXPECT_EQ(cv::countNonZero(ReadDepthImage(whole) != image), 0);
  const std::uintmax_t size = std::filesystem::file_size(whole);
  for (std::uintmax_t left = 8; left < size; left += 97) {
    std::filesystem::copy_file(whole, cut, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(cut, left);
    ExpectContains(MessageOf<IoError>([&] { ReadDepthImage(cut); }), "cut.png: is truncated");
  }
}

TEST(ImageIo, DetectsADamagedPngAndWritesNothing) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "d.png";
  cv::Mat image(48, 64, CV_16UC1);
  cv::theRNG().state = 7;
  cv::randu(image, 0, 65535);
  cv::imwrite(path.string(), image);
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(path) / 2));
  file.write("damage", 6);
  file.close();
  ::testing::internal::CaptureStderr();
  const std::string message = MessageOf<IoError>([&] { ReadDepthImage(path); });
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  ExpectContains(message, "d.png: is damaged");
}

TEST(ImageIo, RefusesADepthImageOfEightBits) {
  const TemporaryDirectory folder;
  const auto path = folder.path() / "d.png";
  cv::imwrite(path.string(), cv::Mat(4, 4, CV_8UC3, cv::Scalar(1, 2, 3)));
  ExpectContains(MessageOf<IoError>([&] { ReadDepthImage(path); }), "found 3 of 8 bits");
}

TEST(TumDataset, ReadsARealSequence) {
  const std::filesystem::path folder = std::filesystem::path(testing::kSharedData) / "tum/fr1_xyz";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << ": no shared/data here";
  const TumDataset dataset(folder);
  EXPECT_EQ(dataset.colour_files().size(), 798U);
  EXPECT_EQ(dataset.size(), 792U);
  ASSERT_NE(dataset.groundtruth(), nullptr);
  EXPECT_EQ(dataset.groundtruth()->size(), 3000U);
  EXPECT_TRUE(dataset.warnings().empty());
}

TEST(TumDataset, KeepsFramesWithoutDepthWhereAnImuCanBridgeThem) {
  const TemporaryDirectory folder;
  WriteTum(folder.path());
  cv::imwrite((folder.path() / "depth/102.png").string(), cv::Mat::zeros(48, 64, CV_16UC1));
  EXPECT_FALSE(TumDataset(folder.path()).Load(2).has_value());
  EXPECT_FALSE(TumDataset(folder.path()).imu_file().has_value());
  WriteText(folder.path() / "imu.csv", "");
  const TumDataset dataset(folder.path());
  EXPECT_EQ(dataset.imu_file(), folder.path() / "imu.csv");
  const auto image = dataset.Load(2);
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(cv::countNonZero(image->depth), 0);
}

TEST(TumDataset, RefusesFramesWithoutAnyDepthEvenWithAnImu) {
  const TemporaryDirectory folder;
  WriteTum(folder.path(), {.raw_depth = 0});
  WriteText(folder.path() / "imu.csv", "");
  try {
    TumDataset dataset(folder.path());
    ADD_FAILURE() << "accepted";
  } catch (const IoError& error) {
    EXPECT_NE(std::string(error.what()).find("no depth image holds any depth"), std::string::npos);
  }
}

}  // namespace
}  // namespace highwall::tum_dataset_test
