#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include <faiss/IndexBinaryFlat.h>
#include <faiss/IndexBinaryHash.h>
#include <faiss/IndexBinaryIVF.h>
#include <omp.h>
#include <nlohmann/json.hpp>

#include "bench_loops.h"

namespace highwall::bench {
namespace {

nlohmann::json BenchBinary(const std::string& name, faiss::IndexBinary* index,
                           const DescriptorSet& set, const std::vector<Query>& queries,
                           int copies) {
  const auto fill = [&] {
    if (!index->is_trained) {
      index->train(std::min(set.descriptors.rows, 50'000), set.descriptors.data);
    }
    index->add(set.descriptors.rows, set.descriptors.data);
  };
  const auto answer = [&](const Query& query) {
    constexpr int kNeighbours = 10;
    const cv::Mat& descriptors = query.features->point_descriptors;
    const auto count = static_cast<std::size_t>(descriptors.rows);
    std::vector<std::int32_t> distances(count * kNeighbours);
    std::vector<faiss::IndexBinary::idx_t> rows(count * kNeighbours);
    index->search(descriptors.rows, descriptors.data, kNeighbours, distances.data(), rows.data());
    std::vector<std::vector<int>> neighbours(count);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      neighbours[i / kNeighbours].push_back(static_cast<int>(rows[i]));
    }
    return BestKeyFrame(set, neighbours);
  };
  return BenchOne(name, queries, copies, fill, answer);
}

}  // namespace

std::vector<nlohmann::json> BenchFaiss(const DescriptorSet& set, const std::vector<Query>& queries,
                                       int copies) {
  omp_set_num_threads(1);
  std::vector<nlohmann::json> entries;
  faiss::IndexBinaryMultiHash multi(256, 4, 16);
  entries.push_back(BenchBinary("faiss IndexBinaryMultiHash", &multi, set, queries, copies));
  faiss::IndexBinaryFlat centres(256);
  faiss::IndexBinaryIVF inverted(&centres, 256, 4096);
  inverted.nprobe = 1;
  entries.push_back(BenchBinary("faiss IndexBinaryIVF", &inverted, set, queries, copies));
  return entries;
}

}  // namespace highwall::bench
