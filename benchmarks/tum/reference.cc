#include "reference.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/core/trajectory_error.h>
#include <highwall/internal/median.h>

#include "run/opened_dataset.h"
#include "sweep_run.h"

namespace highwall::bench {
namespace {

constexpr Stamp kTolerance = 10'000'000;  // [ns]; frames are 33 ms apart

// Returns the pose of each frame in the trajectory; null if it has none.
std::vector<const StampedPose*> PosesOf(const std::vector<Stamp>& frames,
                                        const Trajectory& trajectory) {
  std::vector<const StampedPose*> poses;
  for (const Stamp frame : frames) {
    const auto after = std::ranges::lower_bound(trajectory, frame, {}, &StampedPose::stamp);
    const StampedPose* nearest = nullptr;
    Stamp distance = kTolerance;
    for (auto pose = after == trajectory.begin() ? after : std::prev(after);
         pose != trajectory.end() && pose <= after; ++pose) {
      if (std::abs(pose->stamp - frame) > distance) continue;
      distance = std::abs(pose->stamp - frame);
      nearest = &*pose;
    }
    poses.push_back(nearest);
  }
  return poses;
}

// Poses of the runs of one system, frame by frame.
using FramePoses = std::vector<std::vector<const StampedPose*>>;

FramePoses PosesOf(const std::vector<Stamp>& frames, const std::vector<Trajectory>& runs) {
  FramePoses poses;
  for (const Trajectory& run : runs) poses.push_back(PosesOf(frames, run));
  return poses;
}

double MedianCoverage(const FramePoses& runs) {
  std::vector<double> shares;
  for (const auto& poses : runs) {
    const auto missing = std::ranges::count(poses, nullptr);
    shares.push_back(1.0 - static_cast<double>(missing) / static_cast<double>(poses.size()));
  }
  return UpperMedian(std::move(shares));
}

// Returns the frames with a pose in every run of both.
std::vector<std::size_t> CommonFrames(std::size_t frames, const FramePoses& a,
                                      const FramePoses& b) {
  std::vector<std::size_t> common;
  for (std::size_t i = 0; i < frames; ++i) {
    const auto has_pose = [i](const auto& poses) { return poses[i] != nullptr; };
    if (std::ranges::all_of(a, has_pose) && std::ranges::all_of(b, has_pose)) common.push_back(i);
  }
  return common;
}

double RpeOr(double fallback, const Trajectory& truth, const Trajectory& part,
             const RelativePoseErrorOptions& options) {
  try {
    return RelativePoseError(truth, part, options).statistics.rmse;
  } catch (const InvalidArgument&) {  // too few frames
    return fallback;
  }
}

// Fills errors, and returns the logarithms of the APE of each run. Throws InvalidArgument.
std::vector<double> Score(const ScoredFrames& frames, const FramePoses& runs,
                          const std::vector<std::size_t>& common, SystemScore* score) {
  std::vector<double> ape, rpe_1, rpe_30, logs;
  for (const auto& poses : runs) {
    Trajectory part;  // with the frame's stamp instead of the system's
    for (const std::size_t i : common) part.push_back({frames.stamps[i], poses[i]->pose});
    ape.push_back(AbsolutePoseError(frames.truth, part).statistics.rmse);
    HIGHWALL_REQUIRE(ape.back() > 0.0, "an error of zero has no ratio");
    logs.push_back(std::log(ape.back()));
    rpe_1.push_back(RpeOr(-1.0, frames.truth, part, {}));
    rpe_30.push_back(RpeOr(-1.0, frames.truth, part, kThirtyFrames));
  }
  score->ape = UpperMedian(std::move(ape));
  score->rpe_1 = UpperMedian(std::move(rpe_1));
  score->rpe_30 = UpperMedian(std::move(rpe_30));
  return logs;
}

ScoredFrames FramesOf(const std::filesystem::path& folder) {
  const apps::OpenedDataset dataset = apps::OpenWithConfig("", folder);
  const Trajectory* truth = dataset.images->groundtruth();
  if (truth == nullptr) throw IoError(folder, "has no ground truth, which errors need");
  ScoredFrames frames{{}, *truth};
  for (std::size_t i = 0; i < dataset.images->size(); ++i) {
    frames.stamps.push_back(dataset.images->stamp(i));
  }
  return frames;
}

std::vector<Trajectory> TrajectoriesOf(const SweepRow& row) {
  std::vector<Trajectory> trajectories;
  for (const RunRecord& run : row.runs) trajectories.push_back(run.trajectory);
  return trajectories;
}

std::string RatioText(const std::optional<MeanLog>& ratio) {
  return ratio ? fmt::format("{:.3f}", Ratio(*ratio)) : "-";
}

std::string Millimetres(double metres) {
  return metres < 0.0 ? "-" : fmt::format("{:.2f}", 1e3 * metres);
}

// Summarizes by setting and system, if there are several sequences.
std::map<std::pair<std::string, std::string>, OverSequences> Summarize(
    const std::vector<Comparison>& comparisons) {
  std::map<std::pair<std::string, std::string>, std::vector<MeanLog>> ratios;
  for (const Comparison& one : comparisons) {
    if (one.ratio) ratios[{one.setting, one.reference}].push_back(*one.ratio);
  }
  std::map<std::pair<std::string, std::string>, OverSequences> all;
  for (const auto& [names, means] : ratios) {
    if (means.size() > 1) all[names] = Over(means);
  }
  return all;
}

nlohmann::json ToJson(const SystemScore& score) {
  return {{"runs", score.runs},
          {"coverage", score.coverage},
          {"ape_rmse_m", score.ape},
          {"rpe_1_frame_rmse_m", score.rpe_1},
          {"rpe_30_frames_rmse_m", score.rpe_30}};
}

nlohmann::json RatioJson(const MeanLog& mean) {
  nlohmann::json json{{"value", Ratio(mean)}, {"degrees_of_freedom", mean.degrees_of_freedom}};
  if (const auto interval = RatioInterval(mean)) {
    json["interval_95"] = {interval->low, interval->high};
  }
  return json;
}

}  // namespace

ReferenceSystem ParseReference(const std::string& text) {
  const std::size_t sign = text.find('=');
  HIGHWALL_REQUIRE(sign != std::string::npos && sign > 0 && sign + 1 < text.size(),
                   "a reference is NAME=DIR, not " + text);
  return {text.substr(0, sign), text.substr(sign + 1)};
}

std::vector<Trajectory> ReferenceRuns(const ReferenceSystem& system, const std::string& sequence,
                                      const std::vector<std::string>& others) {
  std::error_code error;
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(system.folder, error)) {
    const std::string name = entry.path().filename().string();
    const auto is_of = [&name](const std::string& of) {
      return name == of + ".txt" || (name.starts_with(of + "_") && name.ends_with(".txt"));
    };
    const bool is_of_longer = std::ranges::any_of(others, [&](const std::string& other) {
      return other.size() > sequence.size() && is_of(other);
    });
    if (is_of(sequence) && !is_of_longer) files.insert(entry.path());
  }
  if (error) throw IoError(system.folder, "cannot be listed: " + error.message());
  std::vector<Trajectory> runs;
  for (const std::filesystem::path& file : files) runs.push_back(ReadTumTrajectory(file));
  return runs;
}

Comparison Compare(const ScoredFrames& frames, const std::vector<Trajectory>& own,
                   const std::vector<Trajectory>& other) {
  HIGHWALL_REQUIRE(!own.empty() && !other.empty() && !frames.stamps.empty(),
                   "runs of both systems and frames are needed");
  Comparison result;
  result.frames = frames.stamps.size();
  const FramePoses a = PosesOf(frames.stamps, own), b = PosesOf(frames.stamps, other);
  const std::vector<std::size_t> common = CommonFrames(result.frames, a, b);
  result.common = common.size();
  result.own.runs = own.size();
  result.other.runs = other.size();
  result.own.coverage = MedianCoverage(a);
  result.other.coverage = MedianCoverage(b);
  try {
    const MeanLog log_a = MeanOf(Score(frames, a, common, &result.own));
    const MeanLog log_b = MeanOf(Score(frames, b, common, &result.other));
    result.ratio = DifferenceOf(log_a, log_b);
  } catch (const InvalidArgument& error) {
    result.problem = error.what();
  }
  return result;
}

std::vector<Comparison> CompareAll(const std::vector<SweepRow>& rows,
                                   const std::vector<ReferenceSystem>& systems,
                                   const std::filesystem::path& data) {
  std::vector<std::string> sequences;
  for (const SweepRow& row : rows) sequences.push_back(row.sequence);
  std::vector<Comparison> comparisons;
  for (const ReferenceSystem& system : systems) {
    const std::size_t before = comparisons.size();
    for (const SweepRow& row : rows) {
      if (row.runs.front().key.seed > 0) continue;
      const std::vector<Trajectory> runs = ReferenceRuns(system, row.sequence, sequences);
      if (runs.empty()) continue;
      Comparison& comparison = comparisons.emplace_back(
          Compare(FramesOf(data / row.sequence), TrajectoriesOf(row), runs));
      comparison.sequence = row.sequence;
      comparison.setting = row.setting;
      comparison.reference = system.name;
    }
    if (comparisons.size() == before) {
      throw IoError(system.folder, "has no SEQUENCE_*.txt of any of the sequences");
    }
  }
  return comparisons;
}

std::string ToMarkdown(const std::vector<Comparison>& comparisons) {
  std::string text =
      "| sequence | setting | against | runs | common frames | coverage | APE RMSE [mm] | RPE, 1 "
      "frame [mm] | RPE, 30 frames [mm] | APE ratio | 95 % interval |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Comparison& one : comparisons) {
    const auto both = [&](double SystemScore::*figure) {
      return one.problem.empty() ? fmt::format("{} / {}", Millimetres(one.own.*figure),
                                               Millimetres(one.other.*figure))
                                 : "-";
    };
    text += fmt::format(
        "| {} | {} | {} | {} / {} | {} of {} | {:.3f} / {:.3f} | {} | {} | {} | {} | {} |\n",
        one.sequence, one.setting, one.reference, one.own.runs, one.other.runs, one.common,
        one.frames, one.own.coverage, one.other.coverage, both(&SystemScore::ape),
        both(&SystemScore::rpe_1), both(&SystemScore::rpe_30), RatioText(one.ratio),
        IntervalText(one.ratio));
  }
  text += '\n';
  for (const auto& [names, all] : Summarize(comparisons)) {
    text += fmt::format("Over {} sequences {} / {}: {:.3f}; 95 %: {} for these, {} for any such.\n",
                        all.sequences, names.first, names.second, Ratio(*all.these),
                        IntervalText(all.these), IntervalText(all.such));
  }
  for (const Comparison& one : comparisons) {
    if (one.problem.empty()) continue;
    text += fmt::format("Not compared: {} {} with {}: {}.\n", one.sequence, one.setting,
                        one.reference, one.problem);
  }
  return text;
}

nlohmann::json ToJson(const std::vector<Comparison>& comparisons) {
  nlohmann::json json;
  for (const Comparison& one : comparisons) {
    nlohmann::json& entry = json[one.reference][one.sequence][one.setting];
    entry = {{"frames", one.frames},
             {"common_frames", one.common},
             {"own", ToJson(one.own)},
             {"other", ToJson(one.other)}};
    if (one.ratio) entry["ape_ratio"] = RatioJson(*one.ratio);
    if (!one.problem.empty()) entry["not_compared"] = one.problem;
  }
  for (const auto& [names, all] : Summarize(comparisons)) {
    json[names.second]["all"][names.first] = {{"sequences", all.sequences},
                                              {"these", RatioJson(*all.these)},
                                              {"any_such", RatioJson(*all.such)}};
  }
  return json;
}

}  // namespace highwall::bench
