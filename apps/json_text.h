#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace highwall::apps {

// JSON is UTF-8, but the name of a file may be any bytes. What is no UTF-8 is written as characters
// of its own, byte 0x80 to 0xFF as U+EF80 to U+EFFF; those characters themselves are written so
// too, byte by byte, so that FromUtf8() gives every text back.
std::string ToUtf8(std::string_view bytes);
std::string FromUtf8(std::string_view text);

// The text of a value, all strings and keys in it by ToUtf8(); never throws for what they hold.
// indent: of each level, -1: all in one line.
std::string JsonText(const nlohmann::json& value, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& value, int indent = -1);

// What a file holds; discarded (is_discarded) where it is no JSON, null where there is no such
// file.
nlohmann::json ReadJson(const std::filesystem::path& path);

// A string that was written so, such as the path of a dataset. Throws nlohmann::json::exception for
// what is no string.
std::string StringIn(const nlohmann::json& value);

}  // namespace highwall::apps
