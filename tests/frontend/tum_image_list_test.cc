#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/frontend/input/tum_dataset.h>

#include "support/message_of.h"
#include "support/temporary_directory.h"

namespace highwall::tum_image_list_test {
namespace {

struct ReadList {
  std::vector<TumImageFile> files;
  std::vector<std::string> warnings;
};

// An image list with a given text, in a temporary folder.
class ImageList : public ::testing::Test {
 protected:
  std::filesystem::path list() const { return folder_.path() / "rgb.txt"; }
  ReadList Read(const std::string& text) const {
    testing::WriteText(list(), text);
    ReadList read;
    read.files = ReadTumImageList(list(), &read.warnings);
    return read;
  }
  std::string Message(const std::string& text) const {
    return testing::MessageOf<IoError>([&] { Read(text); });
  }
  void ExpectTheTwo(const ReadList& read, std::size_t warnings = 0) const {
    ASSERT_EQ(read.files.size(), 2U);
    EXPECT_EQ(read.files[0].stamp, 1'500'000'000);
    EXPECT_EQ(read.files[0].path, folder_.path() / "rgb/a.png");
    EXPECT_EQ(read.files[1].stamp, 1'533'000'000);
    EXPECT_EQ(read.files[1].path, folder_.path() / "rgb/b.png");
    EXPECT_EQ(read.warnings.size(), warnings);
  }

  const testing::TemporaryDirectory folder_;
};

constexpr const char* kTwo = "# stamp file\n1.5 rgb/a.png\n1.533 rgb/b.png\n";

std::string Utf16(const std::string& text, bool big_endian) {
  std::string bytes;
  for (const char c : text) bytes += big_endian ? std::string{'\0', c} : std::string{c, '\0'};
  return bytes;
}

TEST_F(ImageList, ReadsWhatEditorsOfWindowsAndMacWrite) {
  using std::string_literals::operator""s;
  ExpectTheTwo(Read(kTwo));
  ExpectTheTwo(Read("\xef\xbb\xbf"s + kTwo));
  ExpectTheTwo(
      Read("\xef\xbb\xbf"
           "1.5 rgb/a.png\r\n1.533 rgb/b.png"));
  ExpectTheTwo(Read("\xff\xfe"s + Utf16(kTwo, false)));
  ExpectTheTwo(Read("\xfe\xff"s + Utf16(kTwo, true)));
  ExpectTheTwo(Read(Utf16(kTwo, false)));
  ExpectTheTwo(Read(Utf16(kTwo, true)));
  ExpectTheTwo(Read("1.5 rgb/a.png\r1.533 rgb/b.png\r"));
  ExpectTheTwo(Read("1.5 rgb\\a.png\r\n1.533 rgb\\b.png\r\n"));
  ExpectTheTwo(Read("1.5,rgb/a.png\n1.533, rgb/b.png\n"));
  ExpectTheTwo(Read("1.5;rgb/a.png\n1.533;rgb/b.png\n"));
}

TEST_F(ImageList, KeepsNamesThatHoldLettersOfAllTheWorldACommaOrABackSlash) {
  const std::string name = "\xc3\xa4\xe2\x82\xac\xf0\x9f\x8f\x94.png";  // of 2, 3 and 4 bytes
  const std::string utf16 = std::string("1\0 \0\xe4\0\xac\x20\x3c\xd8\xd4\xdf.\0p\0n\0g\0", 20);
  EXPECT_EQ(Read("\xff\xfe" + utf16).files.at(0).path, folder_.path() / name);
  EXPECT_EQ(Read("1 a,b;c.png\n").files.at(0).path, folder_.path() / "a,b;c.png");
  testing::WriteText(folder_.path() / "a\\b.png", "");
  EXPECT_EQ(Read("1 a\\b.png\n").files.at(0).path, folder_.path() / "a\\b.png");
}

TEST_F(ImageList, ConvertsWholeNumbersInAnotherUnitAndSaysSo) {
  struct Case {
    std::string first, second, unit;
    Stamp stamp;
  };
  for (const Case& c :
       {Case{"1403636579763555584", "1403636579813555584", "nanoseconds", 1403636579763555584},
        Case{"1403636579763555", "1403636579813555", "microseconds", 1403636579763555000},
        Case{"1403636579763", "1403636579813", "milliseconds", 1403636579763000000},
        Case{"0", "33333333", "nanoseconds", 0}, Case{"7", "40", "milliseconds", 7'000'000},
        Case{"500000", "533333", "microseconds", 500'000'000}}) {
    const ReadList read = Read(c.first + " a\n" + c.second + " b\n");
    EXPECT_EQ(read.files.at(0).stamp, c.stamp) << c.first;
    ASSERT_EQ(read.warnings.size(), 1U) << c.first;
    EXPECT_EQ(read.warnings[0],
              list().string() + ": its stamps are in " + c.unit + ", not in seconds; converted");
  }
  EXPECT_EQ(Read("1403636579763555584 a\n").files.at(0).stamp, 1403636579763555584);
}

TEST_F(ImageList, ReadsDecimalCommasAndAHeadingWithoutItsSign) {
  ExpectTheTwo(Read("1,5 rgb/a.png\n1,533 rgb/b.png\n"));
  ExpectTheTwo(Read("1,5;rgb/a.png\n1,533;rgb/b.png\n"));
  ExpectTheTwo(Read("timestamp,filename\n1.5,rgb/a.png\n1.533,rgb/b.png\n"));
  EXPECT_NE(Message("nonsense\n").find("rgb.txt:1: 'nonsense' is not"), std::string::npos);
  EXPECT_NE(Message("time rgb/a.png\n1.5 rgb/b.png\n").find("rgb.txt:1: 'time' is not"),
            std::string::npos);
}

TEST_F(ImageList, LeavesSecondsAsTheyAre) {
  for (const std::string text : {"1 a\n2 b\n", "1305031102 a\n1305031103 b\n", "1305031102 a\n",
                                 "100.5 a\n900.5 b\n", "0 a\n"}) {
    EXPECT_TRUE(Read(text).warnings.empty()) << text;
  }
  EXPECT_EQ(Read("1305031102 a\n1305031103 b\n").files.at(1).stamp, 1305031103000000000);
}

TEST_F(ImageList, SortsAnExchangedLineAndNamesIt) {
  const ReadList read = Read("1.0 a\n1.2 c\n1.1 b\n1.3 d\n");
  ASSERT_EQ(read.files.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(read.files[i].path.filename(), std::string(1, static_cast<char>('a' + i)));
  }
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0],
            list().string() + ":3: stamp 1.1 is smaller than the one before; the list is sorted");
}

TEST_F(ImageList, LeavesOutADoubledLineAndNamesIt) {
  const ReadList read = Read("1.0 a\n1.1 b\n1.1 c\n1.2 d\n");
  ASSERT_EQ(read.files.size(), 3U);
  EXPECT_EQ(read.files[1].path.filename(), "b");
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_EQ(read.warnings[0],
            list().string() + ":3: stamp 1.1 is there twice; the first line stays");
}

TEST_F(ImageList, RefusesStampsTooCoarseToDistinguishImages) {
  std::string text;
  for (int i = 0; i < 40; ++i) text += std::to_string(1305031102 + i / 30) + " a.png\n";
  EXPECT_EQ(Message(text),
            list().string() +
                ":2: stamp 1305031102 is there twice, one of 38 such lines: give each "
                "image a stamp of its own, with enough decimals");
}

TEST_F(ImageList, NamesTheLineWithoutAStamp) {
  EXPECT_EQ(Message("9300000000000000000000 a\n"),
            list().string() + ":1: '9300000000000000000000' is not a time stamp in seconds");
  EXPECT_EQ(Message("1403636579.7.6 a\n"),
            list().string() + ":1: '1403636579.7.6' is not a time stamp in seconds");
}

}  // namespace
}  // namespace highwall::tum_image_list_test
