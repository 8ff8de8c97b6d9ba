#include <highwall/core/stamp.h>

#include <gtest/gtest.h>

namespace highwall::stamp_test {
namespace {

TEST(Stamp, ParsesADatasetStampExactly) {
  EXPECT_EQ(ParseStamp("1305031102.175304"), Stamp{1305031102175304000});
  EXPECT_EQ(ParseStamp("1403636579.763555527"), Stamp{1403636579763555527});
}

TEST(Stamp, ParsesEverySpelling) {
  EXPECT_EQ(ParseStamp("0"), Stamp{0});
  EXPECT_EQ(ParseStamp("12"), Stamp{12000000000});
  EXPECT_EQ(ParseStamp("12."), Stamp{12000000000});
  EXPECT_EQ(ParseStamp(".5"), Stamp{500000000});
  EXPECT_EQ(ParseStamp("-0.25"), Stamp{-250000000});
  EXPECT_EQ(ParseStamp("+1.5"), Stamp{1500000000});
  EXPECT_EQ(ParseStamp("0.1234567899"), Stamp{123456789});  // truncated, not rounded
  EXPECT_EQ(ParseStamp("1.5e3"), Stamp{1500000000000});
  EXPECT_EQ(ParseStamp("+1.5e3"), Stamp{1500000000000});
  EXPECT_EQ(ParseStamp("-2E-1"), Stamp{-200000000});
}

TEST(Stamp, TwoSpellingsOfOneTimeAreEqual) {
  EXPECT_EQ(ParseStamp("1305031102.1753"), ParseStamp("1305031102.175300000"));
}

TEST(Stamp, RefusesTextThatIsNoNumber) {
  for (const char* text :
       {"",      ".",   "-",     "+",   "e",     "1e",   "abc",
        "1.2.3", "1 2", " 1",    "1 ",  "0x10",  "nan",  "inf",
        "1,5",   "--1", "+-1e3", "+-1", "1e400", "1e12", "99999999999999999999"}) {
    EXPECT_FALSE(ParseStamp(text).has_value()) << '"' << text << '"';
  }
}

TEST(Stamp, TheDifferenceOfAnyTwoIsAStamp) {
  for (const char* text : {"4700000000", "-4700000000", "9e9", "-9e9"}) {
    EXPECT_FALSE(ParseStamp(text).has_value()) << text;
  }
  Stamp difference = 0;
  EXPECT_FALSE(__builtin_sub_overflow(ParseStamp("4600000000").value(),
                                      ParseStamp("-4600000000").value(), &difference));
}

TEST(Stamp, FormatsWithSixToNineDecimals) {
  EXPECT_EQ(FormatStamp(1305031102175304000), "1305031102.175304");
  EXPECT_EQ(FormatStamp(1403636579763555527), "1403636579.763555527");
  EXPECT_EQ(FormatStamp(0), "0.000000");
  EXPECT_EQ(FormatStamp(-250000000), "-0.250000");
  EXPECT_EQ(FormatStamp(1), "0.000000001");
}

TEST(Stamp, SurvivesConversionToText) {
  for (const Stamp stamp : {Stamp{0}, Stamp{1}, Stamp{-1}, Stamp{999999999}, Stamp{-1000000001},
                            Stamp{1305031102175304001}}) {
    EXPECT_EQ(ParseStamp(FormatStamp(stamp)), stamp);
  }
}

TEST(Stamp, SecondsOfADurationAndBack) {
  EXPECT_DOUBLE_EQ(ToSeconds(1500000000), 1.5);
  EXPECT_EQ(FromSeconds(1.5), Stamp{1500000000});
  EXPECT_EQ(FromSeconds(-0.1), Stamp{-100000000});
}

}  // namespace
}  // namespace highwall::stamp_test
