#include "figures.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <set>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/atomic_file.h>
#include <highwall/core/error.h>
#include <highwall/internal/number_text.h>

#include "cache_folder.h"
#include "files/json_text.h"
#include "sweep.h"
#include "sweep_tables.h"

namespace highwall::bench {
namespace {

SweepPlan PlanOf(const nlohmann::json& sweep, const std::filesystem::path& data) {
  SweepPlan plan;
  plan.data = data;
  plan.seeds = sweep.at("seeds");
  plan.runs = 1;
  plan.synchronous = true;
  for (const nlohmann::json& scene : sweep.at("scenes")) {
    plan.scenes.push_back({.scene = scene.at("scene"),
                           .duration = scene.at("duration_s"),
                           .fps = scene.at("fps"),
                           .scale = scene.at("scale")});
  }
  for (const auto& [name, switches] : sweep.at("settings").items()) {
    plan.settings.push_back({name, switches});
  }
  return plan;
}

// Returns medians over the seeds of the figures that have a tolerance, to six digits.
nlohmann::json Measure(const nlohmann::json& sweep, const nlohmann::json& tolerances,
                       const std::filesystem::path& data) {
  nlohmann::json measured;
  for (const SweepRow& row : MakeRows(RunSweep(PlanOf(sweep, data)))) {
    for (const auto& [name, share] : tolerances.items()) {
      const auto figure = row.median.find(name);
      if (figure == row.median.end()) continue;
      measured[row.sequence][row.setting][name] =
          *ReadNumber<double>(RoundedText(figure->second, 6));
    }
  }
  return measured;
}

nlohmann::json Read(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw IoError(file, "cannot be read");
  try {
    return nlohmann::json::parse(stream);
  } catch (const nlohmann::json::exception& error) {
    throw IoError(file, error.what());
  }
}

// A setting of a sequence may have its own tolerances.
double ToleranceOf(const nlohmann::json& tolerances, const nlohmann::json::json_pointer& figure) {
  const std::string name = figure.back();
  const auto own = tolerances.find(figure.parent_pointer().to_string().substr(1));
  const bool has_own = own != tolerances.end() && own->contains(name);
  return (has_own ? *own : tolerances).at(name).get<double>();
}

void Print(const std::vector<MovedFigure>& moved) {
  for (const MovedFigure& figure : moved) {
    fmt::print("{}: was {:.6g} (+- {:.2g}), is {:.6g}\n", figure.name, figure.expected,
               figure.tolerance, figure.measured);
  }
}

}  // namespace

std::vector<MovedFigure> FindMoved(const nlohmann::json& expected, const nlohmann::json& measured,
                                   const nlohmann::json& tolerances) {
  std::set<std::string> places;
  for (const nlohmann::json& figures : {expected, measured}) {
    const nlohmann::json flat = figures.flatten();
    for (const auto& [place, value] : flat.items()) {
      if (value.is_number()) places.insert(place);
    }
  }
  const auto value_of = [](const nlohmann::json& figures, const nlohmann::json::json_pointer& at) {
    return figures.contains(at) ? figures.at(at).get<double>()
                                : std::numeric_limits<double>::quiet_NaN();
  };
  std::vector<MovedFigure> moved;
  for (const std::string& place : places) {
    const nlohmann::json::json_pointer pointer(place);
    if (!tolerances.contains(pointer.back())) continue;
    MovedFigure figure{place.substr(1), value_of(expected, pointer), value_of(measured, pointer)};
    figure.tolerance = ToleranceOf(tolerances, pointer) * std::abs(figure.expected);
    const bool same = std::abs(figure.measured - figure.expected) <= figure.tolerance;
    if (!same) moved.push_back(figure);  // NaN counts as different
  }
  return moved;
}

bool CheckFigures(const std::filesystem::path& file, const std::string& data, bool renew) {
  nlohmann::json report = Read(file);
  const CacheFolder folder(data, "highwall_bench_tum_figures");
  try {
    const nlohmann::json measured =
        Measure(report.at("sweep"), report.at("tolerances"), folder.path());
    const std::vector<MovedFigure> moved =
        FindMoved(report.at("figures"), measured, report.at("tolerances"));
    Print(moved);
    if (!renew && !moved.empty()) {
      fmt::print("where that is meant: highwall_bench_tum figures {} --renew\n", file.string());
    }
    if (!renew || moved.empty()) return moved.empty();
    report["figures"] = measured;
  } catch (const nlohmann::json::exception& error) {
    throw IoError(file, error.what());
  }
  AtomicFile renewed(file);
  renewed.stream() << apps::JsonText(report, 2) << '\n';
  renewed.Commit();
  return true;
}

}  // namespace highwall::bench
