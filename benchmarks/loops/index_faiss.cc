#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include <faiss/IndexBinaryFlat.h>
#include <faiss/IndexBinaryHash.h>
#include <faiss/IndexBinaryIVF.h>
#include <fmt/core.h>
#include <omp.h>
#include <nlohmann/json.hpp>

#include "bench_loops.h"

namespace highwall::bench {
namespace {

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

nlohmann::json BenchOne(const std::string& name, faiss::IndexBinary* index,
                        const DescriptorSet& set, const std::vector<Query>& queries, int copies) {
  constexpr int kNeighbours = 10;
  const auto build = Clock::now();
  if (!index->is_trained) {
    index->train(std::min(set.descriptors.rows, 50'000), set.descriptors.data);
  }
  index->add(set.descriptors.rows, set.descriptors.data);
  const double build_ms = MillisecondsSince(build);
  int right = 0;
  double total = 0.0, worst = 0.0;
  for (const Query& query : queries) {
    const cv::Mat& descriptors = query.features->point_descriptors;
    const auto count = static_cast<std::size_t>(descriptors.rows);
    std::vector<std::int32_t> distances(count * kNeighbours);
    std::vector<faiss::IndexBinary::idx_t> rows(count * kNeighbours);
    const auto start = Clock::now();
    index->search(descriptors.rows, descriptors.data, kNeighbours, distances.data(), rows.data());
    std::vector<std::vector<int>> neighbours(count);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      neighbours[i / kNeighbours].push_back(static_cast<int>(rows[i]));
    }
    const int best = BestKeyFrame(set, neighbours);
    const double ms = MillisecondsSince(start);
    total += ms;
    worst = std::max(worst, ms);
    right += best >= 0 && best / copies == query.place ? 1 : 0;
  }
  const auto n = static_cast<double>(queries.size());
  fmt::print(stderr, "{:<28} right {:.3f}, query {:.2f} ms, at worst {:.2f} ms, build {:.0f} ms\n",
             name, right / n, total / n, worst, build_ms);
  return {{"index", name},
          {"right", right / n},
          {"query_ms", total / n},
          {"worst_query_ms", worst},
          {"build_ms", build_ms}};
}

}  // namespace

std::vector<nlohmann::json> BenchFaiss(const DescriptorSet& set, const std::vector<Query>& queries,
                                       int copies) {
  omp_set_num_threads(1);
  std::vector<nlohmann::json> entries;
  faiss::IndexBinaryMultiHash multi(256, 4, 16);
  entries.push_back(BenchOne("faiss IndexBinaryMultiHash", &multi, set, queries, copies));
  faiss::IndexBinaryFlat centres(256);
  faiss::IndexBinaryIVF inverted(&centres, 256, 4096);
  inverted.nprobe = 1;
  entries.push_back(BenchOne("faiss IndexBinaryIVF", &inverted, set, queries, copies));
  return entries;
}

}  // namespace highwall::bench
