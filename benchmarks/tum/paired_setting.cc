#include "paired_setting.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/core/error.h>
#include <highwall/frontend/input/tum_dataset.h>
#include <highwall/internal/number_text.h>

#include "cache_folder.h"
#include "cli/classic_locale.h"
#include "cli/progress.h"
#include "run/slam_arguments.h"

namespace highwall::bench {
namespace {

// Splits at blanks outside of "double quotes".
std::vector<std::string> Words(const std::string& setting) {
  TextReader text(setting);
  std::vector<std::string> words;
  for (std::string word; text >> std::quoted(word);) words.push_back(word);
  return words;
}

std::vector<std::string> CommandLine(const std::string& dataset, const std::string& out,
                                     const std::vector<std::string>& switches,
                                     const SettingMode& mode = {}) {
  std::vector<std::string> words{"--dataset", dataset, "--out", out};
  if (mode.synchronous) words.push_back("--deterministic");
  if (mode.live_rate > 0.0) words.push_back("--live");
  if (mode.map == MapChoice::kNone) words.push_back("--no-map");
  words.insert(words.end(), switches.begin(), switches.end());
  return words;
}

apps::SlamArguments ParseSetting(const std::string& setting, const std::string& dataset,
                                 const SettingMode& mode) {
  const apps::ClassicLocale classic;
  apps::SlamArguments arguments;
  CLI::App app;
  apps::AddSlamOptions(&app, &arguments);
  std::vector<std::string> words = CommandLine(dataset, "nowhere", Words(setting), mode);
  std::ranges::reverse(words);  // the order that CLI11 expects
  app.parse(std::move(words));
  CheckArguments(arguments);
  return arguments;
}

struct Outcome {
  int exit_code = 0;
  std::string message;  // the last line on standard error
};

std::string LastLine(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

// Waits for the program; its output goes to files in `scratch`.
Outcome RunProgram(const std::string& program, std::vector<std::string> words,
                   const std::filesystem::path& scratch) {
  words.insert(words.begin(), program);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::filesystem::path out = scratch / "stdout", err = scratch / "stderr";
  constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_t streams;
  ::posix_spawn_file_actions_init(&streams);
  ::posix_spawn_file_actions_addopen(&streams, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&streams, STDOUT_FILENO, out.c_str(), kWrite, 0600);
  ::posix_spawn_file_actions_addopen(&streams, STDERR_FILENO, err.c_str(), kWrite, 0600);
  pid_t process = 0;
  const int error =
      ::posix_spawnp(&process, program.c_str(), &streams, nullptr, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&streams);
  if (error != 0) {
    throw IoError(program, "cannot be run: " + std::generic_category().message(error));
  }
  int status = 0;
  while (::waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) throw std::runtime_error("the end of " + program + " was missed");
  }
  if (!WIFEXITED(status)) throw std::runtime_error(program + " was ended by a signal");
  return {WEXITSTATUS(status), LastLine(err)};
}

std::filesystem::path OutOf(const CacheFolder& scratch) {
  return scratch.path() / "out";
}

Outcome RunSlamOf(const std::string& program, const std::filesystem::path& dataset,
                  const std::vector<std::string>& switches, const CacheFolder& scratch) {
  std::vector<std::string> words = CommandLine(dataset.string(), OutOf(scratch).string(), switches);
  words.insert(words.begin(), "slam");
  return RunProgram(program, std::move(words), scratch.path());
}

SettingRun ReadRun(const std::filesystem::path& folder) {
  const std::filesystem::path adjusted = folder / "trajectory_adjusted.txt";
  const auto report = nlohmann::json::parse(std::ifstream(folder / "run.json"));
  return {ReadTumTrajectory(exists(adjusted) ? adjusted : folder / "trajectory.txt"),
          report.at("lost_frames").get<std::size_t>(),
          report.at("milliseconds").at("frame").at("median").get<double>(),
          {}};
}

// Copies a list of images: comments, and the entries in `kept`, which ascend.
void CopyList(const std::filesystem::path& from, const std::vector<std::size_t>& kept,
              const std::filesystem::path& to) {
  std::ifstream list(from);
  std::ofstream rest(to);
  std::size_t entry = 0;
  for (std::string line; std::getline(list, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos) continue;
    if (line[first] == '#' || std::ranges::binary_search(kept, entry++)) rest << line << '\n';
  }
  rest.close();
  if (!rest) throw IoError(to, "cannot be written");
}

}  // namespace

std::string ToString(MapChoice map) {
  switch (map) {
    case MapChoice::kNone:
      return "none";
    case MapChoice::kDefault:
      return "default";
    case MapChoice::kPaper:
      return "paper";
  }
  return "unknown";
}

OwnSetting::OwnSetting(const std::string& setting, const std::filesystem::path& directory,
                       const SettingMode& mode) {
  const apps::SlamArguments arguments = ParseSetting(setting, directory.string(), mode);
  dataset_ = apps::OpenWithConfig(arguments.config, directory);
  options_ = apps::MakeOptions(arguments);
  if (mode.live_rate > 0.0) options_.live_rate = mode.live_rate;
  constexpr double kPaperRange = 3.0;  // [m] section 4.1 of the paper
  if (mode.map == MapChoice::kPaper) {
    options_.map.cloud.max_depth = options_.map.octree.max_range = kPaperRange;
  }
  std::vector<std::string> warnings = dataset_.images->warnings();
  options_.imu = apps::ReadImuFeed(arguments, dataset_, &warnings, &options_.before);
  options_.gps = apps::ReadGpsFeed(arguments, dataset_, options_.imu.has_value());
  for (const std::string& warning : warnings) fmt::print(stderr, "warning: {}\n", warning);
}

apps::SlamRun OwnSetting::RunWhole(std::size_t begin, const std::string& label,
                                   const std::function<bool()>& stop) const {
  apps::SlamRunOptions options = options_;
  options.stop = stop;
  options.begin = begin;
  apps::Progress progress(label);
  apps::SlamRun run =
      apps::RunSlam(*dataset_.images, dataset_.config.sensor, options,
                    {.on_frame = [&](const FrameResult&, const RgbdImage&, std::size_t done,
                                     std::size_t total) { progress.Update(done, total); }});
  apps::RequireWhole(run);
  return run;
}

SettingRun OwnSetting::Run(std::size_t begin, const std::string& label) const {
  apps::SlamRun run = RunWhole(begin, label);
  apps::SubmapRun& map = run.largest;
  return {std::move(map.adjusted.empty() ? map.trajectory : map.adjusted),
          run.lost.size(),
          run.times.frame.median,
          {}};
}

ProgramSetting::ProgramSetting(std::string program, const std::string& setting,
                               std::filesystem::path directory)
    : program_(std::move(program)), switches_(Words(setting)), directory_(std::move(directory)) {
  const Stamp tolerance = FromSeconds(DatasetOptions().max_stamp_difference);
  for (const auto& [colour, depth] :
       AssociateNearest(ReadTumImageList(directory_ / "rgb.txt"),
                        ReadTumImageList(directory_ / "depth.txt"), tolerance)) {
    colour_.push_back(colour);
    depth_.push_back(depth);
  }
  RequireKnown();
}

// Without a dataset the program does nothing but parse its command line.
void ProgramSetting::RequireKnown() const {
  const CacheFolder scratch("", "highwall_bench_tum");
  const Outcome outcome = RunSlamOf(program_, scratch.path() / "nowhere", switches_, scratch);
  constexpr int kWrongUsage = 1;
  if (outcome.exit_code == kWrongUsage) throw IoError(program_, "says: " + outcome.message);
}

SettingRun ProgramSetting::Run(std::size_t begin, const std::string& label) const {
  apps::Progress progress(label);
  progress.Update(0);
  const CacheFolder scratch("", "highwall_bench_tum");
  // The name may determine the calibration.
  const std::filesystem::path dataset =
      scratch.path() / "dataset" /
      std::filesystem::absolute(directory_ / ".").parent_path().filename();
  WriteRest(begin, dataset);
  const Outcome outcome = RunSlamOf(program_, dataset, switches_, scratch);
  constexpr int kUnusableData = 2;  // e.g. no frame could be tracked
  if (outcome.exit_code == kUnusableData) return {{}, colour_.size() - begin, 0.0, outcome.message};
  if (outcome.exit_code != 0) {
    throw std::runtime_error(
        fmt::format("{}: exit code {}: {}", program_, outcome.exit_code, outcome.message));
  }
  return ReadRun(OutOf(scratch));
}

void ProgramSetting::WriteRest(std::size_t begin, const std::filesystem::path& folder) const {
  std::filesystem::create_directories(folder);
  for (const auto& entry : std::filesystem::directory_iterator(directory_)) {
    const std::filesystem::path name = entry.path().filename();
    if (name == "rgb.txt" || name == "depth.txt") continue;
    std::filesystem::create_symlink(std::filesystem::absolute(entry.path()), folder / name);
  }
  const auto rest = [begin](const std::vector<std::size_t>& entries) {
    std::vector<std::size_t> kept(
        std::next(entries.begin(), static_cast<std::ptrdiff_t>(std::min(begin, entries.size()))),
        entries.end());
    std::ranges::sort(kept);
    return kept;
  };
  CopyList(directory_ / "rgb.txt", rest(colour_), folder / "rgb.txt");
  CopyList(directory_ / "depth.txt", rest(depth_), folder / "depth.txt");
}

void RequireSetting(const std::string& name, const std::string& setting, const SettingMode& mode) {
  const std::string which = fmt::format("setting {}, '{}'", name, setting);
  try {
    ParseSetting(setting, "anywhere", mode);
  } catch (const CLI::Success&) {  // --help
    throw CLI::ValidationError(which, "asks for help");
  } catch (const CLI::ParseError& error) {
    throw CLI::ValidationError(which, error.what());
  }
}

}  // namespace highwall::bench
