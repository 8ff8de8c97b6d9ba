#include "paired.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <opencv2/core/utility.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/internal/median.h>

#include "files/json_text.h"
#include "run/run_report.h"

namespace highwall::bench {
namespace {

// A sequence, ready for both settings.
struct PairedSequence {
  std::string name;
  std::unique_ptr<OwnSetting> a;
  std::unique_ptr<Setting> b;
};

// Pairs of a sequence, with their summary.
struct SequenceResult {
  std::string name;
  std::vector<Pair> pairs;
  std::optional<MeanLog> ratio;
};

std::vector<PairedSequence> OpenAll(const PairedArguments& arguments) {
  std::vector<PairedSequence> sequences;
  const auto& [a, b] = arguments.settings;
  for (const std::string& name : arguments.sequences) {
    const std::filesystem::path directory = std::filesystem::path(arguments.data) / name;
    PairedSequence sequence{name, std::make_unique<OwnSetting>(a, directory), nullptr};
    if (arguments.program.empty()) {
      sequence.b = std::make_unique<OwnSetting>(b, directory);
    } else {
      sequence.b = std::make_unique<ProgramSetting>(arguments.program, b, directory);
    }
    const Dataset& images = sequence.a->images();
    if (images.groundtruth() == nullptr) {
      throw IoError(directory / "groundtruth.txt", "is missing or empty; errors need it");
    }
    const std::size_t last = static_cast<std::size_t>(arguments.pairs - 1) * arguments.step;
    if (last >= images.size()) {
      throw IoError(directory,
                    fmt::format("has {} frames, too few for {} beginnings {} frames apart",
                                images.size(), arguments.pairs, arguments.step));
    }
    sequences.push_back(std::move(sequence));
  }
  return sequences;
}

// Alternates A, B, B, A, and so on: a machine that slows down favours neither.
Pair RunPair(const PairedSequence& sequence, std::size_t number, std::size_t begin) {
  const auto run = [&](const Setting& setting, const char* name) {
    return setting.Run(begin, fmt::format("{} {} from frame {}", sequence.name, name, begin));
  };
  SettingRun a, b;
  if (number % 2 == 1) b = run(*sequence.b, "B");
  a = run(*sequence.a, "A");
  if (number % 2 == 0) b = run(*sequence.b, "B");
  const Dataset& images = sequence.a->images();
  return ComparePair(*images.groundtruth(), begin, images.size() - begin, std::move(a),
                     std::move(b));
}

SequenceResult RunSequence(const PairedSequence& sequence, const PairedArguments& arguments) {
  SequenceResult result{sequence.name, {}, {}};
  for (int i = 0; i < arguments.pairs; ++i) {
    const auto number = static_cast<std::size_t>(i);
    result.pairs.push_back(RunPair(sequence, number, number * arguments.step));
  }
  result.ratio = MeanLogRatio(result.pairs);
  return result;
}

// Returns the poses whose stamps the other has as well. Stamps ascend.
Trajectory PosesAlsoIn(const Trajectory& other, const Trajectory& trajectory) {
  Trajectory common;
  std::ranges::copy_if(trajectory, std::back_inserter(common), [&](const StampedPose& pose) {
    return std::ranges::binary_search(other, pose.stamp, {}, &StampedPose::stamp);
  });
  return common;
}

std::string TooShort(const char* name, const SettingRun& run, std::size_t frames) {
  if (!run.trajectory.empty() && 2 * run.trajectory.size() >= frames) return "";
  const std::string why = run.failure.empty() ? "" : fmt::format(" ({})", run.failure);
  return fmt::format("{} has {} of {} frames in one map{}", name, run.trajectory.size(), frames,
                     why);
}

// Returns the median over the runs of one setting, over compared pairs only or over all.
template <class Figure>
std::optional<double> MedianOf(const std::vector<Pair>& pairs, bool compared,
                               const Figure& figure) {
  std::vector<double> values;
  for (const Pair& pair : pairs) {
    if (!compared || pair.problem.empty()) values.push_back(figure(pair));
  }
  return values.empty() ? std::nullopt : std::optional(UpperMedian(std::move(values)));
}

// Table entries of a sequence; empty if no pair is compared.
struct SequenceFigures {
  explicit SequenceFigures(const std::vector<Pair>& pairs)
      : ape_a(MedianOf(pairs, true, [](const Pair& pair) { return pair.ape_a; })),
        ape_b(MedianOf(pairs, true, [](const Pair& pair) { return pair.ape_b; })),
        frame_ms_a(*MedianOf(pairs, false, [](const Pair& pair) { return pair.a.frame_ms; })),
        frame_ms_b(*MedianOf(pairs, false, [](const Pair& pair) { return pair.b.frame_ms; })) {
    for (const Pair& pair : pairs) {
      if (pair.problem.empty()) ++compared;
      lost_a += pair.a.lost;
      lost_b += pair.b.lost;
    }
  }

  std::optional<double> ape_a, ape_b;  // [m]
  double frame_ms_a, frame_ms_b;
  std::size_t compared = 0;
  std::size_t lost_a = 0, lost_b = 0;  // frames of all runs
};

void PrintHeader() {
  fmt::print("{:<20} {:>5} {:>9} {:>9} {:>6} {:>16} {:>6} {:>6} {:>10} {:>10}\n", "sequence",
             "pairs", "APE A mm", "APE B mm", "B/A", "95 % interval", "lost A", "lost B",
             "frame A ms", "frame B ms");
}

void PrintRow(const SequenceResult& result) {
  const SequenceFigures figures(result.pairs);
  const auto millimetres = [](const std::optional<double>& ape) {
    return ape ? fmt::format("{:.2f}", 1e3 * *ape) : "-";
  };
  const std::string ratio = result.ratio ? fmt::format("{:.3f}", Ratio(*result.ratio)) : "-";
  fmt::print("{:<20} {:>5} {:>9} {:>9} {:>6} {:>16} {:>6} {:>6} {:>10.2f} {:>10.2f}\n", result.name,
             figures.compared, millimetres(figures.ape_a), millimetres(figures.ape_b), ratio,
             IntervalText(result.ratio), figures.lost_a, figures.lost_b, figures.frame_ms_a,
             figures.frame_ms_b);
  std::fflush(stdout);
}

// Summarizes all sequences that have a ratio.
OverSequences Summarize(const std::vector<SequenceResult>& results) {
  std::vector<MeanLog> means;
  for (const SequenceResult& result : results) {
    if (result.ratio) means.push_back(*result.ratio);
  }
  return Over(means);
}

void PrintOverall(const std::vector<SequenceResult>& results) {
  const OverSequences all = Summarize(results);
  if (!all.these) {
    fmt::print("no pair could be compared\n");
    return;
  }
  fmt::print("geometric mean of {} sequences: B/A {:.3f}; 95 %: {} for these, {} for any such\n",
             all.sequences, Ratio(*all.these), IntervalText(all.these), IntervalText(all.such));
}

void PrintProblems(const std::vector<SequenceResult>& results) {
  std::size_t count = 0, pairs = 0;
  for (const SequenceResult& result : results) {
    pairs += result.pairs.size();
    for (const Pair& pair : result.pairs) {
      if (pair.problem.empty()) continue;
      ++count;
      fmt::print("not compared: {} from frame {}: {}\n", result.name, pair.begin, pair.problem);
    }
  }
  if (count > 0) fmt::print("not compared: {} of {} pairs\n", count, pairs);
}

std::string Shown(const std::string& setting) {
  return setting.empty() ? "(default)" : setting;
}

void PrintSettings(const PairedArguments& arguments) {
  const auto& [a, b] = arguments.settings;
  const std::string by = arguments.program.empty() ? "" : fmt::format(", by {}", arguments.program);
  fmt::print("A: {}\nB: {}{}\n", Shown(a), Shown(b), by);
}

nlohmann::json ToJson(const std::optional<MeanLog>& mean) {
  if (!mean) return nullptr;
  nlohmann::json json{{"b_over_a", Ratio(*mean)},
                      {"log_mean", mean->mean},
                      {"log_sigma", std::sqrt(mean->variance)},
                      {"degrees_of_freedom", mean->degrees_of_freedom}};
  if (const auto interval = RatioInterval(*mean)) {
    json["interval_95"] = {interval->low, interval->high};
  }
  return json;
}

nlohmann::json ToJson(const Pair& pair) {
  const auto run = [&](const SettingRun& one, double ape) {
    nlohmann::json json{
        {"frames", one.trajectory.size()}, {"lost_frames", one.lost}, {"frame_ms", one.frame_ms}};
    if (pair.problem.empty()) json["ape_rmse_m"] = ape;
    return json;
  };
  nlohmann::json json{{"begin", pair.begin},
                      {"common_frames", pair.common_frames},
                      {"a", run(pair.a, pair.ape_a)},
                      {"b", run(pair.b, pair.ape_b)}};
  if (!pair.problem.empty()) json["not_compared"] = pair.problem;
  return json;
}

nlohmann::json ToJson(const PairedArguments& arguments,
                      const std::vector<SequenceResult>& results) {
  nlohmann::json report;
  report["versions"] = apps::VersionsJson();
  report["a"] = arguments.settings.first;
  report["b"] = arguments.settings.second;
  if (!arguments.program.empty()) report["program_of_b"] = arguments.program;
  report["step_frames"] = arguments.step;
  for (const SequenceResult& result : results) {
    const SequenceFigures figures(result.pairs);
    nlohmann::json& entry = report["sequences"][result.name];
    entry["compared"] = figures.compared;
    entry["ratio"] = ToJson(result.ratio);
    entry["a"] = {{"lost_frames", figures.lost_a}, {"frame_ms", figures.frame_ms_a}};
    entry["b"] = {{"lost_frames", figures.lost_b}, {"frame_ms", figures.frame_ms_b}};
    if (figures.ape_a) entry["a"]["ape_rmse_m"] = *figures.ape_a;
    if (figures.ape_b) entry["b"]["ape_rmse_m"] = *figures.ape_b;
    for (const Pair& pair : result.pairs) entry["pairs"].push_back(ToJson(pair));
  }
  const OverSequences all = Summarize(results);
  report["all"] = {
      {"sequences", all.sequences}, {"these", ToJson(all.these)}, {"any_such", ToJson(all.such)}};
  return report;
}

}  // namespace

Pair ComparePair(const Trajectory& truth, std::size_t begin, std::size_t frames, SettingRun a,
                 SettingRun b) {
  Pair pair;
  pair.begin = begin;
  const Trajectory common_a = PosesAlsoIn(b.trajectory, a.trajectory);
  const Trajectory common_b = PosesAlsoIn(a.trajectory, b.trajectory);
  pair.common_frames = common_a.size();
  const std::string short_a = TooShort("A", a, frames), short_b = TooShort("B", b, frames);
  pair.problem = short_a + (short_a.empty() || short_b.empty() ? "" : ", ") + short_b;
  pair.a = std::move(a);
  pair.b = std::move(b);
  if (!pair.problem.empty()) return pair;
  try {
    pair.ape_a = AbsolutePoseError(truth, common_a).statistics.rmse;
    pair.ape_b = AbsolutePoseError(truth, common_b).statistics.rmse;
  } catch (const InvalidArgument& error) {
    pair.problem = error.what();
    return pair;
  }
  if (pair.ape_a <= 0.0 || pair.ape_b <= 0.0) pair.problem = "an error of zero has no ratio";
  return pair;
}

std::optional<MeanLog> MeanLogRatio(const std::vector<Pair>& pairs) {
  std::vector<double> logs;
  for (const Pair& pair : pairs) {
    if (pair.problem.empty()) logs.push_back(std::log(pair.ape_b / pair.ape_a));
  }
  return logs.empty() ? std::nullopt : std::optional(MeanOf(logs));
}

void RunPaired(const PairedArguments& arguments) {
  cv::setNumThreads(1);  // as `highwall slam --deterministic`
  const std::vector<PairedSequence> sequences = OpenAll(arguments);
  std::vector<SequenceResult> results;
  if (!arguments.json) PrintHeader();
  for (const PairedSequence& sequence : sequences) {
    results.push_back(RunSequence(sequence, arguments));
    if (!arguments.json) PrintRow(results.back());
  }
  if (arguments.json) {
    fmt::print("{}\n", apps::JsonText(ToJson(arguments, results), 2));
    return;
  }
  if (results.size() > 1) PrintOverall(results);
  PrintProblems(results);
  PrintSettings(arguments);
}

}  // namespace highwall::bench
