#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <string_view>
#include <vector>

#include <highwall/core/stamp.h>

namespace highwall {

// Returns the files of a folder whose names are the prefix, a whole number and one of the suffixes,
// by their numbers: frame_00012.jpg has the number 12. Of two files with one number the suffix that
// stands first decides. Empty if there is no such folder.
std::map<std::int64_t, std::filesystem::path> NumberedFiles(
    const std::filesystem::path& folder, std::string_view prefix,
    std::initializer_list<std::string_view> suffixes);

// Returns whether there is one, as soon as one is found.
bool HasNumberedFile(const std::filesystem::path& folder, std::string_view prefix,
                     std::initializer_list<std::string_view> suffixes);

// Returns stamps from 0 on for frames without any: 1 / rate [Hz] for the median step between their
// ascending numbers, so that missing frames leave a gap.
std::vector<Stamp> StampsOfNumbers(const std::vector<std::int64_t>& numbers, double rate);

}  // namespace highwall
