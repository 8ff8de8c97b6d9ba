#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <highwall/core/trajectory.h>
#include <highwall/frontend/input/sensor.h>
#include <highwall/frontend/system/slam_system.h>

namespace highwall::bench {

// Result of tracking one frame.
struct Outcome {
  bool pose = false;
  Pose T_WC;                // if there is one
  SubmapId submap = kNoId;  // its world
  std::string reason;       // if there is no pose
  double matched = 0.0;     // share of the image's points and lines
};

// Two places that were recognized as the same.
struct Meeting {
  Stamp stamp = 0;                     // of the frame with which it was applied
  std::optional<SubmapMerge> merge;    // if they were in two maps
  double metres = 0.0, degrees = 0.0;  // error of the measured transform

  bool IsFalse() const { return metres > 0.1 || degrees > 3.0; }
};

// A system that is evaluated while it runs, in synchronous mode.
class Session {
 public:
  // truth: T_WC of every frame.
  Session(const RgbdSensor& sensor, const Trajectory& truth);
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  Outcome Track(const RgbdImage& image);
  // Call after the last frame.
  void Finish();

  // Accepted ones, ascending in time.
  const std::vector<Meeting>& meetings() const { return meetings_; }
  // Reasons for rejecting the others.
  const std::vector<std::string>& refusals() const { return refusals_; }
  // Trajectories of all parts, the one with most frames first.
  std::vector<Trajectory> Trajectories() const;

 private:
  void Judge(const LoopReport& report);

  std::map<Stamp, Pose> truth_;
  SlamSystem slam_;
  Stamp now_ = 0;
  std::vector<Meeting> meetings_;
  std::vector<std::string> refusals_;
};

}  // namespace highwall::bench
