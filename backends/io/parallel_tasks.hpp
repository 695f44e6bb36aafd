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

/// Calls `body(i)` for each i below `count`, from as many threads as there are cores, or from this one alone.
/// `progress` is told from this thread how many are done. If a body throws, no others are begun, and what the
/// one with the least i threw is thrown on.
template <class Body>
void for_each_task(std::size_t count, bool threads, const ProgressMeter& progress, const Body& body) {
  progress.report(0);
  if (!threads) {
    for (std::size_t i = 0; i < count; ++i) {
      body(i);
      progress.report(double(i + 1) / double(count));
    }
    return;
  }

  std::atomic<std::size_t> next = 0;
  std::vector<std::exception_ptr> errors(count);
  std::mutex mutex;
  std::condition_variable changed;
  std::size_t done = 0,
              running = std::min<std::size_t>(count, std::max(1u, std::thread::hardware_concurrency()));
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (...) {
        errors[i] = std::current_exception();
        next = count;
      }
      const std::lock_guard lock(mutex);
      ++done;
    }
    const std::lock_guard lock(mutex);
    --running;
    changed.notify_one();
  };
  {
    struct Stop {  // before the threads are joined, which a cancellation must not wait for
      std::atomic<std::size_t>& next;
      std::size_t count;
      ~Stop() { next = count; }
    };
    std::vector<std::jthread> workers;
    const std::size_t wanted = running;
    for (std::size_t i = 0; i < wanted; ++i) workers.emplace_back(work);
    const Stop stop{next, count};
    std::unique_lock lock(mutex);
    while (running > 0) {
      changed.wait_for(lock, std::chrono::milliseconds(100));
      const std::size_t finished = done;
      lock.unlock();
      progress.report(double(finished) / double(count));
      lock.lock();
    }
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace swiftgs::io
