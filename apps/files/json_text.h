#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace highwall::apps {

// JSON is UTF-8, but file names may contain arbitrary bytes. ToUtf8() maps bytes that are not valid
// UTF-8 (0x80 to 0xFF) to U+EF80 to U+EFFF and also escapes those characters themselves byte by
// byte, so that FromUtf8() restores every text.
std::string ToUtf8(std::string_view bytes);
std::string FromUtf8(std::string_view text);

// Serializes a value, all strings and keys converted by ToUtf8(); never throws because of their
// content. indent: per level; -1 puts everything on one line.
std::string JsonText(const nlohmann::json& value, int indent = -1);
std::string JsonText(const nlohmann::ordered_json& value, int indent = -1);

// Reads a file; the result is discarded (is_discarded) if it is not JSON, and null if the file does
// not exist.
nlohmann::json ReadJson(const std::filesystem::path& path);

// Returns a string that was written by JsonText(), such as the path of a dataset. Throws
// nlohmann::json::exception if the value is not a string.
std::string StringIn(const nlohmann::json& value);

}  // namespace highwall::apps
