// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <swiftgs/cpu/stages.hpp>
#include <swiftgs/frame/raster.hpp>

namespace swiftgs {

/// Half-open range of elements.
struct Part {
  std::size_t begin, end;
};

/// Part `part` of `parts` nearly equal ones of n elements.
inline Part part_of(std::size_t n, std::size_t parts, std::size_t part) {
  return {n * part / parts, n * (part + 1) / parts};
}

inline constexpr std::size_t max_parts = 512;

/// How many parts of at least `grain` elements to make of n: a few a thread, so that none waits long for
/// another.
inline std::size_t part_count(const Cpu& cpu, std::size_t n, std::size_t grain) {
  const std::size_t wanted = cpu.threads() == 1 ? 1 : 3 * std::size_t(cpu.threads());
  return std::clamp<std::size_t>(n / grain, 1, std::min(wanted, max_parts));
}

/// f(part number, range) for each of `parts` parts of n elements, in parallel.
template <class F>
void for_each_part(const Cpu& cpu, std::size_t n, std::size_t parts, const F& f) {
  cpu.for_parts(parts, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t part = first; part < last; ++part) f(part, part_of(n, parts, part));
  });
}

/// Turns counts[part * bins + bin] into the position of the first of these: bins follow each other, and in
/// each bin its parts. Returns the sum of all.
inline std::uint32_t counts_to_positions(const Cpu& cpu, std::uint32_t* counts, std::size_t parts,
                                         std::size_t bins) {
  const std::size_t ranges = part_count(cpu, parts * bins, 1 << 14);
  std::array<std::uint32_t, max_parts> before;
  for_each_part(cpu, bins, ranges, [&](std::size_t number, Part range) {
    std::uint32_t sum = 0;
    for (std::size_t part = 0; part < parts; ++part)
      for (std::size_t bin = range.begin; bin < range.end; ++bin) sum += counts[part * bins + bin];
    before[number] = sum;
  });
  std::uint32_t all = 0;
  for (std::size_t number = 0; number < ranges; ++number) all += std::exchange(before[number], all);
  for_each_part(cpu, bins, ranges, [&](std::size_t number, Part range) {
    // Some bins at a time, whose positions stay in the first-level cache while the parts pass by.
    std::array<std::uint32_t, 512> positions;
    std::uint32_t sum = before[number];
    for (std::size_t first = range.begin; first < range.end; first += positions.size()) {
      const std::size_t here = std::min(positions.size(), range.end - first);
      std::fill_n(positions.begin(), here, 0u);
      for (std::size_t part = 0; part < parts; ++part)
        for (std::size_t i = 0; i < here; ++i) positions[i] += counts[part * bins + first + i];
      for (std::size_t i = 0; i < here; ++i) sum += std::exchange(positions[i], sum);
      for (std::size_t part = 0; part < parts; ++part)
        for (std::size_t i = 0; i < here; ++i)
          positions[i] += std::exchange(counts[part * bins + first + i], positions[i]);
    }
  });
  return all;
}

/// Has `blend(blocks, begin, end)` blend all raster blocks of `job`, in parallel. Throws as
/// `raster_blocks_of`.
///
/// Raster blocks keep their order. To start with the longest lists gains nothing: on 16 threads rasterizing
/// `builtin:1000000` takes 4.92 ms so and 4.46 in order. The longest list has 1 % of all intersections.
template <class F>
void for_raster_blocks(const Cpu& cpu, const RasterJob& job, const F& blend) {
  const RasterBlocks blocks = raster_blocks_of(job);
  cpu.for_parts(blocks.size(), 4, [&](std::size_t begin, std::size_t end) { blend(blocks, begin, end); });
}

}  // namespace swiftgs
