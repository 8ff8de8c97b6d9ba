#include "tracking/frame_refiner.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <stop_token>
#include <utility>

#include <highwall/internal/stage_timer.h>

#include "features/corrected_depth.h"
#include "features/memory_bytes.h"
#include "map/map_matcher.h"
#include "pose/support.h"
#include "sensor/feature_noise.h"
#include "tracking/constant_velocity.h"
#include "tracking/landmark_observations.h"
#include "tracking/landmarks_around.h"

namespace highwall {
namespace {

constexpr std::size_t kBatch = 30;        // frames, so that the map is not copied for each
constexpr std::size_t kMostAtOnce = 100;  // frames, so that a copy of the map stays small
constexpr double kEnough = 0.5;           // of the support that the frame was tracked with

int SupportOf(const TrackedFrame& frame) {
  return Support(frame.num_points, frame.num_lines);
}

}  // namespace

struct FrameRefiner::Item {
  PosedFrame posed;
  TrackedFrame frame{};          // T_WC: that of `posed` when the job begins
  SubmapId root = kFirstSubmap;  // root of its map
  bool refine = false;
  RowMotion moved_by{};
  DepthPattern pattern{};
  KeyFrameId newest = kNoId;
};

// A batch of frames with its neighbours, and a copy of the map around them.
class FrameRefiner::Job {
 public:
  Job(Map map, std::vector<Item> items, const ImageKnowledge& knowledge,
      const FrameRefiner& refiner)
      : map_(std::move(map)),
        items_(std::move(items)),
        knowledge_(knowledge),
        model_(refiner.model_),
        matcher_(model_),
        camera_(refiner.camera_),
        grid_(refiner.grid_),
        rounds_(refiner.parameters_.rounds),
        tracker_(refiner.tracker_),
        profile_(refiner.profile_),
        task_(refiner.background_, [this](const std::stop_token& stop) { Run(stop); },
              {"refinement", profile_, ThreadPriority::kBackground}) {}

  void Cancel() { task_.Cancel(); }
  bool IsDone() const { return task_.IsDone(); }

  // Returns the frames that were refined.
  std::vector<PosedFrame> Take() {
    task_.Wait();
    return std::exchange(found_, {});
  }

 private:
  void Run(const std::stop_token& stop) {
    const StageTimer timer(profile_, "refinement of frames");
    for (Item& item : items_) {
      if (!item.refine) continue;
      auto& features = item.frame.frame.features;
      if (knowledge_.noise) features = WithNoise(*features, *knowledge_.noise, model_);
      DepthPattern more = knowledge_.pattern;
      more.nodes -= item.pattern.nodes;
      if (!more.IsZero()) features = CorrectedDepth(*features, camera_, more);
    }
    LandmarksAround around(map_);
    std::vector<bool> is_found(items_.size());
    for (int round = 0; round < rounds_; ++round) {
      for (std::size_t i = 0; i < items_.size() && !stop.stop_requested(); ++i) {
        if (!items_[i].refine || (round > 0 && !MoveRows(i))) continue;
        // A frame that is found keeps its matches: they hardly depend on the motion of the rows.
        if (FindPose(&items_[i].frame, is_found[i] ? nullptr : &around)) is_found[i] = true;
      }
    }
    for (std::size_t i = 0; i < items_.size(); ++i) {
      const TrackedFrame& frame = items_[i].frame;
      if (is_found[i]) {
        found_.push_back({items_[i].posed.stamp,
                          AnchoredPose::At(map_, frame.reference, frame.T_WC),
                          InformationInCamera(frame.information, frame.T_WC)});
      }
    }
    map_ = Map();
    items_.clear();
  }

  // Updates the rolling-shutter compensation of a frame; returns whether the change is significant.
  bool MoveRows(std::size_t i) {
    Item& item = items_[i];
    if (!knowledge_.timing) return false;
    RowMotion now{*knowledge_.timing, item.moved_by.motion};
    now.timing.depth_delay += item.frame.frame.depth_delay;
    // The readings of an IMU state the motion better than poses do.
    if (!item.posed.readings && i > 0 && i + 1 < items_.size()) {
      if (const auto motion = MotionBetween(items_[i - 1], items_[i + 1])) now.motion = *motion;
    }
    auto& features = item.frame.frame.features;
    if (!Differ(item.moved_by, now, model_.camera(), MedianDepth(*features))) return false;
    features = MovedOtherwise(*features, model_.camera(), grid_, item.moved_by, now);
    item.moved_by = now;
    return true;
  }

  // Returns the mean twist; empty if the two frames are too far apart in time.
  static std::optional<Twist> MotionBetween(const Item& before, const Item& after) {
    const double dt = ToSeconds(after.posed.measured_at() - before.posed.measured_at());
    if (before.root != after.root || !(dt > 0.0 && dt <= ConstantVelocity::kLongestPrediction)) {
      return std::nullopt;
    }
    return Twist::Between(before.frame.T_WC.Inverse() * after.frame.T_WC, dt);
  }

  // Estimates the pose from the landmarks that the frame is matched to, then from all around, if
  // these are not null. Returns false and leaves the frame unchanged if the support falls below
  // kEnough.
  bool FindPose(TrackedFrame* frame, LandmarksAround* around) const {
    TrackedFrame again = *frame;
    if (!Solve(&again)) return false;
    if (around != nullptr) {
      MatchAround(matcher_, map_, tracker_.local_keyframes, &again, around);
      if (!Solve(&again)) return false;
    }
    if (!again.open.empty()) return false;
    if (SupportOf(again) < kEnough * SupportOf(*frame)) return false;
    again.reference = map_.Observers(again).front().first;
    *frame = std::move(again);
    return true;
  }

  bool Solve(TrackedFrame* frame) const {
    return SolveFromLandmarks(model_, map_, tracker_, frame);
  }

  Map map_;
  std::vector<Item> items_;
  const ImageKnowledge knowledge_;
  const MeasurementModel model_;  // a copy: T_BC may be re-estimated while this runs
  const MapMatcher matcher_;
  const PinholeCamera camera_;
  const DepthGrid& grid_;
  const int rounds_;
  const TrackerOptions tracker_;
  std::vector<PosedFrame> found_;
  RunProfile* const profile_;
  BackgroundTask task_;  // last: it uses all of the above and ends first
};

FrameRefiner::FrameRefiner(const MeasurementModel& model, const PinholeCamera& camera,
                           const FrameRefinementOptions& options, const TrackerOptions& tracker,
                           bool background, const FrameRefinerParameters& parameters,
                           RunProfile* profile)
    : model_(model),
      camera_(camera),
      grid_(model.camera()),
      options_((options.Validate(), options)),
      parameters_(parameters),
      tracker_(tracker),
      background_(background),
      profile_(profile) {}

FrameRefiner::~FrameRefiner() = default;

void FrameRefiner::Add(const TrackedFrame& frame, const PosedFrame& posed,
                       const RowMotion& moved_by, const DepthPattern& pattern, KeyFrameId newest) {
  if (!options_.enabled) return;
  newest_ = newest;
  Item item{.posed = posed, .moved_by = moved_by, .pattern = pattern, .newest = newest};
  item.refine = frame.by_image && SupportOf(frame) > 0 && frame.open.empty();
  if (item.refine) {
    item.frame = frame;
    item.frame.frame.features = WithoutImages(*frame.frame.features);
    item.frame.moving.release();
  }
  waiting_.push_back(std::move(item));
}

std::optional<LostFrame> FrameRefiner::Withdraw(Stamp stamp) {
  const auto item = std::ranges::find_if(waiting_, [&](const Item& waiting) {
    return waiting.posed.stamp == stamp && waiting.refine;
  });
  if (item == waiting_.end()) return std::nullopt;
  LostFrame lost{item->frame.frame, stamp, item->moved_by, item->pattern};
  waiting_.erase(item);
  return lost;
}

std::size_t FrameRefiner::MemoryBytes() const {
  std::size_t bytes = 0;
  for (const Item& item : waiting_) {
    // Frames that are not refined are kept for the motion alone.
    if (item.frame.frame.features) bytes += BytesOf(*item.frame.frame.features);
  }
  return bytes;
}

bool FrameRefiner::IsFull() const {
  return waiting_.size() > static_cast<std::size_t>(options_.waiting);
}

void FrameRefiner::Begin(const Map& map, const ImageKnowledge& knowledge) {
  if (!job_.IsEmpty()) return;
  // The last one of them has to wait for its successor.
  const auto young = std::ranges::find_if(waiting_, [&](const Item& item) {
    return newest_.value() - item.newest.value() < parameters_.keyframes;
  });
  auto count = static_cast<std::size_t>(young - waiting_.begin());
  const auto most = static_cast<std::size_t>(options_.waiting);
  if (waiting_.size() > most) count = std::max(count, waiting_.size() - most + kBatch);
  count =
      std::min({count, kMostAtOnce, waiting_.size() - std::min<std::size_t>(waiting_.size(), 1)});
  if (count >= kBatch) Start(map, knowledge, count);
}

void FrameRefiner::Start(const Map& map, const ImageKnowledge& knowledge, std::size_t count) {
  std::vector<Item> items;
  if (before_) items.push_back({.posed = *before_});
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(count);
  items.insert(items.end(), std::make_move_iterator(waiting_.begin()),
               std::make_move_iterator(end));
  before_ = items.back().posed;
  waiting_.erase(waiting_.begin(), end);
  if (!waiting_.empty()) items.push_back({.posed = waiting_.front().posed});
  std::erase_if(items, [&](const Item& item) { return !map.RootOf(item.posed.pose.reference); });

  std::set<KeyFrameId> around;
  for (Item& item : items) {
    item.root = *map.RootOf(item.posed.pose.reference);
    item.frame.T_WC = item.posed.measured().T_WC(map);
    if (!item.refine) continue;
    int most = tracker_.local_keyframes;
    for (const auto& [id, shared] : map.Observers(item.frame)) {
      if (most-- == 0) break;
      around.insert(id);
    }
  }
  const std::vector<KeyFrameId> keyframes(around.begin(), around.end());
  job_.Put(std::make_unique<Job>(map.CloneOf(keyframes), std::move(items), knowledge, *this));
}

bool FrameRefiner::HasResult() const {
  return !job_.IsEmpty() && job_->IsDone();
}

void FrameRefiner::Finish(const Map& map, std::vector<PosedFrame>* frames) {
  const std::unique_ptr<Job> job = job_.Take();
  if (!job) return;
  for (const PosedFrame& found : job->Take()) {
    if (!map.RootOf(found.pose.reference)) continue;
    const auto frame = std::ranges::lower_bound(*frames, found.stamp, {}, &PosedFrame::stamp);
    if (frame == frames->end() || frame->stamp != found.stamp) continue;  // dropped
    // The frame stays anchored to the keyframe of its time: a younger keyframe, though it shares
    // more landmarks by now, may not have been adjusted yet.
    AnchoredPose& pose = frame->measured();
    const Pose before = pose.T_WC(map), after = found.pose.T_WC(map);
    pose = AnchoredPose::At(map, pose.reference, after);
    if (frame->delay > 0) {  // its pose at the stamp is predicted from that of its late image
      const Pose predicted = before.Inverse() * frame->pose.T_WC(map);
      frame->pose = AnchoredPose::At(map, frame->pose.reference, after * predicted);
    }
    frame->information = found.information;
    ++refined_;
    if (before_ && before_->stamp == found.stamp) before_ = *frame;
  }
}

void FrameRefiner::FinishAll(const Map& map, const ImageKnowledge& knowledge,
                             std::vector<PosedFrame>* frames) {
  Finish(map, frames);
  if (waiting_.empty()) return;
  Start(map, knowledge, waiting_.size());
  Finish(map, frames);
}

}  // namespace highwall
