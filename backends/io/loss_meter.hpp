// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>

#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/scene.hpp>

/// @file
/// How much rounding loses. Writers tell what their files hold, decoded again, from all threads.

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

}  // namespace swiftgs::io
