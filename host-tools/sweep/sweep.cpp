#include "host-tools/sweep/sweep.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <ctime>
#include <exception>
#include <mutex>
#include <thread>

namespace thimble::host {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kLook = std::chrono::milliseconds(100);

double since_s(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

double thread_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

struct Stopped {};

// The threads take the runs that are due, one by one.
class Workers {
 public:
  Workers(const SweepRuns& runs, SweepResults& results, std::vector<std::size_t> due)
      : runs_(runs), results_(results), due_(std::move(due)) {
    for (const std::size_t run : due_) cost_ += runs_.cost(run);
  }
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  ~Workers() {
    stop_ = true;
    join();
  }

  void start(std::size_t jobs) {
    working_ = jobs;
    for (std::size_t i = 0; i < jobs; ++i) threads_.emplace_back([this] { work(); });
  }
  // Until all threads have ended.
  void watch(const std::function<bool(const SweepProgress&)>& progress) {
    std::unique_lock lock(mutex_);
    while (working_ > 0) {
      ended_.wait_for(lock, kLook);
      const SweepProgress now{results_.done(), results_.runs(), left_s()};
      lock.unlock();
      if (!progress(now)) stop_ = true;
      lock.lock();
    }
    lock.unlock();
    join();
    if (failure_) std::rethrow_exception(failure_);
  }
  [[nodiscard]] SweepTimes times() const { return {done_ == due_.size(), done_, since_s(begin_), run_s_}; }

 private:
  void work() {
    try {
      for (std::size_t next = 0; !stop_ && (next = next_++) < due_.size();) {
        const double begin_s = thread_s();
        const std::string line = runs_.line(due_[next], [this] {
          if (stop_) throw Stopped{};
        });
        const std::lock_guard lock(mutex_);
        results_.add(due_[next], line);
        run_s_ += thread_s() - begin_s;
        paid_ += runs_.cost(due_[next]);
        ++done_;
      }
    } catch (const Stopped&) {
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failure_ = std::current_exception();
      stop_ = true;
    }
    const std::lock_guard lock(mutex_);
    --working_;
    ended_.notify_all();
  }
  void join() {
    for (std::thread& thread : threads_)
      if (thread.joinable()) thread.join();
  }
  [[nodiscard]] double left_s() const { return paid_ > 0 ? since_s(begin_) * (cost_ - paid_) / paid_ : 0; }

  const SweepRuns& runs_;
  SweepResults& results_;
  std::vector<std::size_t> due_;
  Clock::time_point begin_ = Clock::now();
  std::atomic<std::size_t> next_ = 0;
  std::atomic<bool> stop_ = false;
  std::mutex mutex_;  // of all below, and of the results
  std::condition_variable ended_;
  std::size_t working_ = 0, done_ = 0;
  double cost_ = 0, paid_ = 0, run_s_ = 0;
  std::exception_ptr failure_;
  std::vector<std::thread> threads_;
};

}  // namespace

std::vector<std::size_t> missing_runs(const SweepResults& results, const SweepPart& part) {
  std::vector<std::size_t> missing;
  for (std::size_t run = part.part; run < results.runs(); run += part.parts)
    if (!results.has(run)) missing.push_back(run);
  return missing;
}

SweepTimes run_sweep(const SweepRuns& runs, SweepResults& results, const SweepPart& part, std::size_t jobs,
                     const std::function<bool(const SweepProgress&)>& progress) {
  // The longest first: then the threads end at about the same time.
  std::vector<std::size_t> due = missing_runs(results, part);
  std::ranges::stable_sort(due, std::greater(), [&runs](std::size_t run) { return runs.cost(run); });
  Workers workers(runs, results, due);
  workers.start(std::min(jobs, due.size()));
  workers.watch(progress);
  return workers.times();
}

}  // namespace thimble::host
