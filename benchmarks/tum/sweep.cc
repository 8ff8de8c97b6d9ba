#include "sweep.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <iterator>
#include <utility>

#include <fmt/core.h>

#include <highwall/core/error.h>

#include "cli/progress.h"
#include "sweep_run.h"

namespace highwall::bench {
namespace {

// A folder of images, created on demand.
struct Source {
  std::string name;
  int seed = 0;
  std::filesystem::path folder;
  std::optional<SequenceOptions> generated;
};

// Returns the folders of each row of the tables.
std::vector<std::vector<Source>> SourcesOf(const SweepPlan& plan) {
  std::vector<std::vector<Source>> rows;
  for (const std::string& sequence : plan.sequences) {
    rows.push_back({{sequence, 0, plan.data / sequence, {}}});
  }
  for (SequenceOptions scene : plan.scenes) {
    std::vector<Source>& row = rows.emplace_back();
    for (int seed = 1; seed <= plan.seeds; ++seed) {
      scene.seed = static_cast<std::uint64_t>(seed);
      row.push_back({NameOf(scene), seed, FolderOf(scene, plan.data), scene});
    }
  }
  return rows;
}

void MakeImages(const Source& source, const std::filesystem::path& data) {
  if (!source.generated || std::filesystem::exists(source.folder)) return;
  apps::Progress progress(fmt::format("{} seed {}: rendering", source.name, source.seed));
  MakeSequence(*source.generated, data, [&progress](int done, int total) {
    progress.Update(static_cast<std::size_t>(done), static_cast<std::size_t>(total));
  });
}

std::string ModeText(const RunKey& key) {
  if (key.live_rate > 0.0) return fmt::format(" live at {:g} times the pace", key.live_rate);
  return key.synchronous ? " in synchronous mode" : "";
}

// Returns the run that an earlier process stored.
std::optional<RunRecord> KeptRun(const SweepPlan& plan, const RunKey& key) {
  if (plan.out.empty()) return std::nullopt;
  const std::filesystem::path file = RecordFile(plan.out, key);
  if (!std::filesystem::exists(file)) return std::nullopt;
  RunRecord record = ReadRecord(file);
  const RunKey& kept = record.key;
  if (kept.setting.switches != key.setting.switches || kept.synchronous != key.synchronous ||
      kept.setting.map != key.setting.map || kept.live_rate != key.live_rate) {
    throw IoError(file,
                  fmt::format("is of '{}'{}, map: {}; remove it or choose another --out",
                              kept.setting.switches, ModeText(kept), ToString(kept.setting.map)));
  }
  return record;
}

// Returns an empty result if the sweep is stopped.
std::optional<RunRecord> RunOrRead(const SweepPlan& plan, const Source& source, const RunKey& key) {
  if (plan.stop && plan.stop()) return std::nullopt;
  if (std::optional<RunRecord> kept = KeptRun(plan, key)) return kept;
  MakeImages(source, plan.data);
  std::optional<RunRecord> record = RunOnce(source.folder, key, plan.stop);
  if (record && !plan.out.empty()) WriteRecord(plan.out, *record);
  return record;
}

}  // namespace

Shard ParseShard(const std::string& text) {
  const char* const end = text.data() + text.size();
  Shard shard;
  const auto number = std::from_chars(text.data(), end, shard.number);
  const bool divided = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto count = std::from_chars(divided ? number.ptr + 1 : end, end, shard.count);
  HIGHWALL_REQUIRE(divided && count.ec == std::errc() && count.ptr == end && shard.number >= 1 &&
                       shard.number <= shard.count,
                   "a shard is NUMBER/COUNT, such as 2/4, not " + text);
  return shard;
}

std::vector<RunRecord> RunSweep(const SweepPlan& plan, const GroupCallback& on_group) {
  std::vector<RunRecord> records;
  std::size_t count = 0;
  for (const std::vector<Source>& row : SourcesOf(plan)) {
    for (const NamedSetting& setting : plan.settings) {
      std::vector<RunRecord> group;
      for (const Source& source : row) {
        for (int run = 1; run <= plan.runs; ++run) {
          if (count++ % plan.shard.count != plan.shard.number - 1) continue;
          std::optional<RunRecord> record =
              RunOrRead(plan, source,
                        {source.name, source.seed, setting, run, plan.synchronous, plan.live_rate});
          if (record) group.push_back(*std::move(record));
        }
      }
      if (on_group && !group.empty()) on_group(group);
      std::ranges::move(group, std::back_inserter(records));
    }
  }
  return records;
}

}  // namespace highwall::bench
