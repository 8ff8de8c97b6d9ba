// Runs with a camera that is moved with a covered lens to an unknown place: submaps that are not
// merged are mapped separately.
#include <cstddef>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/mapping/keyframe_cloud.h>
#include <highwall/mapping/map_comparison.h>

#include "run/slam_run.h"
#include "simulate/scenes/room.h"

namespace highwall::apps::slam_submaps_test {
namespace {

constexpr double kFps = 20.0;
constexpr int kCovered = -1;  // the lens

// Frames of a walk around a room, in any order.
class CarriedCamera final : public Dataset {
 public:
  CarriedCamera(const simulate::Simulation& room, std::vector<int> frames)
      : room_(room), frames_(std::move(frames)) {}

  std::size_t size() const override { return frames_.size(); }
  Stamp stamp(std::size_t index) const override {
    return FromSeconds(1.0 + static_cast<double>(index) / kFps);
  }
  const Trajectory* groundtruth() const override { return nullptr; }
  // Returns the frame with that stamp.
  simulate::SimulatedFrame FrameAt(Stamp at) const {
    std::size_t index = 0;
    while (stamp(index) != at) ++index;
    return room_.Render(frames_.at(index));
  }

 private:
  RgbdImage DoLoad(std::size_t index) const override {
    if (frames_[index] == kCovered) {
      const PinholeCamera& camera = room_.options().camera;
      return {stamp(index), cv::Mat(camera.height, camera.width, CV_8UC3, cv::Scalar::all(0)),
              cv::Mat(camera.height, camera.width, CV_32FC1, cv::Scalar(0))};
    }
    const simulate::SimulatedFrame frame = room_.Render(frames_[index]);
    return {stamp(index), frame.bgr, frame.depth};
  }

  const simulate::Simulation& room_;
  std::vector<int> frames_;
};

void Append(int begin, int end, std::vector<int>& frames) {
  for (int i = begin; i < end; ++i) frames.push_back(i);
}

simulate::Simulation MakeRoom() {
  simulate::SimulationOptions options;
  options.seed = 3;
  options.fps = kFps;
  options.duration = 9.0;
  options.camera = {
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  return simulate::SimulateRoom(options);
}

SlamRun RunOn(const CarriedCamera& dataset, const PinholeCamera& camera) {
  SlamRunOptions options;
  options.slam = Deterministic(options.slam);
  options.map.background = false;
  return RunSlam(dataset, {.camera = camera}, options);
}

// Returns the points observed in the frames of a submap, by true depth and poses, in its world.
std::vector<Eigen::Vector3f> SeenIn(const SubmapRun& submap, const CarriedCamera& dataset,
                                    const PinholeCamera& camera) {
  std::vector<Eigen::Vector3f> points;
  const StampedPose& first = submap.trajectory.front();
  const Pose T_world_room = first.pose * dataset.FrameAt(first.stamp).T_WC.Inverse();
  for (std::size_t i = 0; i < submap.trajectory.size(); i += 3) {
    const simulate::SimulatedFrame frame = dataset.FrameAt(submap.trajectory[i].stamp);
    const Pose T_WC = T_world_room * frame.T_WC;
    for (const ColoredPoint& point :
         MakeKeyframeCloud(frame.depth, {}, camera, {.voxel_size = 0.03})) {
      points.push_back((T_WC * point.p.cast<double>()).cast<float>());
    }
  }
  return points;
}

TEST(SlamOfSubmaps, MapsEachInItsOwnWorldAndNothingOfThoseThatWereDropped) {
  const simulate::Simulation room = MakeRoom();
  const PinholeCamera& camera = room.options().camera;
  // The segment in between is too short for a submap that is kept.
  std::vector<int> frames;
  Append(0, 40, frames);
  frames.insert(frames.end(), 10, kCovered);
  Append(76, 82, frames);
  frames.insert(frames.end(), 10, kCovered);
  Append(120, 175, frames);
  const CarriedCamera dataset(room, frames);
  const SlamRun run = RunOn(dataset, camera);
  ASSERT_TRUE(run.failures.empty()) << run.failures.front();
  ASSERT_EQ(run.others.size(), 1U);
  EXPECT_GE(std::max(run.others[0].submap, run.largest.submap), SubmapId(2))
      << "one was dropped in between";
  for (const SubmapRun* const submap : {&run.largest, &run.others[0]}) {
    ASSERT_TRUE(submap->dense);
    std::vector<Eigen::Vector3f> points;
    for (const ColoredPoint& point : submap->dense->cloud) points.push_back(point.p);
    const MapComparison comparison =
        CompareMaps(points, ReferenceSurface(SeenIn(*submap, dataset, camera)));
    // Voxels of the reference are 3 cm, and the camera drifts by one or two centimetres; the walls
    // of another submap are half a metre or more away.
    EXPECT_GT(comparison.thresholds.back().precision, 0.99) << submap->submap;
    EXPECT_GT(comparison.thresholds.back().recall, 0.8) << submap->submap;
    const OctreeLeafCount leaves = submap->dense->octree.LeafCount();
    EXPECT_GT(leaves.occupied, 100U);
    const MapComparison octree = CompareMaps(OccupiedCentres(submap->dense->octree),
                                             ReferenceSurface(SeenIn(*submap, dataset, camera)));
    EXPECT_GT(octree.thresholds.back().precision, 0.99) << submap->submap;
  }
  EXPECT_GT(run.times.dense.count, 0U);
}

}  // namespace
}  // namespace highwall::apps::slam_submaps_test
