// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <thread>
#include <vector>

#include "progress_meter.hpp"

namespace swiftgs::io {

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

}  // namespace swiftgs::io
