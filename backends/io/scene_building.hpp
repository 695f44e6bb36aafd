// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <swiftgs/activation.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/sh.hpp>

/// @file
/// What every scene reader does with decoded numbers: activate them, and drop what cannot be rendered.

namespace swiftgs::io {

inline constexpr double sh_c0 = sh::c0;  ///< the basis function of band 0

/// Gives `scene` the arrays of `count` Gaussians.
void allocate(Scene& scene, std::size_t count, int sh_degree);

/// Whether all numbers of Gaussian `i` are finite.
bool renderable(const Scene& scene, std::size_t i);

/// Takes scales below 0, which linear formats can hold, without their sign, and notes of how many Gaussians.
void drop_signs_of_scales(SceneFile& file);

/// Removes the Gaussians with a value that cannot be rendered, and their `exact_means` unless these are
/// empty, keeping the order. Returns how many.
std::uint64_t drop_nonfinite(Scene& scene, std::vector<dvec3>& exact_means);
std::uint64_t drop_nonfinite(Scene& scene);

/// How far rounding to float moves means: the largest distance, of Gaussians that can be rendered.
class MeanRounding {
 public:
  /// Compares Gaussian `i`, when it is decoded, with its `exact` mean. Threads may call it at once.
  void add(const Scene& scene, std::size_t i, const dvec3& exact) {
    const dvec3 moved = exact - dvec3(scene.means[i]);
    const double distance = std::sqrt(detail::dot(moved, moved));
    double most = most_.load(std::memory_order_relaxed);
    while (distance > most && renderable(scene, i) && !most_.compare_exchange_weak(most, distance)) {
    }
  }
  double most() const { return most_; }

 private:
  std::atomic<double> most_ = 0;
};

/// Adds `rounding_note` of the scene to the notes. Returns whether there is one.
bool note_rounded_means(SceneFile& file, const MeanRounding& rounding);

/// Adds a note of so many Gaussians that `drop_nonfinite` removed, unless they are none.
void note_dropped(std::uint64_t dropped, std::vector<std::string>& notes);

}  // namespace swiftgs::io
