// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Work of readers and writers on all cores, and how far it is.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <swiftgs/io/scene_file.hpp>

namespace swiftgs::io {

/// Tells a `Progress`, which may be empty, how far a reader or writer is. Work in several steps gives each a
/// meter of its own. The `Progress` must outlive them.
class ProgressMeter {
 public:
  ProgressMeter(const Progress& progress, std::string file) : progress_(&progress), file_(std::move(file)) {}

  /// Reports that this step is done up to `part`, from 0 to 1. A report that lies behind an earlier one
  /// repeats it: steps round, and some only estimate their end. Throws `Cancelled`.
  void report(double part) const {
    if (!*progress_) return;
    *most_ = std::max(*most_, std::min(begin_ + part * (end_ - begin_), 1.0));
    if (!(*progress_)(*most_)) throw Cancelled(file_);
  }

  /// The meter of a step that is [begin, end] of this one.
  ProgressMeter step(double begin, double end) const {
    ProgressMeter of_step = *this;
    of_step.begin_ = begin_ + begin * (end_ - begin_);
    of_step.end_ = begin_ + end * (end_ - begin_);
    return of_step;
  }

 private:
  const Progress* progress_;
  std::string file_;
  std::shared_ptr<double> most_ = std::make_shared<double>(0);  ///< reported by any of the meters
  double begin_ = 0, end_ = 1;
};

/// Calls `body(begin, end)` on parts of [0, count) from as many threads as there are cores. `body` must not
/// throw.
template <class Body>
void for_parts(std::size_t count, const Body& body) {
  constexpr std::size_t least = 1 << 16;  // below this a thread costs more than it saves
  const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
  const std::size_t parts = std::min(cores, count / least + 1);
  const auto bound = [&](std::size_t part) { return count / parts * part + std::min(part, count % parts); };
  std::vector<std::jthread> threads;
  for (std::size_t part = 1; part < parts; ++part)
    threads.emplace_back([&body, begin = bound(part), end = bound(part + 1)] { body(begin, end); });
  body(0, bound(1));
}

/// The same in steps; reports progress after each.
template <class Body>
void for_parts(std::size_t count, const ProgressMeter& progress, const Body& body) {
  constexpr std::size_t step = 1 << 19;
  progress.report(0);
  for (std::size_t begin = 0; begin < count; begin += step) {
    const std::size_t size = std::min(step, count - begin);
    for_parts(size, [&](std::size_t first, std::size_t end) { body(begin + first, begin + end); });
    progress.report(double(begin + size) / double(count));
  }
}

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
