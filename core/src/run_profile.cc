#include <highwall/internal/run_profile.h>

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <new>

namespace highwall {
namespace {

// How much nicer a thread of ThreadPriority::kBackground is: it gets a tenth of the time of a thread
// that competes with it.
constexpr int kBackgroundNice = 10;

}  // namespace

RunProfile::ProcessorSeconds RunProfile::processor_seconds() const {
  ProcessorSeconds seconds;
  {
    const std::lock_guard lock(mutex_);
    for (const Lane& lane : lanes_) {
      double& of_name = seconds.threads[lane.name];
      of_name += lane.ended;
      // An active thread cannot end before Leave(), so that its clock exists.
      if (lane.is_active) of_name += ProcessorSecondsOf(lane.clock) - lane.begin;
    }
    seconds.decoding = decoding_;
  }
  // Last, so that the threads do not exceed it.
  seconds.process = ProcessProcessorSeconds() - process_start_;
  return seconds;
}

RunProfile::Trace RunProfile::trace() const {
  Trace trace;
  const std::lock_guard lock(mutex_);
  if (!is_tracing_) return trace;
  std::map<std::string, int> count;
  for (const Lane& lane : lanes_) {
    const int number = ++count[lane.name];
    trace.lanes.push_back(number == 1 ? lane.name : lane.name + ' ' + std::to_string(number));
  }
  trace.spans = spans_;
  return trace;
}

void RunProfile::AddSpan(const char* stage, Clock::time_point begin,
                         Clock::time_point end) noexcept {
  const std::thread::id self = std::this_thread::get_id();
  const std::lock_guard lock(mutex_);
  const auto lane = std::ranges::find_if(
      lanes_, [self](const Lane& other) { return other.is_active && other.thread == self; });
  if (lane == lanes_.end()) return;
  try {
    spans_.push_back(
        {static_cast<std::size_t>(lane - lanes_.begin()), stage, begin - start_, end - begin});
  } catch (const std::bad_alloc&) {
  }
}

void RunProfile::AddDecoding(double seconds) {
  const std::lock_guard lock(mutex_);
  decoding_ += seconds;
}

std::size_t RunProfile::Enter(const char* name) {
  clockid_t clock{};
  ::pthread_getcpuclockid(::pthread_self(), &clock);
  const std::lock_guard lock(mutex_);
  auto lane = std::ranges::find_if(
      lanes_, [name](const Lane& other) { return !other.is_active && other.name == name; });
  if (lane == lanes_.end()) lane = lanes_.insert(lane, Lane{.name = name});
  lane->is_active = true;
  lane->thread = std::this_thread::get_id();
  lane->clock = clock;
  lane->begin = ThreadProcessorSeconds();
  return static_cast<std::size_t>(lane - lanes_.begin());
}

void RunProfile::Leave(std::size_t index) {
  const std::lock_guard lock(mutex_);
  Lane& lane = lanes_[index];
  lane.ended += ThreadProcessorSeconds() - lane.begin;
  lane.is_active = false;
}

void SetUpThread(const ThreadLabel& label) {
  ::pthread_setname_np(::pthread_self(), label.name);
  if (label.priority == ThreadPriority::kBackground) {
    // On Linux, nice values belong to threads, and everyone may raise them.
    const auto thread = static_cast<id_t>(::gettid());
    ::setpriority(PRIO_PROCESS, thread, ::getpriority(PRIO_PROCESS, thread) + kBackgroundNice);
  }
}

ProfiledThread::ProfiledThread(const ThreadLabel& label)
    : profile_(label.profile), lane_(profile_ != nullptr ? profile_->Enter(label.name) : 0) {}

ProfiledThread::~ProfiledThread() {
  if (profile_ != nullptr) profile_->Leave(lane_);
}

}  // namespace highwall
