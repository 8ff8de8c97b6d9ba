#include <highwall/internal/run_profile.h>

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <highwall/internal/background_job.h>
#include <highwall/internal/processor_time.h>
#include <highwall/internal/stage_timer.h>
#include <highwall/internal/worker_team.h>

namespace highwall::run_profile_test {
namespace {

// Uses the processor of the calling thread for at least this time [s], however busy the machine is.
void Spin(double seconds) {
  const double end = ThreadProcessorSeconds() + seconds;
  while (ThreadProcessorSeconds() < end) {
  }
}

double SumOf(const RunProfile::ProcessorSeconds& seconds) {
  return std::accumulate(seconds.threads.begin(), seconds.threads.end(), 0.0,
                         [](double sum, const auto& entry) { return sum + entry.second; });
}

TEST(RunProfile, CountsThreadsThatRunAndThoseThatHaveEnded) {
  RunProfile profile;
  Spin(0.02);  // before the caller is registered
  const ProfiledThread caller({"caller", &profile});
  Spin(0.01);
  for (int i = 0; i < 2; ++i) {
    std::jthread([&profile] {
      const ProfiledThread worker({"worker", &profile});
      Spin(0.02);
    });
  }
  std::jthread([] { Spin(0.02); });  // of nobody
  const RunProfile::ProcessorSeconds seconds = profile.processor_seconds();
  EXPECT_EQ(seconds.threads.size(), 2U);
  EXPECT_GE(seconds.threads.at("caller"), 0.01);
  EXPECT_GE(seconds.threads.at("worker"), 0.04);
  EXPECT_LE(SumOf(seconds) + 0.04, seconds.process) << "two threads were not registered";
  Spin(0.01);
  EXPECT_GE(profile.processor_seconds().threads.at("caller"), 0.02);
  EXPECT_EQ(profile.processor_seconds().threads.at("worker"), seconds.threads.at("worker"));
}

TEST(RunProfile, ReadsTheClockOfARunningThread) {
  RunProfile profile;
  std::mutex mutex;
  std::condition_variable changed;
  bool spun = false, read = false;
  const std::jthread worker([&] {
    const ProfiledThread profiled({"worker", &profile});
    Spin(0.02);
    std::unique_lock lock(mutex);
    spun = true;
    changed.notify_all();
    changed.wait(lock, [&] { return read; });
  });
  std::unique_lock lock(mutex);
  changed.wait(lock, [&] { return spun; });
  const RunProfile::ProcessorSeconds seconds = profile.processor_seconds();
  EXPECT_GE(seconds.threads.at("worker"), 0.02);
  EXPECT_LE(SumOf(seconds), seconds.process);
  read = true;
  changed.notify_all();
}

TEST(RunProfile, TimesOfAnEarlierProfileAreNotCounted) {
  Spin(0.05);
  const double before = ProcessProcessorSeconds();
  const RunProfile profile;
  const double process = profile.processor_seconds().process;
  EXPECT_LE(process, ProcessProcessorSeconds() - before);
  EXPECT_TRUE(profile.processor_seconds().threads.empty());
}

TEST(RunProfile, StagesNestWithinTheirThread) {
  RunProfile profile(true);
  const ProfiledThread caller({"caller", &profile});
  double milliseconds = 0.0;
  {
    const StageTimer outer(&profile, "outer", &milliseconds);
    { const StageTimer inner(&profile, "inner"); }
    std::jthread([&profile] {
      const ProfiledThread worker({"worker", &profile});
      const StageTimer other(&profile, "other");
    });
  }
  const RunProfile::Trace trace = profile.trace();
  EXPECT_EQ(trace.lanes, (std::vector<std::string>{"caller", "worker"}));
  ASSERT_EQ(trace.spans.size(), 3U);
  const RunProfile::Span &inner = trace.spans[0], &other = trace.spans[1], &outer = trace.spans[2];
  EXPECT_EQ(std::string(inner.stage), "inner");
  EXPECT_EQ(std::string(other.stage), "other");
  EXPECT_EQ(std::string(outer.stage), "outer");
  EXPECT_EQ(inner.lane, 0U);
  EXPECT_EQ(other.lane, 1U);
  EXPECT_GE(outer.begin.count(), 0);
  EXPECT_GE(inner.begin, outer.begin);
  EXPECT_LE(inner.begin + inner.duration, outer.begin + outer.duration);
  EXPECT_DOUBLE_EQ(milliseconds, 1e-6 * static_cast<double>(outer.duration.count()));
}

TEST(RunProfile, ThreadsOfOneNameShareALaneUnlessTheyRunSideBySide) {
  RunProfile profile(true);
  const auto run = [&profile] {
    const ProfiledThread worker({"worker", &profile});
    const StageTimer stage(&profile, "stage");
  };
  { const std::jthread first(run); }
  { const std::jthread second(run); }
  EXPECT_EQ(profile.trace().lanes, std::vector<std::string>{"worker"});
  std::jthread([&] {
    const ProfiledThread worker({"worker", &profile});
    std::jthread beside(run);
    beside.join();
  });
  EXPECT_EQ(profile.trace().lanes, (std::vector<std::string>{"worker", "worker 2"}));
  EXPECT_EQ(profile.trace().spans.back().lane, 1U);
  EXPECT_EQ(profile.processor_seconds().threads.size(), 1U);
}

TEST(RunProfile, RecordsNoStageUnlessItTraces) {
  RunProfile profile;
  const ProfiledThread caller({"caller", &profile});
  { const StageTimer stage(&profile, "stage"); }
  EXPECT_TRUE(profile.trace().lanes.empty());
  EXPECT_TRUE(profile.trace().spans.empty());
  RunProfile traced(true);
  { const StageTimer stage(&traced, "stage"); }
  EXPECT_TRUE(traced.trace().spans.empty()) << "the caller is not registered in it";
}

TEST(StageTimer, AddsItsTimeOnce) {
  double milliseconds = 1.0;
  StageTimer timer(nullptr, "stage", &milliseconds);
  std::this_thread::sleep_for(std::chrono::milliseconds(2));
  timer.Stop();
  const double once = milliseconds;
  EXPECT_GE(once, 3.0);
  timer.Stop();
  EXPECT_EQ(milliseconds, once);
}

std::string NameOfThisThread() {
  char name[16] = "";
  ::pthread_getname_np(::pthread_self(), name, sizeof(name));
  return name;
}

int NiceValueOfThisThread() {
  return ::getpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()));
}

TEST(ThreadLabel, LowersThePriorityOfBackgroundThreadsOnly) {
  const int of_caller = NiceValueOfThisThread();
  int of_normal = 0, of_background = 0;
  BackgroundTask normal(
      true, [&](const std::stop_token&) { of_normal = NiceValueOfThisThread(); }, {"normal"});
  BackgroundTask background(
      true, [&](const std::stop_token&) { of_background = NiceValueOfThisThread(); },
      {"background", nullptr, ThreadPriority::kBackground});
  normal.Wait();
  background.Wait();
  EXPECT_EQ(of_normal, of_caller);
  EXPECT_EQ(of_background, std::min(of_caller + 10, 19));
  EXPECT_EQ(NiceValueOfThisThread(), of_caller);
}

TEST(ThreadLabel, NamesTheThreadsOfTasksAndTeams) {
  RunProfile profile;
  std::string of_task, of_worker;
  {
    BackgroundTask task(true,
                        [&](const std::stop_token&) {
                          of_task = NameOfThisThread();
                          Spin(0.01);
                        },
                        {"a task", &profile});
    task.Wait();
  }
  EXPECT_EQ(of_task, "a task");
  EXPECT_GE(profile.processor_seconds().threads.at("a task"), 0.01);
  const std::thread::id caller = std::this_thread::get_id();
  {
    WorkerTeam team(2, {"a team", &profile});
    std::atomic<int> begun = 0;
    team.Run(2, [&](std::size_t, std::size_t) {  // one on each
      ++begun;
      while (begun < 2) std::this_thread::yield();
      if (std::this_thread::get_id() != caller) of_worker = NameOfThisThread();
    });
  }
  EXPECT_EQ(of_worker, "a team");
  EXPECT_TRUE(profile.processor_seconds().threads.contains("a team"));
  EXPECT_NE(NameOfThisThread(), "a team");
}

}  // namespace
}  // namespace highwall::run_profile_test
