// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/scene.hpp>

/// @file
/// What all writers share: numbers that no format can hold, and notes of those that one format cannot.

namespace swiftgs::io {

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

}  // namespace swiftgs::io
