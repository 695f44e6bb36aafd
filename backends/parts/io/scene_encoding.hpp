// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What all writers of scenes share: rows, notes of what a format cannot hold, and how much rounding loses.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/scene.hpp>

#include "bytes.hpp"
#include "output_file.hpp"
#include "tasks.hpp"

namespace swiftgs::io {

class LossMeter {
 public:
  /// `scene`: the Gaussians that are written, which are those of `whole` without a fault (see `fault_of`), or
  /// all of them. Both scenes must outlive this.
  LossMeter(const Scene& scene, const Scene& whole) : scene_(scene), whole_(whole) {}

  /// What the file has of Gaussian `i` of `scene`.
  void add_position(std::size_t i, const vec3& found);
  void add_scales(std::size_t i, const vec3& found);
  void add_opacity(std::size_t i, float found);
  void add_colour(std::size_t i, const vec3& found);  ///< SH coefficients of band 0

  LargestLosses losses() const;

  /// A sentence with the largest displacement, if one of them shows.
  std::optional<std::string> sentence() const;

 private:
  std::size_t number_in_whole(std::size_t i) const;

  using Largest = std::atomic<double>;

  static void raise(Largest& largest, double loss) {
    double before = largest.load(std::memory_order_relaxed);
    while (loss > before && !largest.compare_exchange_weak(before, loss, std::memory_order_relaxed)) {
    }
  }

  const Scene &scene_, &whole_;
  Largest position_{0}, scale_{1}, opacity_{0}, colour_{0};
  std::size_t farthest_ = 0;
  std::atomic<std::size_t> displaced_{0};
  std::mutex mutex_{};
};

/// The scene without Gaussians that have a fault, opacities outside 0 to 1 and scales below 0. Empty if
/// `scene` has none. `write_scene` tells what becomes of them; `notes` get the counts.
std::optional<Scene> encodable(const Scene& scene, std::vector<std::string>& notes);

/// The logarithm of a scale, as files hold it; of 0 one whose exponential is 0 as a float, since few programs
/// read an infinity.
inline float log_of_scale(float scale) { return scale > 0 ? std::log(scale) : -104; }

/// What a file holds that keeps all Gaussians and bands of `scene`, and its model.
WrittenScene written_whole(std::string format, const Scene& scene);

/// Adds a note such as "Scales are clamped to 0 to 1: 12.", unless `count` is 0.
void note_clamped(std::uint64_t count, const std::string& things, const std::string& range,
                  std::vector<std::string>& notes);

/// Counts, in several threads, the numbers that a format clamps.
class ClampCount {
 public:
  void add(bool clamped) {
    if (clamped) count_.fetch_add(1, std::memory_order_relaxed);
  }

  void note(const std::string& things, const std::string& range, std::vector<std::string>& notes) const {
    note_clamped(count_, things, range, notes);
  }

 private:
  std::atomic<std::uint64_t> count_{0};
};

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
