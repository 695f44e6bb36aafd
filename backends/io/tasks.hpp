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

/// Becomes true where what a task does is no longer wanted.
using Stopping = std::atomic<bool>;

/// Calls `body(task, stopping)` for every task below `count` from as many threads as there are cores, each of
/// which takes the next task when it is done with one. Tasks must not depend on each other. The first
/// exception of one ends all and is thrown here. The calling thread only tells `progress` how many tasks are
/// done, many times a second, so that cancelling takes no longer than tasks do that do not look at
/// `stopping`.
template <class Body>
void for_tasks(std::size_t count, const ProgressMeter& progress, const Body& body) {
  constexpr std::chrono::milliseconds between_reports(50);
  std::atomic<std::size_t> next{0}, done{0};
  Stopping stopping{false};
  std::exception_ptr thrown;
  std::mutex mutex;  // of what follows and `thrown`
  std::condition_variable finished;
  std::size_t running = std::min<std::size_t>(std::max(1u, std::thread::hardware_concurrency()), count);
  const auto work = [&] {
    std::exception_ptr own;
    try {
      for (std::size_t task; !stopping && (task = next++) < count; ++done) body(task, stopping);
    } catch (...) {
      own = std::current_exception();
      stopping = true;
    }
    const std::scoped_lock lock(mutex);
    if (!thrown) thrown = own;
    --running;
    finished.notify_one();
  };

  progress.report(0);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = running; i > 0; --i) threads.emplace_back(work);
    try {
      std::unique_lock lock(mutex);
      while (!finished.wait_for(lock, between_reports, [&] { return running == 0; })) {
        lock.unlock();
        progress.report(double(done) / double(count));
        lock.lock();
      }
    } catch (...) {
      stopping = true;
      throw;
    }
  }
  if (thrown) std::rethrow_exception(thrown);
  progress.report(1);
}

}  // namespace swiftgs::io
