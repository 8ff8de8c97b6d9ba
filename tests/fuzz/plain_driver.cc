// Replaces libFuzzer if the compiler has none: PROGRAM [-max_total_time=S] [-runs=N] [-seed=N]
// FOLDER... mutates the files of the folders at random and reads the result; PROGRAM FILE... reads
// the files.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "fuzz.h"

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv);
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  std::string Change(std::string bytes, const std::vector<std::string>& others) {
    for (std::size_t n = 1 + Below(6); n > 0; --n) ChangeOnce(bytes, others);
    return bytes;
  }
  std::size_t Below(std::size_t bound) { return random_() % bound; }

 private:
  void ChangeOnce(std::string& bytes, const std::vector<std::string>& others) {
    // Numbers that are critical for readers, as text and as bytes.
    static const std::array<std::string, 14> kTexts = {
        "0",          "-1",  "1e999", "-1e-999", "nan", "inf", "9223372036854775807",
        "4294967296", "1e9", "\n",    "\r\n",    " ",   "#",   std::string(8, '\xff')};
    const std::size_t at = Below(bytes.size() + 1);
    const std::size_t length = std::min(bytes.size() - at, 1 + Below(16));
    switch (Below(6)) {
      case 0:
        if (at < bytes.size()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << Below(8)));
        break;
      case 1:
        if (at < bytes.size()) bytes[at] = static_cast<char>(Below(256));
        break;
      case 2:
        bytes.erase(at, length);
        break;
      case 3:
        bytes.insert(Below(bytes.size() + 1), bytes.substr(at, length));
        break;
      case 4:
        bytes.replace(at, length, kTexts[Below(kTexts.size())]);
        break;
      default: {
        const std::string& other = others[Below(others.size())];
        bytes = bytes.substr(0, at) + other.substr(Below(other.size() + 1));
      }
    }
  }

  std::mt19937 random_;
};

void Run(const std::string& bytes) {
  try {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  } catch (const std::exception& e) {
    const std::string finding = "crash-" + std::to_string(getpid());
    std::ofstream(finding, std::ios::binary) << bytes;
    std::fprintf(stderr, "%s: %s\n", finding.c_str(), e.what());
    std::exit(1);
  }
}

double NumberAfter(const std::string& argument) {
  return std::stod(argument.substr(argument.find('=') + 1));
}

}  // namespace

int main(int argc, char** argv) {
  LLVMFuzzerInitialize(&argc, &argv);
  std::vector<std::string> seeds;
  double seconds = 0.0;
  std::int64_t most_runs = 0;
  unsigned seed = 1;
  for (const std::string& argument : std::vector<std::string>(argv + 1, argv + argc)) {
    if (argument.starts_with("-max_total_time=")) seconds = NumberAfter(argument);
    if (argument.starts_with("-runs=")) {
      most_runs = static_cast<std::int64_t>(NumberAfter(argument));
    }
    if (argument.starts_with("-seed=")) seed = static_cast<unsigned>(NumberAfter(argument));
    if (argument.starts_with("-")) continue;
    if (!std::filesystem::is_directory(argument)) {
      Run(highwall::fuzz::ReadBytes(argument));
      continue;
    }
    for (const auto& file : std::filesystem::directory_iterator(argument)) {
      seeds.push_back(highwall::fuzz::ReadBytes(file.path()));
    }
  }
  if (seeds.empty()) return 0;
  std::sort(seeds.begin(), seeds.end());
  Mutator mutator(seed);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  std::int64_t runs = 0;
  for (; runs < most_runs || std::chrono::steady_clock::now() < end; ++runs) {
    Run(mutator.Change(seeds[mutator.Below(seeds.size())], seeds));
  }
  std::fprintf(stderr, "stat::number_of_executed_units: %lld\n", static_cast<long long>(runs));
}
