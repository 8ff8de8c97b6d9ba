// Runs `highwall slam` on datasets with seeded faults of readings and images: no output is lost,
// and each fault is reported once. HIGHWALL_FAULT_RUNS=1000 tests a thousand seeds.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <highwall/core/trajectory.h>

#include "simulate/output/imu_files.h"
#include "simulate/output/tum_writer.h"
#include "simulate/scenes/room.h"
#include "support/faulty_readings.h"
#include "support/run_program.h"
#include "support/test_paths.h"

namespace highwall::slam_faults_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::Contains;
using testing::Fault;
using testing::Outcome;
using testing::ReadText;
using testing::TemporaryDirectory;
using testing::Uniform;
using testing::WriteText;

constexpr int kFrames = 14;

simulate::Simulation MakeWalk() {
  simulate::SimulationOptions options;
  options.camera = {
      .width = 160, .height = 120, .fx = 131.25, .fy = 131.25, .cx = 79.5, .cy = 59.5};
  options.fps = 6.0;
  options.duration = kFrames / options.fps;
  return simulate::SimulateRoom(options);
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// Damages or removes an image file.
void SpoilFile(std::mt19937& rng, const fs::path& file) {
  std::string bytes = ReadText(file);
  switch (Uniform(rng, 0, 3)) {
    case 0:
      fs::remove(file);
      return;
    case 1:
      bytes.resize(static_cast<std::size_t>(Uniform(rng, 0, static_cast<int>(bytes.size()) - 1)));
      break;
    case 2:
      bytes.clear();
      break;
    case 3:
      bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x5a);
      break;
  }
  fs::remove(file);
  WriteText(file, bytes);
}

int LinesWith(const std::vector<std::string>& lines, const std::string& part) {
  return static_cast<int>(std::count_if(
      lines.begin(), lines.end(), [&](const std::string& line) { return Contains(line, part); }));
}

// Expects that each fault of the readings is reported once, and no fault that is absent.
void ExpectSaidOnce(const std::vector<ImuSample>& readings, const std::vector<std::string>& said) {
  bool not_finite = false, impossible = false, back = false, twice = false;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    not_finite |= !IsFinite(readings[i]);
    impossible |= IsFinite(readings[i]) && !IsPossible(readings[i]);
    if (i == 0) continue;
    back |= readings[i].stamp < readings[i - 1].stamp;
    twice |= readings[i].stamp == readings[i - 1].stamp && IsFinite(readings[i]) &&
             IsFinite(readings[i - 1]);
  }
  EXPECT_EQ(LinesWith(said, "NaN or infinite"), not_finite ? 1 : 0);
  EXPECT_EQ(LinesWith(said, "beyond what any sensor measures"), impossible ? 1 : 0);
  EXPECT_EQ(LinesWith(said, "smaller than the one before"), back ? 1 : 0);
  EXPECT_EQ(LinesWith(said, "are there twice"), twice ? 1 : 0);
  EXPECT_LE(LinesWith(said, "is frozen"), 2);  // of either sensor
  EXPECT_LE(LinesWith(said, " gap"), 1);
}

TEST(SlamProgramFaults, LoseNoOutputAndAreSaidOnce) {
  const TemporaryDirectory folder;
  const simulate::Simulation walk = MakeWalk();
  const fs::path sequence = folder / "sequence", dataset = folder / "dataset", run = folder / "run";
  simulate::WriteTum(walk, sequence);
  for (int seed = 0; seed < testing::FaultRuns(8); ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 rng(static_cast<unsigned>(seed));
    fs::remove_all(dataset);
    fs::remove_all(run);
    fs::copy(sequence, dataset, fs::copy_options::recursive);
    std::vector<ImuSample> readings = walk.ImuSamples();
    testing::InjectSome(rng, readings);
    WriteText(dataset / "imu.csv", simulate::ImuCsv(readings));
    std::set<int> spoilt;
    for (int i = 0, end = Uniform(rng, 0, 3); i < end; ++i) spoilt.insert(Uniform(rng, 1, 13));
    for (const int i : spoilt) {
      SpoilFile(rng, dataset / (Uniform(rng, 0, 1) == 0 ? "rgb" : "depth") /
                         (FormatStamp(walk.StampOf(i)) + ".png"));
    }

    const Outcome outcome = testing::RunProgram(
        testing::kHighwallProgram, "slam --dataset " + dataset.string() + " --out " + run.string() +
                                       " --no-map --deterministic --json");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const char* name : {"trajectory.txt", "trajectory_causal.txt", "keyframes.txt"}) {
      EXPECT_FALSE(ReadTumTrajectory(run / name).empty()) << name;
    }
    const json report = json::parse(ReadText(run / "run.json"));
    EXPECT_EQ(report["frames"].get<int>() + report["skipped_frames"].get<int>(), kFrames);
    EXPECT_EQ(report["skipped_frames"], spoilt.size());
    const std::vector<std::string> said = Lines(outcome.err);
    EXPECT_EQ(std::set<std::string>(said.begin(), said.end()).size(), said.size()) << outcome.err;
    EXPECT_EQ(LinesWith(said, "skipped frame"), static_cast<int>(spoilt.size())) << outcome.err;
    ExpectSaidOnce(readings, said);
  }
}

}  // namespace
}  // namespace highwall::slam_faults_test
