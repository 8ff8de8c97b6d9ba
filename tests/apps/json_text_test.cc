#include "files/json_text.h"

#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace highwall::apps::json_text_test {
namespace {

using nlohmann::json;

TEST(JsonText, KeepsValidUtf8) {
  for (const std::string text : {"", "room", "B\xC3\xBCro", "\xE5\xB7\xA5\xE5\x9C\xB0",
                                 "\xF0\x9F\x9A\x9C", "\xEF\xBF\xBD", "\x7F"}) {
    EXPECT_EQ(ToUtf8(text), text);
    EXPECT_EQ(FromUtf8(text), text);
  }
}

TEST(JsonText, MapsEachByteThatIsNotUtf8ToACharacter) {
  EXPECT_EQ(ToUtf8("B\xFCro"), "B\xEE\xBF\xBCro");            // U+EFFC
  EXPECT_EQ(ToUtf8("\x80"), "\xEE\xBE\x80");                  // U+EF80
  EXPECT_EQ(ToUtf8("\xC3"), "\xEE\xBF\x83");                  // truncated
  EXPECT_EQ(ToUtf8("\xC0\xAF"), "\xEE\xBF\x80\xEE\xBE\xAF");  // overlong
  EXPECT_EQ(ToUtf8("\xED\xA0\x80").size(), 9U);               // a surrogate
  EXPECT_EQ(ToUtf8("\xF4\x90\x80\x80").size(), 12U);          // beyond Unicode
  EXPECT_EQ(ToUtf8("\xEE\xBE\x80"), ToUtf8("\xEE") + ToUtf8("\xBE") + ToUtf8("\x80"));
}

TEST(JsonText, EveryTextIsReadAsItWasWritten) {
  std::mt19937 rng(1);
  // Bytes that begin and continue characters, and those of the escapes, are drawn frequently.
  const std::string frequent = "a/\xC3\xBC\xE2\x82\xAC\xEE\xBE\xBF\x80\xED\xA0\xF0\x9F\xF4\x90\xFF";
  for (int i = 0; i < 20000; ++i) {
    std::string text;
    for (int length = static_cast<int>(rng() % 12); length > 0; --length) {
      const bool any = rng() % 4 == 0;
      text += any ? static_cast<char>(1 + rng() % 255) : frequent[rng() % frequent.size()];
    }
    const std::string written = JsonText(json{{"path", text}, {text, 1}});
    const json read = json::parse(written);
    ASSERT_EQ(StringIn(read["path"]), text) << written;
    ASSERT_TRUE(read.contains(ToUtf8(text)));
  }
}

TEST(JsonText, AllElseIsWrittenAsEver) {
  const json value = {{"a", {1, 2.5, nullptr, true, "\n"}},
                      {"b", json::object()},
                      {"c", json::array()},
                      {"d", std::vector<json>{{{"e", "f"}}}}};
  EXPECT_EQ(JsonText(value), value.dump());
  EXPECT_EQ(JsonText(value, 2), value.dump(2));
  const nlohmann::ordered_json ordered = {{"z", 1}, {"a", {{"y", "2"}, {"b", 3}}}};
  EXPECT_EQ(JsonText(ordered), ordered.dump());
  EXPECT_EQ(JsonText(json("alone")), "\"alone\"");
}

}  // namespace
}  // namespace highwall::apps::json_text_test
