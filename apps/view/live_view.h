#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <highwall/frontend/input/sensor.h>

#include "run/run_observer.h"

namespace highwall::apps {

struct LiveViewOptions {
  std::string address = "127.0.0.1";
  int port = 0;  // 0: any free one
  std::string title{};
  double min_depth = 0.0, max_depth = 6.0;       // [m] of the points that are shown
  std::vector<std::filesystem::path> save_to{};  // files of the button that saves the map
  // Polled while the run is paused: true ends the pause; empty: never.
  std::function<bool()> interrupted{};
};

// A page that shows a run while it lasts, for any browser: docs/view.md. The run pays for what it
// passes on; the rest is done on threads of the view, and no client can hold up the run, except by
// the buttons.
//
// Threads: tracking collects a batch (RunFollower), a worker encodes it, and those of the server
// send it. Each has its own state; they share the ViewHub, the RunControl and the queue of the
// worker, each with a lock of its own, and none is held while another is taken.
class LiveView final : public RunObserver {
 public:
  // Throws IoError if it cannot listen.
  LiveView(const RgbdSensor& sensor, LiveViewOptions options);
  ~LiveView() override;

  // Address of the page, with its token.
  std::string url() const;
  // Whether the button that stops the run was pressed.
  bool stopped() const;
  // Events that slow clients have lost.
  std::uint64_t dropped() const;
  std::size_t clients() const;

  void OnFrame(const FrameResult& result, const RgbdImage& image, const SlamSystem& slam,
               const RunPosition& position) override;
  void OnKeyframes(const KeyframeEvent& event) override;
  void OnOctree(std::int32_t world, const OctomapBuilder& octree) override;

  // Informs the clients of what is done after the last frame.
  void Begin(const std::string& stage);
  // Ends the page, which becomes the report. Waits until every client has fetched the report, for
  // `timeout` at most, four times that while a report is being sent, or until
  // LiveViewOptions::interrupted. report: an HTML page; empty: none.
  void End(std::string report, std::chrono::milliseconds timeout);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace highwall::apps
