// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <swiftgs/math.hpp>

#include "bytes.hpp"
#include "output_file.hpp"
#include "parallel.hpp"

namespace swiftgs::io {

/// Puts little-endian values one behind the other into a row.
class RowEncoder {
 public:
  explicit RowEncoder(std::byte* row) : at_(row) {}

  template <class T>
  void add(T value) {
    store(at_, value);
    at_ += sizeof(T);
  }

  void add(vec3 v) { add(v.x), add(v.y), add(v.z); }

 private:
  std::byte* at_;
};

/// Writes `count` rows of `row_bytes` bytes front to back. `encode(i, row)`, a `RowEncoder`, fills row `i`;
/// it is called from all threads and must not throw.
template <class Encode>
void write_rows(OutputFile& file, std::size_t count, std::size_t row_bytes, const ProgressMeter& progress,
                const Encode& encode) {
  constexpr std::size_t buffer_bytes = 32 << 20;
  const std::size_t most = std::min(count, buffer_bytes / row_bytes);
  std::vector<std::byte> buffer(most * row_bytes);
  progress.report(0);
  for (std::size_t begin = 0; begin < count; begin += most) {
    const std::size_t size = std::min(most, count - begin);
    for_parts(size, [&](std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) encode(begin + i, RowEncoder(buffer.data() + i * row_bytes));
    });
    file.write(buffer.data(), size * row_bytes);
    progress.report(double(begin + size) / double(count));
  }
}

}  // namespace swiftgs::io
