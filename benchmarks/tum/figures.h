#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

// Reference figures for every change: generated sequences, in synchronous mode, compared with a
// file.
namespace highwall::bench {

// A figure that changed.
struct MovedFigure {
  std::string name;  // "room_4s_15fps/points/ape_rmse_m"
  double expected = 0.0, measured = 0.0;
  double tolerance = 0.0;  // maximum |measured - expected|
};

// expected and measured: {SEQUENCE: {SETTING: {FIGURE: value}}}. tolerances: {FIGURE: share of the
// expected value}; a figure without one is not compared. In addition {"SEQUENCE/SETTING": {FIGURE:
// share}} for figures that differ between machines with the same code. A figure missing in expected
// or measured is NaN there, and counts as moved.
std::vector<MovedFigure> FindMoved(const nlohmann::json& expected, const nlohmann::json& measured,
                                   const nlohmann::json& tolerances);

// Runs the configuration in `file`, in `data` (empty: a temporary folder), and compares, or with
// `renew` writes the measured figures to the file. Prints the figures that moved, with both values;
// returns false if there are any and the file was not renewed. Throws IoError.
bool CheckFigures(const std::filesystem::path& file, const std::string& data, bool renew);

}  // namespace highwall::bench
