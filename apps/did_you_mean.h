#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace highwall::apps {

// The least number of insertions, deletions and replacements of a character that turn a into b
// (Levenshtein 1966).
std::size_t EditDistance(const std::string& a, const std::string& b);

// "; did you mean 'points'?" with the known word that is nearest to one that is not known, as long
// as it is near enough to be meant; else empty.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& known);

// The same for a path that is not there, with what lies in its folder.
std::string DidYouMeanPath(const std::filesystem::path& path);

}  // namespace highwall::apps
