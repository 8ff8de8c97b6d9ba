// Parts of the live view: bounded events, blocks by revision, buttons, and cubes of the octree.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "view/event_channel.h"
#include "view/frame_event.h"
#include "view/octree_blocks.h"
#include "view/run_control.h"
#include "view/scene_blocks.h"
#include "view/scene_encoder.h"
#include "view/scene_text.h"
#include "view/view_hub.h"
#include "view/view_page.h"

namespace highwall::apps::view_test {
namespace {

using nlohmann::json;
using Task = RunControl::Task;

constexpr std::chrono::milliseconds kNow(0);

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

// Returns the data of the blocks among server-sent events.
std::vector<json> Blocks(const std::string& text) {
  const std::string begin = "event: block\ndata: ";
  std::vector<json> blocks;
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at + 1)) {
    const std::size_t data = at + begin.size();
    blocks.push_back(json::parse(text.substr(data, text.find('\n', data) - data)));
  }
  return blocks;
}

TEST(EventChannel, KeepsTheLatestAndCountsTheOthers) {
  EventChannel channel;
  for (int i = 0; i < 10; ++i) channel.Push({std::to_string(i), nullptr});
  EXPECT_EQ(channel.size(), EventChannel::kCapacity);
  EXPECT_EQ(channel.dropped(), 10 - EventChannel::kCapacity);
  EXPECT_EQ(channel.Pop()->name, "6");
  while (channel.Pop()) {
  }
  EXPECT_EQ(channel.size(), 0U);
}

TEST(SceneBlocks, AClientReceivesEachBlockInItsPresentState) {
  SceneBlocks scene;
  std::uint64_t known = 0;
  EXPECT_TRUE(scene.After(&known, 100).empty());
  for (int i = 0; i < 1000; ++i) scene.Set("a", std::to_string(i));
  scene.Set("b", "x");
  const auto first = scene.After(&known, 100);
  ASSERT_EQ(first.size(), 2U);
  EXPECT_EQ(*first[0], "999");
  EXPECT_EQ(*first[1], "x");
  EXPECT_FALSE(scene.HasAfter(known));
  scene.Set("a", "again");
  ASSERT_EQ(scene.After(&known, 100).size(), 1U);
  EXPECT_EQ(scene.size(), 2U);
}

TEST(SceneBlocks, AreDividedByTheirSize) {
  SceneBlocks scene;
  for (const char* key : {"a/1", "a/2", "b/1"}) scene.Set(key, std::string(60, 'x'));
  std::uint64_t known = 0;
  EXPECT_EQ(scene.After(&known, 10).size(), 1U);
  EXPECT_EQ(scene.After(&known, 120).size(), 2U);
  scene.Remove("a/");
  EXPECT_EQ(scene.size(), 1U);
  known = 0;
  EXPECT_EQ(scene.After(&known, 1000).size(), 1U);
}

TEST(ViewHub, AClientThatNeverReadsCostsABoundedQueue) {
  ViewHub hub;
  EXPECT_FALSE(hub.HasClients());
  const int silent = *hub.Connect(), reader = *hub.Connect();
  EXPECT_EQ(hub.clients(), 2U);
  std::string received;
  for (int i = 0; i < 1000; ++i) {
    hub.Post("frame", std::to_string(i));
    received += *hub.Next(reader, kNow);
  }
  EXPECT_EQ(Count(received, "event: frame\n"), 1000U) << "the other client is served";
  EXPECT_EQ(Count(received, "event: dropped\n"), 0U);
  EXPECT_EQ(hub.dropped(), 1000 - EventChannel::kCapacity);
  const std::string late = *hub.Next(silent, kNow);
  EXPECT_EQ(Count(late, "event: frame\n"), EventChannel::kCapacity);
  EXPECT_EQ(Count(late, "event: dropped\ndata: 996\n"), 1U);
  EXPECT_EQ(*hub.Next(silent, kNow), ":\n\n") << "nothing is new";
  hub.Disconnect(silent);
  EXPECT_EQ(hub.dropped(), 996U) << "it is gone, and what it lost still counts";
}

TEST(ViewHub, ALateClientReceivesTheLatestEventsAndTheWholeScene) {
  ViewHub hub;
  hub.Post("frame", "1");
  hub.Post("frame", "2");
  hub.Post("control", "3");
  hub.SetBlock("a", "4");
  const std::string text = *hub.Next(*hub.Connect(), kNow);
  EXPECT_EQ(Count(text, "event: frame\ndata: 2\n\n"), 1U);
  EXPECT_EQ(Count(text, "data: 1\n"), 0U);
  EXPECT_EQ(Count(text, "event: control\ndata: 3\n\n"), 1U);
  EXPECT_EQ(Count(text, "event: block\ndata: 4\n\n"), 1U);
}

TEST(ViewHub, BlocksAreSentAtALimitedRate) {
  ViewHub hub(1);  // byte per second
  const int client = *hub.Connect();
  for (int i = 0; i < 64; ++i) hub.SetBlock(std::to_string(i), std::string(32 << 10, 'x'));
  EXPECT_EQ(Count(*hub.Next(client, kNow), "event: block\n"), 2U) << "64 KiB";
  EXPECT_EQ(*hub.Next(client, kNow), ":\n\n") << "it is not the time for more yet";
  hub.Post("frame", "1");
  EXPECT_EQ(Count(*hub.Next(client, kNow), "event: frame\n"), 1U) << "events do not wait";
}

TEST(ViewHub, ClientsAreLimitedAndEndWithIt) {
  ViewHub hub;
  for (std::size_t i = 0; i < ViewHub::kMaxClients; ++i) EXPECT_TRUE(hub.Connect());
  EXPECT_FALSE(hub.Connect());
  hub.Disconnect(0);
  const std::optional<int> client = hub.Connect();
  ASSERT_TRUE(client);
  hub.Post("ended", "1");
  hub.Close();
  EXPECT_EQ(Count(*hub.Next(*client, kNow), "event: ended\n"), 1U) << "the last event arrives";
  EXPECT_FALSE(hub.Next(*client, kNow));
  EXPECT_FALSE(hub.Connect());
}

TEST(ViewHub, ServesClientsThatComeAndGoWhileOthersPost) {
  ViewHub hub;
  std::atomic<std::size_t> frames = 0;
  std::vector<std::jthread> clients;
  for (int i = 0; i < 3; ++i) {
    clients.emplace_back([&] {
      while (const std::optional<int> client = hub.Connect()) {
        for (int n = 0; n < 5; ++n) {
          const auto text = hub.Next(*client, std::chrono::milliseconds(5));
          if (text) frames += Count(*text, "event: frame\n");
        }
        hub.Disconnect(*client);
      }
    });
  }
  for (int i = 0; i < 2000 || frames == 0; ++i) {
    hub.Post("frame", std::to_string(i));
    hub.SetBlock(std::to_string(i % 10), std::to_string(i));
  }
  hub.Close();
  clients.clear();
  EXPECT_GT(frames, 0U);
  EXPECT_EQ(hub.clients(), 0U);
}

TEST(RunControl, PausesStepsAndResumesBetweenFrames) {
  RunControl control;
  EXPECT_EQ(control.Next(), Task::kContinue);
  EXPECT_TRUE(control.Apply("pause"));
  EXPECT_TRUE(control.paused());
  EXPECT_EQ(control.Next(), Task::kWait);
  EXPECT_TRUE(control.Apply("step"));
  EXPECT_EQ(control.Next(), Task::kContinue);
  EXPECT_EQ(control.Next(), Task::kWait) << "after one frame";
  EXPECT_TRUE(control.Apply("save"));
  EXPECT_EQ(control.Next(), Task::kSave);
  EXPECT_EQ(control.Next(), Task::kWait);
  EXPECT_TRUE(control.Apply("resume"));
  EXPECT_EQ(control.Next(), Task::kContinue);
  EXPECT_FALSE(control.Apply("dance"));
}

TEST(RunControl, AStopEndsAPause) {
  RunControl control;
  control.Apply("pause");
  std::jthread button([&] { control.Apply("stop"); });
  while (control.Next() == Task::kWait) {
  }
  EXPECT_TRUE(control.stopped());
}

TEST(RunControl, AStepPausesARunThatIsNotPaused) {
  RunControl control;
  control.Apply("step");
  EXPECT_EQ(control.Next(), Task::kWait);
}

std::vector<Eigen::Vector3f> Wall(float x) {
  std::vector<Eigen::Vector3f> points;
  for (float y = -1.0F; y < 1.0F; y += 0.04F) {
    for (float z = -1.0F; z < 1.0F; z += 0.04F) points.emplace_back(x, y, z);
  }
  return points;
}

std::size_t CellsOf(const std::vector<json>& blocks) {
  std::size_t cells = 0;
  for (const json& block : blocks) cells += block["count"].get<std::size_t>();
  return cells;
}

TEST(OctreeBlocks, PublishesTheOccupiedCellsAndThenTheCubesThatChanged) {
  ViewHub hub;
  OctreeBlocks blocks(hub);
  OctomapBuilder octree({.resolution = 0.1});
  octree.InsertWorld(Wall(2.05F), Eigen::Vector3f::Zero());
  blocks.Update(3, octree);
  const int client = *hub.Connect();
  const std::vector<json> first = Blocks(*hub.Next(client, kNow));
  EXPECT_EQ(CellsOf(first), octree.LeafCount().occupied);
  EXPECT_EQ(first.front()["world"], 3);
  EXPECT_EQ(first.front()["size"], 0.1);
  blocks.Update(3, octree);
  EXPECT_EQ(*hub.Next(client, kNow), ":\n\n") << "nothing has changed";
  octree.InsertWorld(std::vector{Eigen::Vector3f(2.05F, 0.05F, 5.05F)}, Eigen::Vector3f::Zero());
  blocks.Update(3, octree);
  const int other = *hub.Connect();
  const std::vector<json> all = Blocks(*hub.Next(other, kNow));
  EXPECT_EQ(all.size(), first.size() + 1);
  EXPECT_EQ(all.back()["count"], 1) << "it was published last";
}

TEST(OctreeBlocks, JoinsCellsWhereThereAreTooMany) {
  ViewHub hub;
  OctreeBlocks blocks(hub, 200);
  OctomapBuilder octree({.resolution = 0.1});
  octree.InsertWorld(Wall(2.05F), Eigen::Vector3f::Zero());
  blocks.Update(0, octree);
  const std::vector<json> cubes = Blocks(*hub.Next(*hub.Connect(), kNow));
  EXPECT_EQ(cubes.front()["size"], 0.2);
  EXPECT_LE(CellsOf(cubes), 200U);
  EXPECT_GE(CellsOf(cubes), 100U);
}

TEST(SampleKeyframe, TakesAFewPixelsOfTheWholeImage) {
  const PinholeCamera camera{
      .width = 320, .height = 240, .fx = 262.5, .fy = 262.5, .cx = 159.5, .cy = 119.5};
  const DepthUnprojector unprojector(camera);
  cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(2.0)), bgr(240, 320, CV_8UC3, cv::Scalar(1, 2, 3));
  depth.rowRange(0, 120).setTo(0.0);
  cv::Mat moving = cv::Mat::zeros(240, 320, CV_8UC1);
  moving.colRange(160, 320).setTo(255);
  KeyframeView view{.id = 7,
                    .depth = std::make_shared<const cv::Mat>(depth),
                    .bgr = std::make_shared<const cv::Mat>(bgr),
                    .dynamic = std::make_shared<const cv::Mat>(moving)};
  const KeyframeCloudSample sample = SampleKeyframe(view, unprojector, 0.1F, 6.0F, 1000);
  EXPECT_EQ(sample.id, 7);
  EXPECT_NEAR(static_cast<double>(sample.points_C.size()), 250.0, 25.0);
  for (const Eigen::Vector3f& p : sample.points_C) {
    EXPECT_EQ(p.z(), 2.0F);
    EXPECT_LE(p.x(), 0.0F) << "what moves is left out";
    EXPECT_GE(p.y(), 0.0F);
  }
  ASSERT_EQ(sample.rgb.size(), 3 * sample.points_C.size());
  EXPECT_EQ(sample.rgb[0], 3);
  // The first of them are spread over the image.
  float low = 0.0F, high = -10.0F;
  for (std::size_t i = 0; i < 25; ++i) {
    low = std::min(low, sample.points_C[i].x());
    high = std::max(high, sample.points_C[i].x());
  }
  EXPECT_LT(low, -0.9F);
  EXPECT_GT(high, -0.3F);
  view.depth.reset();
  EXPECT_TRUE(SampleKeyframe(view, unprojector, 0.1F, 6.0F, 1000).points_C.empty());
}

TEST(SceneEncoder, FramesAreSentInBlocksThatGrow) {
  ViewHub hub;
  SceneEncoder encoder(hub, PinholeCamera());
  const int client = *hub.Connect();
  ViewBatch batch;
  batch.frames.resize(70);
  batch.keyframes = {{.id = 0, .world = 0, .active = true, .T_WC = Pose()},
                     {.id = 40, .world = 0, .active = true, .T_WC = Pose()}};
  encoder.Encode(batch);
  const std::vector<json> first = Blocks(*hub.Next(client, kNow));
  ASSERT_EQ(first.size(), 4U) << "two of keyframes, two of frames";
  EXPECT_EQ(first[2]["t"].size(), 64U);
  EXPECT_EQ(first[3]["first"], 64);
  batch = {};
  batch.frames.resize(2);
  encoder.Encode(batch);
  const int other = *hub.Connect();
  const std::vector<json> all = Blocks(*hub.Next(other, kNow));
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all.back()["t"].size(), 8U);
}

TEST(FrameEvent, SaysWhyThereIsNoPose) {
  FramePicture picture;
  picture.result.reason = LossReason::kDark;
  picture.bgr = cv::Mat(480, 640, CV_8UC3, cv::Scalar::all(9));
  picture.result.moving = cv::Mat(480, 640, CV_8UC1, cv::Scalar(255));
  const json event = json::parse(FrameEvent(picture, PinholeCamera()));
  EXPECT_EQ(event["state"], "lost");
  EXPECT_EQ(event["reason"], "dark");
  EXPECT_FALSE(event.contains("pose"));
  EXPECT_EQ(event["image"]["width"], 640);
  EXPECT_TRUE(event["mask"].is_string());
}

TEST(ViewPage, IsOneFileWithTheNameOfTheRunAsText) {
  const std::string page = ViewPage("a<b>&c");
  EXPECT_EQ(Count(page, "a&lt;b>&amp;c"), 2U);
  EXPECT_EQ(Count(page, "src=\""), 0U) << "it loads nothing but its events";
  for (const char* part : {"Highwall.chart", "Highwall.liveImage", "Highwall.liveScene"}) {
    EXPECT_GT(Count(page, part), 0U) << part;
  }
}

}  // namespace
}  // namespace highwall::apps::view_test
