// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include <swiftgs/cpu.hpp>
#include <swiftgs/raster/raster.hpp>

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

/// Has `blend(squares, begin, end)` blend all squares of `job`, in parallel. Throws as `squares_of`.
template <class F>
void for_squares(const Cpu& cpu, const RasterJob& job, const F& blend) {
  const Squares squares = squares_of(job);
  const auto blend_some = [&](std::size_t begin, std::size_t end) { blend(squares, begin, end); };
  cpu.for_parts(squares.size(), 4, BlendOnHost<decltype(blend_some)>{job, cpu.threads_at_once(), blend_some});
}

}  // namespace swiftgs
