#include <highwall/internal/worker_team.h>

#include <utility>

namespace highwall {

WorkerTeam::WorkerTeam(std::size_t workers, const ThreadLabel& label) {
  for (std::size_t worker = 1; worker < workers; ++worker) {
    threads_.emplace_back([this, worker, label](std::stop_token stop) {
      SetUpThread(label);
      const ProfiledThread profiled(label);
      Serve(worker, std::move(stop));
    });
  }
}

void WorkerTeam::Run(std::size_t tasks, const Work& work) {
  const bool alone = threads_.empty() || tasks < 2;
  next_ = 0;
  if (!alone) {
    {
      const std::lock_guard lock(mutex_);
      work_ = &work;
      tasks_ = tasks;
      ++round_;
    }
    start_.notify_all();
  }
  Do(0, work, tasks);
  std::unique_lock lock(mutex_);
  work_ = nullptr;
  done_.wait(lock, [this] { return active_ == 0; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void WorkerTeam::Serve(std::size_t worker, std::stop_token stop) {
  for (std::size_t served = 0;;) {
    const Work* work = nullptr;
    std::size_t tasks = 0;
    {
      std::unique_lock lock(mutex_);
      if (!start_.wait(lock, stop, [&] { return work_ != nullptr && round_ != served; })) return;
      work = work_;
      tasks = tasks_;
      served = round_;
      ++active_;
    }
    Do(worker, *work, tasks);
    const std::lock_guard lock(mutex_);
    if (--active_ == 0) done_.notify_one();
  }
}

void WorkerTeam::Do(std::size_t worker, const Work& work, std::size_t tasks) {
  for (std::size_t task = next_++; task < tasks; task = next_++) {
    try {
      work(worker, task);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      error_ = std::current_exception();
    }
  }
}

}  // namespace highwall
