// Counts the memory allocations of SlamSystem::Track() on its own thread, frame by frame. The
// allocation functions of the C library are replaced in this program, so that allocations of all
// libraries are counted, those of OpenCV and Ceres included.
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <fmt/core.h>
#include <CLI/App.hpp>

#include <highwall/frontend/input/open_dataset.h>
#include <highwall/frontend/system/slam_system.h>

#include "bench_main.h"
#include "run/config.h"
#include "run/slam_arguments.h"

namespace highwall::bench {
namespace {

// An allocation of at least this size is that of an image or of one of its pyramid levels.
constexpr std::size_t kImageBytes = 16 * 1024;

struct Allocations {
  std::uint64_t small = 0, images = 0;
};
constinit thread_local Allocations allocations;

void Count(std::size_t bytes) {
  ++(bytes < kImageBytes ? allocations.small : allocations.images);
}

}  // namespace
}  // namespace highwall::bench

// The replacements call what glibc exports under these names.
extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* old, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);

void* malloc(std::size_t bytes) {
  highwall::bench::Count(bytes);
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
  highwall::bench::Count(count * bytes);
  return __libc_calloc(count, bytes);
}
void* realloc(void* old, std::size_t bytes) {
  highwall::bench::Count(bytes);
  return __libc_realloc(old, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) {
  highwall::bench::Count(bytes);
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
  return memalign(alignment, bytes);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) {
  *memory = memalign(alignment, bytes);
  return *memory != nullptr ? 0 : ENOMEM;
}
}

namespace highwall::bench {
namespace {

std::uint64_t Percentile(std::vector<std::uint64_t> counts, double share) {
  if (counts.empty()) return 0;
  std::ranges::sort(counts);
  return counts[static_cast<std::size_t>(share * static_cast<double>(counts.size() - 1))];
}

void Print(const char* frames, const std::vector<Allocations>& counted) {
  std::vector<std::uint64_t> small, images;
  for (const Allocations& frame : counted) {
    small.push_back(frame.small);
    images.push_back(frame.images);
  }
  fmt::print("{:22} {:6} {:8} {:8} {:8} {:8}\n", frames, counted.size(), Percentile(small, 0.5),
             Percentile(small, 0.95), Percentile(small, 1.0), Percentile(images, 0.5));
}

void Run(const apps::SlamArguments& arguments) {
  const apps::ResolvedConfig config = apps::ResolveConfig(arguments.config, arguments.dataset);
  const RgbdSensor& sensor = config.config.sensor;
  const std::unique_ptr<const Dataset> dataset = OpenDataset(arguments.dataset, sensor);
  SlamSystem system(sensor, apps::MakeOptions(arguments).slam);
  std::vector<Allocations> tracked, keyframes;
  for (std::size_t i = 0; i < dataset->size(); ++i) {
    const std::optional<RgbdImage> image = dataset->Load(i);
    if (!image) continue;
    const Allocations before = allocations;
    const FrameResult result = system.Track(*image);
    const Allocations frame{allocations.small - before.small, allocations.images - before.images};
    (result.mapping ? keyframes : tracked).push_back(frame);
  }
  system.Finish();
  fmt::print("{:22} {:>6} {:>8} {:>8} {:>8} {:>8}\n", "", "number", "median", "95 %", "most",
             "images");
  Print("frames", tracked);
  Print("keyframes", keyframes);
}

}  // namespace
}  // namespace highwall::bench

int main(int argc, char** argv) {
  highwall::apps::SlamArguments arguments;
  return highwall::bench::RunBench(
      {"highwall_bench_allocations",
       "Memory allocations of a frame on the thread that tracks, from images alone; \"images\" is\n"
       "the median number of those of at least 16 KiB, which are left out of the others.\n"
       "Example: highwall_bench_allocations --dataset fr1_xyz --config tum1"},
      argc, argv,
      [&](CLI::App& app) {
        highwall::apps::AddSlamOptions(&app, &arguments);
        app.get_option("--out")->required(false);
      },
      [&] { highwall::bench::Run(arguments); });
}
