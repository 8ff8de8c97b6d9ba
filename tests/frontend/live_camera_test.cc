#include <highwall/frontend/input/live_camera.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/core/error.h>
#include <highwall/core/stamp.h>

#include "input/arrival_times.h"
#include "support/message_of.h"

namespace highwall::live_camera_test {
namespace {

constexpr Stamp kMs = 1'000'000;

// Images without pixels, 10 ms apart, each when the test allows it.
class FakeCamera final : public ImageSource {
 public:
  // More images may come; those of `fails` or later throw.
  explicit FakeCamera(std::size_t fails = SIZE_MAX) : fails_(fails) {}

  void Allow(std::size_t images, bool last = false) {
    const std::lock_guard lock(mutex_);
    allowed_ += images;
    last_ = last;
    changed_.notify_all();
  }

  std::optional<RgbdImage> Next() override {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return stopped_ || last_ || given_ < allowed_; });
    if (stopped_ || given_ == allowed_) return std::nullopt;
    if (given_ == fails_) throw IoError("camera", "is gone");
    return RgbdImage{.stamp = static_cast<Stamp>(++given_) * 10 * kMs, .bgr = {}, .depth = {}};
  }
  // One reading, 60 ms after the last image.
  std::vector<ImuSample> TakeImu() override {
    return {{(static_cast<Stamp>(given_) * 10 + 60) * kMs, {0, 0, 0}, {0, 0, 9.8}}};
  }
  void Stop() override {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }
  const SensorCalibration* calibration() const override { return &calibration_; }

 private:
  const std::size_t fails_;
  const SensorCalibration calibration_{};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t allowed_ = 0, given_ = 0;
  bool last_ = false, stopped_ = false;
};

// Collects the stamps of on_image.
class Listener {
 public:
  LiveCameraOptions Options() {
    return {.on_image = [this](const RgbdImage& image, std::span<const ImuSample> readings) {
      const std::lock_guard lock(mutex_);
      stamps_.push_back(image.stamp);
      readings_ += readings.size();
      changed_.notify_all();
    }};
  }
  void WaitFor(std::size_t images) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stamps_.size() >= images; });
  }
  std::size_t readings() const { return readings_; }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Stamp> stamps_;
  std::size_t readings_ = 0;
};

std::vector<Stamp> Rest(ImageSource& camera) {
  std::vector<Stamp> stamps;
  while (const auto image = camera.Next()) stamps.push_back(image->stamp / kMs);
  return stamps;
}

TEST(LiveCamera, ASlowConsumerSeesTheNewestImagesAndTheOthersAreCounted) {
  FakeCamera device;
  Listener listener;
  LiveCamera camera(device, listener.Options());
  device.Allow(5, true);
  listener.WaitFor(5);
  // The listener is called before an image is queued.
  while (camera.dropped() < 3) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_EQ(Rest(camera), (std::vector<Stamp>{40, 50}));
  EXPECT_EQ(camera.dropped(), 3U);
  EXPECT_EQ(listener.readings(), 5U) << "of dropped images too";
  EXPECT_EQ(camera.TakeImu().size(), 6U) << "and those after the last image";
  EXPECT_EQ(camera.calibration(), device.calibration());
}

TEST(LiveCamera, StopEndsAWaitingConsumer) {
  FakeCamera device;
  LiveCamera camera(device);
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    camera.Stop();
  });
  EXPECT_FALSE(camera.Next());
}

TEST(LiveCamera, ItsEndStopsTheDevice) {
  FakeCamera device;
  { const LiveCamera camera(device); }
  device.Allow(1);
  EXPECT_FALSE(device.Next());
}

TEST(LiveCamera, AFailureIsThrownAfterTheImagesBeforeIt) {
  FakeCamera device(2);
  LiveCamera camera(device);
  device.Allow(3);
  EXPECT_EQ(camera.Next()->stamp, 10 * kMs);
  EXPECT_EQ(camera.Next()->stamp, 20 * kMs);
  EXPECT_EQ(testing::MessageOf<IoError>([&] { camera.Next(); }), "camera: is gone");
}

TEST(LiveCamera, AnImageWaitsForTheReadingsAfterItButNotForASilentImu) {
  using Clock = std::chrono::steady_clock;
  FakeCamera device;
  LiveCamera camera(device, {.queue = 10, .imu_lead = 0.05, .imu_time_offset = 0.01});
  device.Allow(3, true);
  const auto start = Clock::now();
  EXPECT_EQ(Rest(camera).size(), 3U);
  EXPECT_LT(Clock::now() - start, std::chrono::milliseconds(250)) << "all are there";

  FakeCamera late;
  LiveCamera waiting(late, {.queue = 10, .imu_lead = 0.07});
  late.Allow(1);
  std::jthread next([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    late.Allow(1);
  });
  EXPECT_TRUE(waiting.Next());
  EXPECT_EQ(waiting.TakeImu().back().stamp, 80 * kMs) << "of the second image";
  EXPECT_TRUE(waiting.Next()) << "after 0.3 s at most";
}

TEST(LiveCamera, TheTimeSinceTheArrivalIsThatOfTheLastImage) {
  FakeCamera device;
  Listener listener;
  LiveCamera camera(device, listener.Options());
  EXPECT_FALSE(camera.MillisecondsSinceArrival());
  device.Allow(4);
  listener.WaitFor(4);
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  ASSERT_TRUE(camera.Next());
  EXPECT_GE(camera.MillisecondsSinceArrival().value(), 30.0);
}

TEST(ArrivalTimes, AnImageWhoseArrivalIsForgottenDoesNotForgetThoseBehindIt) {
  const ArrivalTimes::Clock::time_point start{};
  const auto at = [&](int ms) { return start + std::chrono::milliseconds(ms); };
  ArrivalTimes arrivals(3);
  for (int i = 1; i <= 4; ++i) arrivals.Add(i * 10, at(i));
  EXPECT_FALSE(arrivals.Take(10));
  EXPECT_EQ(arrivals.Take(30), at(3)) << "and that of 20, which was dropped, is forgotten";
  EXPECT_FALSE(arrivals.Take(20));
  EXPECT_EQ(arrivals.Take(40), at(4));
  EXPECT_FALSE(arrivals.Take(50));
}

TEST(LiveCamera, BadOptionsAreNamed) {
  FakeCamera device;
  EXPECT_THROW(LiveCamera(device, {.queue = 0}), InvalidArgument);
  EXPECT_EQ(testing::MessageOf<InvalidArgument>([&] { LiveCamera(device, {.imu_lead = -1.0}); }),
            "LiveCameraOptions.imu_lead is -1, must be from 0 to 1 s");
}

}  // namespace
}  // namespace highwall::live_camera_test
