#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

// Figures that every change is measured by: generated sequences, in lockstep, against a file.
namespace highwall::bench {

// What a figure was and is.
struct MovedFigure {
  std::string name;  // "room_4s_15fps/points/ape_rmse_m"
  double expected = 0.0, measured = 0.0;
  double tolerance = 0.0;  // |measured - expected| that is allowed
};

// expected and measured: {SEQUENCE: {SETTING: {FIGURE: value}}}. tolerances: {FIGURE: share of the
// expected value}; a figure without one is not compared. Beside them {"SEQUENCE/SETTING": {FIGURE:
// share}}, for one that the same code measures otherwise on another machine. What one of expected
// and measured lacks is NaN there, and has moved.
std::vector<MovedFigure> FindMoved(const nlohmann::json& expected, const nlohmann::json& measured,
                                   const nlohmann::json& tolerances);

// Runs what `file` describes, in `data` (empty: a temporary folder), and compares, or with `renew`
// writes what was measured to the file. Prints what has moved, with both values; false where that
// is anything and the file was not renewed. Throws IoError.
bool CheckFigures(const std::filesystem::path& file, const std::string& data, bool renew);

}  // namespace highwall::bench
