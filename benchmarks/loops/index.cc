#include <algorithm>
#include <map>
#include <random>

#include <fmt/core.h>
#include <simulate/scenes/room.h>
#include <nlohmann/json.hpp>
#include <opencv2/flann/miniflann.hpp>

#include <highwall/frontend/map/keyframe_index.h>

#include "bench_loops.h"
#include "features/frame_builder.h"
#include "timing.h"

namespace highwall::bench {
namespace {

// Returns features of rendered images of generated rooms, ten views per room.
std::vector<std::shared_ptr<const FrameFeatures>> Places(int count) {
  constexpr int kViews = 10;
  std::vector<std::shared_ptr<const FrameFeatures>> places;
  for (int seed = 1; static_cast<int>(places.size()) < count; ++seed) {
    simulate::SimulationOptions options;
    options.seed = static_cast<std::uint64_t>(seed);
    options.duration = 20.0;
    options.fps = kViews / options.duration;
    const simulate::Simulation room = simulate::SimulateRoom(options);
    FrameBuilder builder({.camera = options.camera}, {});
    for (int i = 0; i < kViews && static_cast<int>(places.size()) < count; ++i) {
      const auto frame = room.Render(i);
      places.push_back(builder.Build({frame.stamp, frame.bgr, frame.depth}));
    }
  }
  return places;
}

// Simulates the descriptors of another view of the place: a third are replaced by those of other
// corners, drawn from `pool`; a fifteenth of the bits is flipped, so that two views differ in an
// eighth of them: 32 bits, as for matches of ORB and LBD.
cv::Mat SeenAgain(const cv::Mat& descriptors, const cv::Mat& pool, std::mt19937* rng) {
  cv::Mat again = descriptors.clone();
  for (int i = 0; i < again.rows; ++i) {
    if ((*rng)() % 3 == 0) {
      pool.row(static_cast<int>((*rng)() % static_cast<unsigned>(pool.rows))).copyTo(again.row(i));
    }
    for (int bit = 0; bit < 256; ++bit) {
      if ((*rng)() % 15 != 0) continue;
      again.at<std::uint8_t>(i, bit / 8) ^= static_cast<std::uint8_t>(1U << (bit % 8));
    }
  }
  return again;
}

// Descriptors of all places.
struct Pool {
  cv::Mat points, lines;
};

std::shared_ptr<const FrameFeatures> SeenAgain(const FrameFeatures& place, const Pool& pool,
                                               std::mt19937* rng) {
  auto again = std::make_shared<FrameFeatures>();
  again->point_descriptors = SeenAgain(place.point_descriptors, pool.points, rng);
  again->line_descriptors = SeenAgain(place.line_descriptors, pool.lines, rng);
  return again;
}

nlohmann::json BenchOurs(const DescriptorSet& set, const std::vector<Query>& queries, int copies,
                         bool lines) {
  const auto used = [lines](const FrameFeatures& all) {
    FrameFeatures features = all;
    if (!lines) features.line_descriptors = cv::Mat();
    return features;
  };
  KeyFrameIndex index;
  const auto fill = [&] {
    for (std::size_t k = 0; k < set.keyframes.size(); ++k) {
      index.Add(KeyFrameId(k), used(*set.keyframes[k]));
    }
  };
  const auto answer = [&](const Query& query) {
    const auto places = index.Query(used(*query.features));
    return places.empty() ? -1 : places[0].keyframe.value();
  };
  return BenchOne(lines ? "Highwall, points and lines" : "Highwall, points", queries, copies, fill,
                  answer);
}

nlohmann::json BenchFlann(const DescriptorSet& set, const std::vector<Query>& queries, int copies) {
  cv::flann::Index index;
  const auto fill = [&] {
    index.build(set.descriptors, cv::flann::LshIndexParams(4, 20, 0), cvflann::FLANN_DIST_HAMMING);
  };
  const auto answer = [&](const Query& query) {
    constexpr int kNeighbours = 10;
    cv::Mat rows, distances;
    index.knnSearch(query.features->point_descriptors, rows, distances, kNeighbours);
    std::vector<std::vector<int>> neighbours;
    for (int i = 0; i < rows.rows; ++i) {
      neighbours.emplace_back(rows.ptr<int>(i), rows.ptr<int>(i) + rows.cols);
    }
    return BestKeyFrame(set, neighbours);
  };
  return BenchOne("OpenCV FLANN LSH", queries, copies, fill, answer);
}

}  // namespace

nlohmann::json BenchOne(const std::string& name, const std::vector<Query>& queries, int copies,
                        const std::function<void()>& fill,
                        const std::function<int(const Query&)>& answer) {
  const double fill_ms = 1e3 * WallSeconds(fill);
  int right = 0;
  double total_ms = 0.0, worst_ms = 0.0;
  for (const Query& query : queries) {
    int keyframe = -1;
    const double ms = 1e3 * WallSeconds([&] { keyframe = answer(query); });
    total_ms += ms;
    worst_ms = std::max(worst_ms, ms);
    right += keyframe >= 0 && keyframe / copies == query.place ? 1 : 0;
  }
  const auto count = static_cast<double>(queries.size());
  const double recall = right / count, query_ms = total_ms / count;
  fmt::print(stderr, "{:<28} right {:.3f}, query {:.2f} ms, at worst {:.2f} ms, build {:.0f} ms\n",
             name, recall, query_ms, worst_ms, fill_ms);
  return {{"index", name},
          {"right", recall},
          {"query_ms", query_ms},
          {"worst_query_ms", worst_ms},
          {"build_ms", fill_ms}};
}

int BestKeyFrame(const DescriptorSet& set, const std::vector<std::vector<int>>& neighbours) {
  std::map<int, int> votes;
  for (const auto& rows : neighbours) {
    for (const int row : rows) {
      if (row >= 0 && row < set.descriptors.rows)
        ++votes[set.keyframe_of[static_cast<std::size_t>(row)]];
    }
  }
  const auto best = std::max_element(
      votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return best == votes.end() ? -1 : best->first;
}

nlohmann::json BenchIndex(int keyframes) {
  constexpr int kCopies = 10, kQueries = 100;
  const auto places = Places(std::max(2, keyframes / kCopies));
  std::mt19937 rng(1);
  DescriptorSet set;
  std::vector<cv::Mat> rows;
  Pool pool;
  for (const auto& place : places) {
    pool.points.push_back(place->point_descriptors);
    pool.lines.push_back(place->line_descriptors);
  }
  for (std::size_t p = 0; p < places.size(); ++p) {
    for (int copy = 0; copy < kCopies; ++copy) {
      set.keyframes.push_back(SeenAgain(*places[p], pool, &rng));
      rows.push_back(set.keyframes.back()->point_descriptors);
      set.keyframe_of.insert(set.keyframe_of.end(), static_cast<std::size_t>(rows.back().rows),
                             static_cast<int>(set.keyframes.size()) - 1);
    }
  }
  cv::vconcat(rows, set.descriptors);
  std::vector<Query> queries;
  for (int i = 0; i < kQueries; ++i) {
    const std::size_t p = rng() % places.size();
    queries.push_back({SeenAgain(*places[p], pool, &rng), static_cast<int>(p)});
  }
  fmt::print(stderr, "{} keyframes, {} point descriptors\n", set.keyframes.size(),
             set.descriptors.rows);
  nlohmann::json report = {{"keyframes", set.keyframes.size()},
                           {"point_descriptors", set.descriptors.rows}};
  report["indexes"].push_back(BenchOurs(set, queries, kCopies, true));
  report["indexes"].push_back(BenchOurs(set, queries, kCopies, false));
  for (nlohmann::json& entry : BenchFaiss(set, queries, kCopies)) {
    report["indexes"].push_back(std::move(entry));
  }
  report["indexes"].push_back(BenchFlann(set, queries, kCopies));
  return report;
}

}  // namespace highwall::bench
