// SPDX-License-Identifier: Apache-2.0
#include "bench/threads.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <thread>

#if defined(SWIFTGS_HAS_CPU)
#include <oneapi/tbb/global_control.h>
#endif

namespace swiftgs::cli {

struct ThreadLimit::Control {
#if defined(SWIFTGS_HAS_CPU)
  explicit Control(std::size_t threads) : limit(tbb::global_control::max_allowed_parallelism, threads) {}
  tbb::global_control limit;
#endif
};

ThreadLimit::ThreadLimit(std::optional<std::int64_t> threads)
    : threads_(std::max(1, int(std::thread::hardware_concurrency()))) {
  if (!threads) return;
  if (*threads < 1 || *threads > threads_)
    throw std::invalid_argument("--threads " + std::to_string(*threads) + ": expected 1 to " +
                                std::to_string(threads_) + ", as many as there are processors");
#if defined(SWIFTGS_HAS_CPU)
  control_ = std::make_unique<Control>(std::size_t(*threads));
  threads_ = int(*threads);
#else
  throw std::invalid_argument("--threads: expected a build with oneTBB");
#endif
}

ThreadLimit::~ThreadLimit() = default;

}  // namespace swiftgs::cli
