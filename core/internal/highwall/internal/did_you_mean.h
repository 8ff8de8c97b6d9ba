#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace [[gnu::visibility("default")]] highwall {

// Returns the edit distance (Levenshtein 1966): the minimum number of insertions, deletions and
// substitutions of characters that turn a into b.
std::size_t EditDistance(const std::string& a, const std::string& b);

// Returns "; did you mean 'points'?" with the known word closest to an unknown one if it is close
// enough, otherwise an empty string.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& known);

// Does the same for a missing path, with the entries of its folder.
std::string DidYouMeanPath(const std::filesystem::path& path);

}  // namespace highwall
