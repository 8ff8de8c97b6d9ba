#include "view/live_view.h"

#include <cstddef>
#include <exception>
#include <random>
#include <thread>
#include <utility>

#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include <highwall/frontend/map/map.h>
#include <highwall/internal/background_worker.h>

#include "files/json_text.h"
#include "view/octree_blocks.h"
#include "view/run_control.h"
#include "view/run_follower.h"
#include "view/scene_encoder.h"
#include "view/view_hub.h"
#include "view/view_page.h"
#include "view/view_server.h"

namespace highwall::apps {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPictureInterval(125);

bool IsLoopback(const std::string& address) {
  return address == "localhost" || address == "::1" || address.starts_with("127.");
}

// 128 random bits.
std::string MakeToken() {
  std::random_device random;
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", random());
  return token;
}

}  // namespace

struct LiveView::Impl {
  Impl(const RgbdSensor& s, LiveViewOptions o)
      : sensor(s),
        options(std::move(o)),
        local(IsLoopback(options.address)),
        token(local ? "" : MakeToken()),
        follower(sensor.camera, options.min_depth, options.max_depth),
        encoder(hub, sensor.camera),
        octrees(hub),
        worker(1, {}, {"live view", nullptr, ThreadPriority::kBackground}),
        server({options.address, options.port, token, local}, hub, ViewPage(options.title),
               [this](std::string_view command) { return Apply(command); }) {
    PostControl();
  }

  // On a thread of the server.
  bool Apply(std::string_view command) {
    if (!control.Apply(command)) return false;
    PostControl();
    return true;
  }
  // Repeated if another thread has changed the state since, so that the last event is the present.
  void PostControl() {
    for (bool current = false; !current;) {
      const bool paused = control.paused(), stopped = control.stopped();
      hub.Post("control", JsonText(nlohmann::json{{"paused", paused}, {"stopped", stopped}}));
      current = control.paused() == paused && control.stopped() == stopped;
    }
  }
  // On the thread that tracks, as the following.
  void Send(const FrameResult& result, const RgbdImage& image, const SlamSystem& slam,
            const RunPosition& position) {
    last_picture = Clock::now();
    worker.Post(
        [this, batch = follower.Take(result, image, slam, position)](const std::stop_token&) {
          try {
            encoder.Encode(batch);
          } catch (const std::exception& error) {  // the run does without this picture
            hub.Post("note", JsonText(nlohmann::json(error.what())));
          }
        });
  }
  void Save(const SlamSystem& slam);

  const RgbdSensor sensor;
  const LiveViewOptions options;
  const bool local;
  const std::string token;
  ViewHub hub;
  RunControl control;
  RunFollower follower;  // of the thread that tracks
  SceneEncoder encoder;  // of the worker
  OctreeBlocks octrees;  // of the thread that maps
  Clock::time_point last_picture{};
  BackgroundWorker worker;
  ViewServer server;  // last: its threads end first
};

void LiveView::Impl::Save(const SlamSystem& slam) {
  std::string note;
  try {
    if (options.save_to.empty() || slam.map().num_keyframes() == 0) {
      note = options.save_to.empty() ? "this run saves no map" : "there is no map yet";
    } else {
      for (const std::filesystem::path& path : options.save_to) {
        SaveMap(path, sensor.camera, slam.map());
        note += (note.empty() ? "" : ", ") + path.filename().string();
      }
      note = fmt::format("{} keyframes saved in {}", slam.map().num_keyframes(), note);
    }
  } catch (const std::exception& error) {
    note = std::string("the map could not be saved: ") + error.what();
  }
  hub.Post("note", JsonText(nlohmann::json(note)));
}

LiveView::LiveView(const RgbdSensor& sensor, LiveViewOptions options)
    : impl_(std::make_unique<Impl>(sensor, std::move(options))) {}

LiveView::~LiveView() = default;

std::string LiveView::url() const {
  const std::string& address = impl_->options.address;
  const bool is_v6 = address.find(':') != std::string::npos;
  return fmt::format("http://{}:{}/{}", is_v6 ? "[" + address + "]" : address, impl_->server.port(),
                     impl_->token.empty() ? "" : "?token=" + impl_->token);
}

bool LiveView::stopped() const {
  return impl_->control.stopped();
}

std::uint64_t LiveView::dropped() const {
  return impl_->hub.dropped();
}

std::size_t LiveView::clients() const {
  return impl_->hub.clients();
}

void LiveView::OnFrame(const FrameResult& result, const RgbdImage& image, const SlamSystem& slam,
                       const RunPosition& position) {
  Impl& impl = *impl_;
  impl.follower.AddFrame(result, slam);
  const bool last = position.done == position.total;
  const bool due = last || Clock::now() - impl.last_picture >= kPictureInterval;
  bool shown = impl.control.paused() || (due && impl.hub.HasClients() && impl.worker.IsIdle());
  if (shown) impl.Send(result, image, slam, position);
  while (true) {
    switch (impl.control.Next()) {
      case RunControl::Task::kContinue:
        return;
      case RunControl::Task::kSave:
        impl.Save(slam);
        break;
      case RunControl::Task::kWait:
        if (impl.options.interrupted && impl.options.interrupted()) return;
        if (!std::exchange(shown, true)) impl.Send(result, image, slam, position);
        break;
    }
  }
}

void LiveView::OnKeyframes(const KeyframeEvent& event) {
  impl_->follower.AddKeyframes(event);
}

void LiveView::OnOctree(std::int32_t world, const OctomapBuilder& octree) {
  if (impl_->hub.HasClients()) impl_->octrees.UpdateInTurn(world, octree);
}

void LiveView::Begin(const std::string& stage) {
  impl_->hub.Post("note", JsonText(nlohmann::json(stage)));
}

void LiveView::End(std::string report, std::chrono::milliseconds timeout) {
  Impl& impl = *impl_;
  const bool has_report = !report.empty();
  const std::size_t expected = has_report ? impl.hub.clients() : 0;
  if (has_report) impl.server.SetReport(std::move(report));
  impl.hub.Post("ended", JsonText(nlohmann::json{{"report", has_report}}));
  const Clock::time_point begin = Clock::now();
  // A report that is being sent is not cut off, unless its client is very slow.
  const auto waits = [&] {
    return Clock::now() < begin + (impl.server.IsSendingReport() ? 4 : 1) * timeout;
  };
  while (static_cast<std::size_t>(impl.server.reports_fetched()) < expected && waits() &&
         !(impl.options.interrupted && impl.options.interrupted())) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

}  // namespace highwall::apps
