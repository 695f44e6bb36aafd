// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/span.hpp>

namespace swiftgs {

/// How many threads `requested` means: itself, or one a processor when 0. Throws `InvalidArgument` when
/// negative.
inline int thread_count(int requested) {
  if (requested < 0) detail::refuse("threads: expected 0 (one a processor) or more, got ", requested);
  if (requested > 0) return requested;
  return std::max(1, int(std::thread::hardware_concurrency()));
}

/// Calls `body(i)` once for each i in [0, count), in any order, on at most `threads` threads, this one
/// included. Rethrows the first exception that a call threw, after all threads have ended.
template <class Body>
void for_each_index(std::size_t count, int threads, const Body& body) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr error;
  std::mutex error_mutex;
  const auto work = [&] {
    try {
      for (std::size_t i = next++; i < count; i = next++) body(i);
    } catch (...) {
      next = count;
      const std::lock_guard lock(error_mutex);
      if (!error) error = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  const std::size_t wanted = std::min(std::size_t(threads), count);
  others.reserve(wanted);  // growing later might throw while threads run
  try {
    while (others.size() + 1 < wanted) others.emplace_back(work);
  } catch (const std::system_error&) {
    // The system grants no more threads: the ones that run do the work.
  }
  work();
  for (std::thread& other : others) other.join();
  if (error) std::rethrow_exception(error);
}

/// Loops with one thread a processor, for backends without threads on the host.
struct HostThreads {
  template <class F>
  void for_each(Count n, const F& f) const {
    for_each_index(n.get(), thread_count(0), f);
  }
};

}  // namespace swiftgs
