#include "misuse_table.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <set>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/internal/median.h>

namespace highwall::bench {
namespace {

using Json = nlohmann::ordered_json;

std::optional<double> Over(const std::optional<double>& ape, const std::optional<double>& other) {
  return ape && other && *other > 0.0 ? std::optional(*ape / *other) : std::nullopt;
}

// Returns the share of the trials for which `holds`.
template <class Trials, class Holds>
double ShareOf(const Trials& trials, const Holds& holds) {
  return static_cast<double>(std::ranges::count_if(trials, holds)) /
         static_cast<double>(trials.size());
}

// Returns the median of a figure over the trials that have it.
template <class Trials, class Figure>
std::optional<double> MedianOf(const Trials& trials, const Figure& figure) {
  std::vector<double> values;
  for (const auto& trial : trials) {
    if (const std::optional<double> value = std::invoke(figure, trial)) values.push_back(*value);
  }
  return values.empty() ? std::nullopt : std::optional(UpperMedian(std::move(values)));
}

std::string Cell(const std::optional<double>& value, const char* format) {
  return value ? fmt::format(fmt::runtime(format), *value) : "-";
}

// Returns the names of what was found, in the order in which they first occurred.
std::string FoundIn(const Trial& trial) {
  std::string names = trial.refusal.empty() ? "" : "refused";
  for (const SensorFinding& finding : trial.verdict.findings) {
    names += (names.empty() ? "" : ", ") + std::string(ToString(finding.fault));
  }
  return names.empty() ? "nothing" : names;
}

Json FindingsJson(const Trial& trial) {
  Json findings = Json::array();
  for (const SensorFinding& finding : trial.verdict.findings) {
    findings.push_back({{"fault", ToString(finding.fault)},
                        {"trust", ToString(finding.trust)},
                        {"text", Line(finding)}});
  }
  return findings;
}

void SetIf(Json* json, const char* name, const std::optional<double>& value) {
  if (value) (*json)[name] = *value;
}

}  // namespace

void MisuseTable::AddTo(std::vector<Row>* rows, const std::string& name, bool inertial,
                        Scored scored) {
  const std::string ape =
      scored.trial.ape ? fmt::format("{:.1f} mm", 1e3 * *scored.trial.ape) : "-";
  fmt::print(stderr, "{}, {}: {}, APE {}\n", scored.recording, name, FoundIn(scored.trial), ape);
  auto row = std::ranges::find(*rows, name, &Row::name);
  if (row == rows->end()) row = rows->insert(rows->end(), {name, inertial, {}});
  row->trials.push_back(std::move(scored));
}

void MisuseTable::Add(const Misuse& misuse, const std::string& recording, const Trial& trial,
                      const RightTrials& right) {
  const Trial& same = misuse.inertial && right.both ? *right.both : right.images;
  Scored scored{.recording = recording,
                .trial = trial,
                .detected = IsDetected(trial),
                .named = IsNamed(trial, misuse.expected),
                .over_right = Over(trial.ape, same.ape),
                .over_images = {}};
  if (misuse.inertial) scored.over_images = Over(trial.ape, right.images.ape);
  AddTo(&misuses_, NameOf(misuse), misuse.inertial, std::move(scored));
}

void MisuseTable::AddRight(const std::string& name, const std::string& recording,
                           const Trial& trial) {
  AddTo(&right_, name, false,
        {.recording = recording,
         .trial = trial,
         .detected = IsDetected(trial),
         .named = false,
         .over_right = {},
         .over_images = {}});
}

Json MisuseTable::RowJson(const Row& row, bool is_right) {
  Json json{{"trials", row.trials.size()}};
  json[is_right ? "false_alarms" : "detected"] = ShareOf(row.trials, &Scored::detected);
  if (!is_right) json["named"] = ShareOf(row.trials, &Scored::named);
  SetIf(&json, "ape_rmse_m", MedianOf(row.trials, [](const Scored& s) { return s.trial.ape; }));
  SetIf(&json, "ape_over_right", MedianOf(row.trials, &Scored::over_right));
  SetIf(&json, "ape_over_images_alone", MedianOf(row.trials, &Scored::over_images));
  for (const Scored& scored : row.trials) {
    const Trial& trial = scored.trial;
    Json run{{"recording", scored.recording},
             {"detected", scored.detected},
             {"verdict", ToString(trial.verdict.trust())},
             {"findings", FindingsJson(trial)},
             {"posed", trial.posed},
             {"keyframes_per_frame", trial.keyframes},
             {"processor_ms_per_frame", trial.processor_ms}};
    if (!is_right) run["named"] = scored.named;
    if (!trial.refusal.empty()) run["refusal"] = trial.refusal;
    SetIf(&run, "ape_rmse_m", trial.ape);
    SetIf(&run, "ape_over_right", scored.over_right);
    SetIf(&run, "ape_over_images_alone", scored.over_images);
    json["runs"].push_back(std::move(run));
  }
  return json;
}

Json MisuseTable::ToJson() const {
  Json json{{"misuses", Json::object()}, {"right", Json::object()}};
  std::size_t trials = 0, detected = 0, named = 0, right = 0, alarms = 0;
  for (const Row& row : misuses_) {
    json["misuses"][row.name] = RowJson(row, false);
    trials += row.trials.size();
    detected += static_cast<std::size_t>(std::ranges::count_if(row.trials, &Scored::detected));
    named += static_cast<std::size_t>(std::ranges::count_if(row.trials, &Scored::named));
  }
  for (const Row& row : right_) {
    json["right"][row.name] = RowJson(row, true);
    right += row.trials.size();
    alarms += static_cast<std::size_t>(std::ranges::count_if(row.trials, &Scored::detected));
  }
  json["misuses_total"] = {{"trials", trials}, {"detected", detected}, {"named", named}};
  json["right_total"] = {{"trials", right}, {"false_alarms", alarms}};
  return json;
}

void MisuseTable::PrintRows(const std::vector<Row>& rows, bool is_right) {
  for (const Row& row : rows) {
    std::set<std::string> found;
    for (const Scored& scored : row.trials) found.insert(FoundIn(scored.trial));
    std::string all;
    for (const std::string& names : found) all += (all.empty() ? "" : "; ") + names;
    const std::string shares =
        is_right
            ? fmt::format("{:.0f} %", 100.0 * ShareOf(row.trials, &Scored::detected))
            : fmt::format("{:.0f} % | {:.0f} %", 100.0 * ShareOf(row.trials, &Scored::detected),
                          100.0 * ShareOf(row.trials, &Scored::named));
    const auto ape = MedianOf(row.trials, [](const Scored& s) { return s.trial.ape; });
    fmt::print("| {} | {} | {} | {} |", row.name, row.trials.size(), shares,
               ape ? fmt::format("{:.1f} mm", 1e3 * *ape) : "-");
    if (!is_right) {
      fmt::print(" {} | {} |", Cell(MedianOf(row.trials, &Scored::over_right), "{:.2f}"),
                 Cell(MedianOf(row.trials, &Scored::over_images), "{:.2f}"));
    }
    fmt::print(" {} |\n", all);
  }
}

void MisuseTable::Print() const {
  fmt::print(
      "| misuse | trials | detected | named | APE RMSE | over right | over images alone | found |\n"
      "|---|---|---|---|---|---|---|---|\n");
  PrintRows(misuses_, false);
  fmt::print(
      "\n| right recording | trials | false alarms | APE RMSE | found |\n|---|---|---|---|---|\n");
  PrintRows(right_, true);
}

}  // namespace highwall::bench
