// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "progress_meter.hpp"

namespace swiftgs::io {

/// True once a task should stop: an earlier task threw, or the work was cancelled.
class Stopping {
 public:
  Stopping(const std::atomic<std::size_t>& wanted, std::size_t task) : wanted_(&wanted), task_(task) {}

  explicit operator bool() const { return task_ >= *wanted_; }

 private:
  const std::atomic<std::size_t>* wanted_;
  std::size_t task_;
};

/// Calls `body(task, stopping)` for every task below `count`, in as many threads as there are cores. Tasks
/// are begun in order and must not depend on each other. A task that throws stops all later ones, so it is
/// always the exception of the first task that throws which arrives here. The calling thread only reports
/// progress, several times a second. Cancelling waits for running tasks; long ones should look at `stopping`.
template <class Body>
void for_tasks(std::size_t count, const ProgressMeter& progress, const Body& body) {
  constexpr std::chrono::milliseconds between_reports(50);
  std::atomic<std::size_t> next{0}, done{0};
  std::atomic<std::size_t> wanted{count};  // tasks below it are to be done
  std::size_t running = std::min<std::size_t>(std::max(1u, std::thread::hardware_concurrency()), count);
  std::exception_ptr thrown;
  std::mutex mutex;  // of `running`, `thrown` and writing `wanted`
  std::condition_variable finished;
  const auto work = [&] {
    for (std::size_t task; (task = next++) < wanted; ++done) {
      try {
        body(task, Stopping(wanted, task));
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (task >= wanted) continue;
        wanted = task;
        thrown = std::current_exception();
      }
    }
    const std::scoped_lock lock(mutex);
    --running;
    finished.notify_one();
  };

  progress.report(0);
  {
    std::vector<std::jthread> threads;
    try {
      for (std::size_t i = running; i > 0; --i) threads.emplace_back(work);
      std::unique_lock lock(mutex);
      while (!finished.wait_for(lock, between_reports, [&] { return running == 0; })) {
        lock.unlock();
        progress.report(double(done) / double(count));
        lock.lock();
      }
    } catch (...) {
      const std::scoped_lock lock(mutex);
      wanted = 0;
      throw;
    }
  }
  if (thrown) std::rethrow_exception(thrown);
  progress.report(1);
}

/// The same in the calling thread alone, for tasks that are shorter than starting a thread.
template <class Body>
void for_short_tasks(std::size_t count, const ProgressMeter& progress, const Body& body) {
  const std::atomic<std::size_t> wanted{count};
  progress.report(0);
  for (std::size_t task = 0; task < count; ++task) {
    body(task, Stopping(wanted, task));
    progress.report(double(task + 1) / double(count));
  }
}

}  // namespace swiftgs::io
