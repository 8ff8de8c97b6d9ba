#include "ros/run_publisher.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <utility>

#include <fmt/core.h>

#include <highwall/frontend/map/map.h>
#include <highwall/mapping/occupancy_grid.h>

namespace highwall::apps {
namespace {

constexpr std::size_t kMostPoses = 5'000;          // of the path
constexpr std::size_t kMostPoints = 300'000;       // of the cloud
constexpr std::size_t kPointsOfAKeyframe = 1'500;  // at most
constexpr Stamp kStateInterval = 1'000'000'000;    // [ns] at most, between two states
constexpr std::chrono::seconds kSaveTimeout(10);

std::chrono::nanoseconds Nanoseconds(double seconds) {
  return std::chrono::nanoseconds(FromSeconds(seconds));
}

OctreeMessage MessageOf(const OctomapBuilder& octree) {
  const std::string data = octree.BinaryData();
  return {octree.options().resolution, {data.begin(), data.end()}};
}

NavigationGrid GridOf(const OccupancyGrid& grid, const Pose& T_WG) {
  NavigationGrid message{grid.width, grid.height, grid.resolution, T_WG, {}};
  message.cells.reserve(grid.cells.size());
  for (const GridCell cell : grid.cells) {
    message.cells.push_back(static_cast<std::int8_t>(cell == GridCell::kOccupied ? 100
                                                     : cell == GridCell::kFree   ? 0
                                                                                 : -1));
  }
  return message;
}

// Motion from one pose to the next; the covariance is that of the difference of two poses.
Twist TwistOf(const StampedPose& from, const StampedPose& to, const PoseCovariance& covariance) {
  const double dt = ToSeconds(to.stamp - from.stamp);
  const Pose motion = from.pose.Inverse() * to.pose;
  const Eigen::AngleAxisd rotation(motion.q());
  Twist twist;
  twist.velocity << motion.p() / dt, rotation.angle() / dt * rotation.axis();
  twist.covariance = 2.0 / (dt * dt) * Rotated(to.pose.R().transpose(), covariance);
  return twist;
}

}  // namespace

RunPublisher::RunPublisher(RosLink& link, const CameraStream& stream, RunPublisherOptions options)
    : link_(link),
      stream_(stream),
      options_(std::move(options)),
      unprojector_(options_.sensor.camera),
      path_turn_(Nanoseconds(options_.period)),
      cloud_turn_(Nanoseconds(options_.period)),
      octree_turn_(Nanoseconds(options_.period)) {}

void RunPublisher::OnFrame(const FrameResult& result, const RgbdImage&, const SlamSystem& slam,
                           const RunPosition& position) {
  stamp_ = result.stamp;
  if (HasPose(result.state)) {
    world_ = result.submap.value();
    const Pose T_CB = options_.T_BC.Inverse();
    PublishFrame(result, odometry_.Advance(result, slam.map()) * T_CB);
  }
  PublishState(result, slam, position);
  path_turn_.Do([&] {
    for (const SubmapTrajectory& submap : slam.submaps()) {
      if (submap.submap.value() == world_) PublishPath(submap.frames);
    }
  });
  if (cloud_changed_) cloud_turn_.Do([&] { PublishCloud(); });
  SaveIfAsked(slam);
}

void RunPublisher::PublishFrame(const FrameResult& result, const Pose& T_OB) {
  const Pose T_WB = result.T_WC * options_.T_BC.Inverse();
  const PoseCovariance in_world =
      MovedBy(T_WB.p() - result.T_WC.p(), InWorld(result.uncertainty.value(), result.T_WC));
  const Pose& T_WO = odometry_.T_WO();
  const PoseCovariance in_odom = Rotated(T_WO.R().transpose(), in_world);
  const StampedPose now{result.stamp, T_OB};
  Twist twist;
  if (last_) twist = TwistOf(*last_, now, in_odom);
  last_ = now;
  link_.PublishTransforms(result.stamp, options_.base, T_WO, T_OB);
  link_.PublishPose(result.stamp, {T_WB, in_world});
  link_.PublishOdometry(result.stamp, options_.base, {T_OB, in_odom}, twist);
}

void RunPublisher::PublishState(const FrameResult& result, const SlamSystem& slam,
                                const RunPosition& position) {
  StateReport state;
  state.message = ToString(result.state);
  if (result.reason) state.message += std::string(": ") + ToString(*result.reason);
  if (message_ == state.message && reported_ && result.stamp - *reported_ < kStateInterval) return;
  message_ = state.message;
  reported_ = result.stamp;
  if (!HasPose(result.state)) {
    state.level = StateLevel::kError;
  } else if (result.state == TrackingState::kInertial || !result.unobservable_directions.empty()) {
    state.level = StateLevel::kWarning;
  }
  const Map& map = slam.map();
  state.values = {
      {"frames", std::to_string(position.done)},
      {"dropped", std::to_string(position.dropped)},
      {"without depth", std::to_string(stream_.unpaired())},
      {"out of order", std::to_string(stream_.out_of_order())},
      {"matched points", std::to_string(result.matched_points)},
      {"matched lines", std::to_string(result.matched_lines)},
      {"unobservable directions", std::to_string(result.unobservable_directions.size())},
      {"keyframes", std::to_string(map.num_keyframes())},
      {"submaps", std::to_string(map.roots().size())},
      {"frame [ms]", fmt::format("{:.1f}", result.times.total)}};
  if (result.inertial) {
    state.values.emplace_back("imu", ToString(result.inertial->status));
    state.values.emplace_back("weight of the imu", fmt::format("{:.2f}", result.inertial->weight));
  }
  link_.PublishState(result.stamp, state);
}

void RunPublisher::PublishPath(const Trajectory& T_WC) const {
  const std::size_t step = 1 + T_WC.size() / kMostPoses;
  const Pose T_CB = options_.T_BC.Inverse();
  Trajectory path;
  for (std::size_t i = 0; i < T_WC.size(); i += step) {
    path.push_back({T_WC[i].stamp, T_WC[i].pose * T_CB});
  }
  link_.PublishPath(stamp_, path);
}

void RunPublisher::OnKeyframes(const KeyframeEvent& event) {
  cloud_changed_ = true;
  for (const std::int64_t id : event.removed) keyframes_.erase(id);
  if (event.places) {
    for (auto keyframe = keyframes_.begin(); keyframe != keyframes_.end();) {
      const auto place = event.places->find(keyframe->first);
      if (place == event.places->end()) {
        keyframe = keyframes_.erase(keyframe);
      } else {
        keyframe++->second.place = place->second;
      }
    }
  }
  for (const KeyframeView& view : event.added) {
    keyframes_[view.id] = {
        SampleKeyframe(view, unprojector_, static_cast<float>(options_.sensor.min_depth),
                       static_cast<float>(options_.max_depth), kPointsOfAKeyframe),
        view.place};
  }
}

void RunPublisher::PublishCloud() {
  cloud_changed_ = false;
  const std::size_t limit = kMostPoints / std::max<std::size_t>(1, keyframes_.size());
  std::vector<ColouredPoint> points;
  for (const auto& [id, keyframe] : keyframes_) {
    if (keyframe.place.world != world_) continue;
    const auto R = keyframe.place.T_WC.R().cast<float>().eval();
    const auto p = keyframe.place.T_WC.p().cast<float>().eval();
    const KeyframeCloudSample& sample = keyframe.sample;
    for (std::size_t i = 0; i < std::min(limit, sample.points_C.size()); ++i) {
      points.push_back({R * sample.points_C[i] + p, sample.rgb[3 * i], sample.rgb[3 * i + 1],
                        sample.rgb[3 * i + 2]});
    }
  }
  link_.PublishCloud(stamp_, points);
}

void RunPublisher::PublishGrid(const OccupancyGrid& grid, const Pose& T_WG) const {
  link_.PublishGrid(stamp_, GridOf(grid, T_WG));
}

void RunPublisher::OnOctree(std::int32_t world, const OctomapBuilder& octree) {
  if (world != world_ || octree.NodeCount() == 0) return;
  octree_turn_.Do([&] {
    link_.PublishOctree(stamp_, MessageOf(octree));
    // z of the world is up with an IMU, and otherwise if the camera was held level at first.
    const double ground = FloorHeight(octree).value_or(0.0);
    const OccupancyGrid grid = ProjectToGrid(octree, {.ground_height = ground});
    if (grid.cells.empty()) return;
    PublishGrid(
        grid, Pose(Eigen::Quaterniond::Identity(), {grid.origin_G.x(), grid.origin_G.y(), ground}));
  });
}

void RunPublisher::Finish(const SlamRun& run) {
  Reply({false, "the run has ended"});
  if (run.largest.trajectory.empty()) return;
  world_ = run.largest.submap.value();
  PublishPath(run.largest.trajectory);
  PublishCloud();
  if (!run.largest.dense) return;
  const DenseMap& dense = *run.largest.dense;
  link_.PublishOctree(stamp_, MessageOf(dense.octree));
  if (dense.grid.cells.empty()) return;
  const Pose T_WG(dense.R_GW.conjugate(), Eigen::Vector3d::Zero());
  const Eigen::Vector3d corner(dense.grid.origin_G.x(), dense.grid.origin_G.y(),
                               dense.ground_height.value_or(0.0));
  PublishGrid(dense.grid, T_WG * Pose(Eigen::Quaterniond::Identity(), corner));
}

void RunPublisher::Reply(const Answer& answer) {
  const std::lock_guard lock(mutex_);
  answer_ = answer;
  saved_.notify_all();
}

void RunPublisher::SaveIfAsked(const SlamSystem& slam) {
  if (!save_.exchange(false)) return;
  Answer answer;
  try {
    if (slam.map().num_keyframes() == 0) {
      answer.message = "there is no map yet";
    } else {
      SaveMap(options_.map, options_.sensor.camera, slam.map());
      answer = {true, fmt::format("{} keyframes are saved in {}", slam.map().num_keyframes(),
                                  options_.map.string())};
    }
  } catch (const std::exception& error) {
    answer.message = error.what();
  }
  Reply(answer);
}

Answer RunPublisher::Save() {
  if (options_.map.empty()) return {false, "a run that only localizes saves no map"};
  std::unique_lock lock(mutex_);
  answer_.reset();
  save_ = true;
  if (!saved_.wait_for(lock, kSaveTimeout, [&] { return answer_.has_value(); })) {
    save_ = false;
    return {false, "no image arrives"};
  }
  return *answer_;
}

}  // namespace highwall::apps
