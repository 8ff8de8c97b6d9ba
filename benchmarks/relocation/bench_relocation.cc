// highwall_bench_relocation: recovery after tracking loss. Generated walks with exact ground truth,
// once per seed: a camera that is kidnapped to an unseen part of a room, one whose lens is covered
// on that transition, and one that is carried to another room with similar appearance.
#include <CLI/App.hpp>
#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <highwall/internal/median.h>
#include <nlohmann/json.hpp>

#include "bench_main.h"
#include "cache_folder.h"
#include "cli/option_checks.h"
#include "cli/progress.h"
#include "files/json_text.h"
#include "parted_sequence.h"
#include "run/run_report.h"
#include "scores.h"

namespace highwall::bench {
namespace {

// Requirements.
constexpr double kMostGone = 0.5;      // [s] without a pose after the cut
constexpr double kMostUnmerged = 2.0;  // [s] after a known place was seen again
constexpr double kRounding = 1e-5;     // [s] of stamps, which are whole microseconds
constexpr double kMostWorse = 1.2;     // APE relative to the same walk without kidnapping

struct Arguments {
  std::vector<std::string> parts{"kidnap", "covered", "twins"};
  int seeds = 20, first_seed = 1;
  double fps = 30.0, scale = 1.0;
  std::string cache;
  bool json = false;
};

Run RunWithProgress(const PartedSequence& parted, const std::string& label) {
  apps::Progress progress(label);
  return RunSequence(parted,
                     [&](std::size_t done, std::size_t total) { progress.Update(done, total); });
}

std::string Figure(const char* format, const std::optional<double>& value) {
  return value ? fmt::format(fmt::runtime(format), *value) : "-";
}

const char* NameOf(simulate::WayBack way_back) {
  switch (way_back) {
    case simulate::WayBack::kOnward:
      return "onward";
    case simulate::WayBack::kReturn:
      return "return";
    case simulate::WayBack::kPutBack:
      return "put back";
  }
  return "";
}

std::string List(const std::map<std::string, int>& reasons) {
  std::string list;
  for (const auto& [reason, count] : reasons) {
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", count, reason);
  }
  return list;
}

// A figure with the requirements that it misses.
class Verdict {
 public:
  void Require(bool met, const std::string& target) {
    if (!met && std::ranges::find(missed_, target) == missed_.end()) missed_.push_back(target);
  }
  const std::vector<std::string>& missed() const { return missed_; }
  std::string Text() const {
    if (missed_.empty()) return "good";
    std::string text = "MISSED";
    for (const std::string& target : missed_) text += " " + target;
    return text;
  }

 private:
  std::vector<std::string> missed_;
};

nlohmann::json ToJson(const RelocationScores& scores) {
  nlohmann::json json{{"gone_s", scores.gone_s},
                      {"lost_frames", scores.lost},
                      {"lost_covered_frames", scores.lost_covered},
                      {"misplaced_frames", scores.misplaced},
                      {"known_at_first", scores.known_at_first},
                      {"maps", scores.maps},
                      {"merges", scores.merges},
                      {"false_merges", scores.false_merges},
                      {"loops", scores.loops},
                      {"false_loops", scores.false_loops},
                      {"reasons", scores.reasons},
                      {"covered_reasons", scores.covered_reasons}};
  if (scores.matched_after_cut) json["matched_after_cut"] = *scores.matched_after_cut;
  if (scores.due_s) json["known_again_s"] = *scores.due_s;
  if (scores.merged_s) json["merged_after_s"] = *scores.merged_s;
  if (scores.ape_mm) json["ape_mm"] = *scores.ape_mm;
  if (scores.merge) {
    json["merge_error_mm"] = scores.merge->millimetres;
    json["merge_error_deg"] = scores.merge->degrees;
  }
  if (scores.parts) {
    json["parts_error_mm"] = scores.parts->millimetres;
    json["parts_error_deg"] = scores.parts->degrees;
  }
  return json;
}

// Runs of one kind: one line each, and their summary.
class Table {
 public:
  explicit Table(std::string name) : name_(std::move(name)) {}

  void Add(int seed, const RelocationScores& scores, const Verdict& verdict, nlohmann::json figures,
           const std::string& more) {
    fmt::print(stderr,
               "{} {:>2}: gone {:.2f} s, {} lost, {} misplaced; maps {}, merges {} ({} false), "
               "loops {} ({} false){}{}; {}\n",
               name_, seed, scores.gone_s, scores.lost, scores.misplaced, scores.maps,
               scores.merges, scores.false_merges, scores.loops, scores.false_loops,
               scores.matched_after_cut ? fmt::format("; {:.0f} % matched after a cut",
                                                      100.0 * *scores.matched_after_cut)
                                        : "",
               more, verdict.Text());
    if (!scores.reasons.empty()) fmt::print(stderr, "            {}\n", List(scores.reasons));
    figures["seed"] = seed;
    figures["missed"] = verdict.missed();
    good_ += verdict.missed().empty() ? 1 : 0;
    false_merges_ += scores.false_merges;
    longest_gone_ = std::max(longest_gone_, scores.gone_s);
    lost_ += scores.lost - scores.lost_covered;
    misplaced_ += scores.misplaced;
    runs_.push_back(std::move(figures));
  }

  nlohmann::json ToJson() const {
    nlohmann::json json{{"good", good_},
                        {"seeds", runs_.size()},
                        {"false_merges", false_merges_},
                        {"longest_gone_s", longest_gone_},
                        {"lost_frames", lost_},
                        {"misplaced_frames", misplaced_},
                        {"runs", runs_}};
    for (const char* figure :
         {"merged_after_s", "ape_same_frames_mm", "ape_without_kidnap_mm", "ape_in_order_mm"}) {
      std::vector<double> values;
      for (const nlohmann::json& run : runs_) {
        if (run.contains(figure)) values.push_back(run[figure]);
      }
      if (!values.empty()) json[fmt::format("median_{}", figure)] = UpperMedian(values);
    }
    return json;
  }

 private:
  std::string name_;
  int good_ = 0, false_merges_ = 0, lost_ = 0, misplaced_ = 0;
  double longest_gone_ = 0.0;
  std::vector<nlohmann::json> runs_;
};

void RequireEach(const RelocationScores& scores, Verdict* verdict) {
  verdict->Require(scores.gone_s <= kMostGone, "gone");
  verdict->Require(!scores.reasons.contains(""), "reason");
  verdict->Require(scores.misplaced == 0, "places");
  verdict->Require(scores.false_merges == 0, "merges");
  verdict->Require(scores.false_loops == 0, "loops");
}

// A sequence with the result of its run.
struct Shown {
  Shown(const WalkInParts& sequence, Ways ways, const std::string& label)
      : parted(sequence, ways), run(RunWithProgress(parted, label)) {}

  PartedSequence parted;
  Run run;
};

// Runs a walk through one room without its transitions, and compares it with two runs without
// kidnapping: the complete walk, which may close one more loop, and the same images in another
// order.
void RunKidnap(const WalkInParts& sequence, Ways ways, const Shown& whole, const Shown& ordered,
               int seed, const std::string& label, Table* table) {
  const auto [parted, run] = Shown(sequence, ways, label);
  const RelocationScores scores = ScoreRun(parted, run);
  const auto ape = ApeOverSameFrames(parted, run, whole.parted, whole.run);
  const auto whole_ape = ApeOverSameFrames(whole.parted, whole.run, parted, run);
  const auto ordered_ape = ApeOverSameFrames(ordered.parted, ordered.run, parted, run);
  const bool merged = scores.merged_s && scores.maps == 1;

  Verdict verdict;
  RequireEach(scores, &verdict);
  verdict.Require(merged && *scores.merged_s <= kMostUnmerged + kRounding, "merged");
  verdict.Require(merged && ape && whole_ape && *ape <= kMostWorse * *whole_ape, "APE");
  std::string more = fmt::format(
      "; {}: known again at {} s, merged {} s later, APE {} mm, without kidnap {} mm, in order {} "
      "mm",
      NameOf(simulate::WayBackOf(sequence.seed())), Figure("{:.1f}", scores.due_s),
      Figure("{:+.2f}", scores.merged_s), Figure("{:.1f}", ape), Figure("{:.1f}", whole_ape),
      Figure("{:.1f}", ordered_ape));
  if (scores.merge) {
    more += fmt::format(", merge {:.1f} mm {:.2f} deg off", scores.merge->millimetres,
                        scores.merge->degrees);
  }
  if (scores.parts) {
    more += fmt::format(", parts {:.1f} mm {:.2f} deg off", scores.parts->millimetres,
                        scores.parts->degrees);
  }
  nlohmann::json figures = ToJson(scores);
  if (ape) figures["ape_same_frames_mm"] = *ape;
  if (whole_ape) figures["ape_without_kidnap_mm"] = *whole_ape;
  if (ordered_ape) figures["ape_in_order_mm"] = *ordered_ape;
  if (ways == Ways::kCovered) more += "; covered: " + List(scores.covered_reasons);
  figures["refusals"] = run.refusals;
  figures["way_back"] = NameOf(simulate::WayBackOf(sequence.seed()));
  table->Add(seed, scores, verdict, std::move(figures), more);
}

WalkInParts Render(const Arguments& arguments, bool twins, int seed, const CacheFolder& cache) {
  apps::Progress progress(fmt::format("{} {}: rendering", twins ? "twins" : "kidnap", seed));
  return WalkInParts({.twins = twins,
                      .seed = static_cast<std::uint64_t>(seed),
                      .fps = arguments.fps,
                      .scale = arguments.scale},
                     cache.path(), [&progress](int done, int total) {
                       progress.Update(static_cast<std::size_t>(done),
                                       static_cast<std::size_t>(total));
                     });
}

void BenchKidnaps(const Arguments& arguments, const std::set<std::string>& wanted,
                  const CacheFolder& cache, nlohmann::json* report) {
  Table cut("kidnap"), covered("covered");
  for (int seed = arguments.first_seed; seed < arguments.first_seed + arguments.seeds; ++seed) {
    const WalkInParts sequence = Render(arguments, false, seed, cache);
    const Shown whole(sequence, Ways::kShown, fmt::format("kidnap {}: without", seed));
    const Shown ordered(sequence, Ways::kNotNeeded, fmt::format("kidnap {}: in order", seed));
    if (wanted.contains("kidnap")) {
      RunKidnap(sequence, Ways::kLeftOut, whole, ordered, seed, fmt::format("kidnap {}", seed),
                &cut);
    }
    if (wanted.contains("covered")) {
      RunKidnap(sequence, Ways::kCovered, whole, ordered, seed, fmt::format("covered {}", seed),
                &covered);
    }
  }
  if (wanted.contains("kidnap")) (*report)["kidnap"] = cut.ToJson();
  if (wanted.contains("covered")) (*report)["covered"] = covered.ToJson();
}

nlohmann::json BenchTwins(const Arguments& arguments, const CacheFolder& cache) {
  Table table("twins");
  for (int seed = arguments.first_seed; seed < arguments.first_seed + arguments.seeds; ++seed) {
    const WalkInParts sequence = Render(arguments, true, seed, cache);
    const PartedSequence parted(sequence, Ways::kLeftOut);
    const Run run = RunWithProgress(parted, fmt::format("twins {}", seed));
    const RelocationScores scores = ScoreRun(parted, run);
    Verdict verdict;
    RequireEach(scores, &verdict);
    verdict.Require(scores.merges == 0, "merges");
    nlohmann::json figures = ToJson(scores);
    figures["refusals"] = run.refusals;
    table.Add(seed, scores, verdict, std::move(figures), "");
  }
  return table.ToJson();
}

void Bench(const Arguments& arguments) {
  const CacheFolder cache(arguments.cache, "highwall_bench_relocation");
  const std::set<std::string> wanted(arguments.parts.begin(), arguments.parts.end());
  nlohmann::json report;
  if (wanted.contains("kidnap") || wanted.contains("covered")) {
    BenchKidnaps(arguments, wanted, cache, &report);
  }
  if (wanted.contains("twins")) report["twins"] = BenchTwins(arguments, cache);
  if (arguments.json) {
    report["versions"] = apps::VersionsJson();
    fmt::print("{}\n", apps::JsonText(report, 2));
    return;
  }
  for (auto& [part, figures] : report.items()) {
    figures.erase("runs");  // one line per part
    fmt::print("{}: {}\n", part, apps::JsonText(figures));
  }
}

void AddOptions(CLI::App& app, Arguments& arguments) {
  AddList(app, "--parts", arguments.parts, {"kidnap", "covered", "twins"});
  app.add_option("--seeds", arguments.seeds, "Walks of each kind")
      ->check(apps::Between(1.0, 1000.0))
      ->capture_default_str();
  app.add_option("--first-seed", arguments.first_seed, "The first of them")
      ->check(apps::Between(1.0, 1e6))
      ->capture_default_str();
  app.add_option("--fps", arguments.fps, "Frames per second")
      ->check(apps::Between(1.0, 240.0))
      ->capture_default_str();
  app.add_option("--scale", arguments.scale, "Of the image, 1 = 640 x 480")
      ->check(apps::Between(0.1, 2.0))
      ->capture_default_str();
  app.add_option("--cache", arguments.cache,
                 "Keep the sequences in this folder and use those that are there; empty it when "
                 "the simulator has changed");
  app.add_flag("--json", arguments.json, "Print one JSON object");
  app.footer(
      "Example: highwall_bench_relocation --parts kidnap --fps 15 --scale 0.5 --cache walks");
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  using namespace highwall::bench;
  const BenchName name{
      "highwall_bench_relocation",
      "Kidnapped, covered and misled cameras, on generated walks with exact truth."};
  return RunBench<Arguments>(name, argc, argv, AddOptions, Bench);
}
