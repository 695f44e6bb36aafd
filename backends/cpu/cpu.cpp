// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <swiftgs/cpu/stages.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/tools/processor.hpp>

#include "parts.hpp"

namespace swiftgs {

struct Cpu::Arena {
  tbb::task_arena arena;
};

Cpu::~Cpu() = default;
Cpu::Cpu(Cpu&&) noexcept = default;
Cpu& Cpu::operator=(Cpu&&) noexcept = default;

int Cpu::threads() const { return arena_->arena.max_concurrency(); }

void Cpu::run(std::size_t n, std::size_t grain, PartLoop part) const {
  if (n == 0) return;
  arena_->arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, n, grain),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        const RoundToNearest scope;
                        part.call(part.loop, range.begin(), range.end());
                      });
  });
}

Cpu::Cpu(int threads, const MemoryHook& memory) : memory_(memory), histograms_(memory) {
  validate(memory);
  require_thread_count(threads);
  // Asked for more than it may use, oneTBB would print a warning.
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const int most = int(std::min<std::size_t>(allowed, 1 << 15));
  arena_.reset(
      new Arena{tbb::task_arena(threads == 0 ? int(tbb::task_arena::automatic) : std::min(threads, most))});
}

std::string Cpu::device_name() const {
  // The arena may have places for more than oneTBB lets run.
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const int running = int(std::min(std::size_t(threads()), allowed));
  return processor_name() + ", " + std::to_string(running) + (running == 1 ? " thread" : " threads");
}

std::uint64_t Cpu::exclusive_scan(Span<std::uint32_t> counts) {
  // Sum each part, scan the sums, then scan the parts from there.
  const std::size_t parts = part_count(*this, counts.size, 32768);
  std::array<std::uint64_t, max_parts> sums;
  for_each_part(*this, counts.size, parts, [&](std::size_t part, Part range) {
    std::uint64_t sum = 0;
    for (std::size_t i = range.begin; i < range.end; ++i) sum += counts[i];
    sums[part] = sum;
  });
  std::uint64_t total = 0;
  for (std::size_t part = 0; part < parts; ++part) total += std::exchange(sums[part], total);
  for_each_part(*this, counts.size, parts, [&](std::size_t part, Part range) {
    std::uint64_t sum = sums[part];
    for (std::size_t i = range.begin; i < range.end; ++i) sum += std::exchange(counts[i], std::uint32_t(sum));
  });
  return total;
}

}  // namespace swiftgs
