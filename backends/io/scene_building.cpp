// SPDX-License-Identifier: Apache-2.0
#include "scene_building.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>

#include <sys/mman.h>
#include <unistd.h>

#include "parallel.hpp"

namespace swiftgs::io {
namespace {

// On bits, so that the loop over SH coefficients becomes integer SIMD.
bool all_finite(const float* values, std::size_t count) {
  bool finite = true;
  for (std::size_t i = 0; i < count; ++i) finite &= !detail::is_not_finite(values[i]);
  return finite;
}

template <class T>
void keep(std::vector<T>& values, const std::vector<std::uint8_t>& wanted, std::size_t stride) {
  auto to = values.begin();
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (!wanted[i]) continue;
    const auto from = values.begin() + std::ptrdiff_t(i * stride);
    to = std::copy(from, from + std::ptrdiff_t(stride), to);
  }
  values.erase(to, values.end());
}

/// Makes the system find the pages of [begin, end) now, large ones where it can, from all threads. It clears
/// each page, which takes longer than decoding what will lie there, and would otherwise be done by the one
/// thread that touches it.
void populate([[maybe_unused]] void* begin, [[maybe_unused]] void* end) {
#ifdef MADV_POPULATE_WRITE
  const auto page = std::uintptr_t(::sysconf(_SC_PAGESIZE));
  const std::uintptr_t first = (std::uintptr_t(begin) + page - 1) / page * page;
  const std::uintptr_t last = std::uintptr_t(end) / page * page;
  if (first >= last) return;
  ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
  // A kernel that cannot does it later, as pages are touched.
  for_parts((last - first) / page, [&](std::size_t from, std::size_t to) {
    ::madvise(reinterpret_cast<void*>(first + from * page), (to - from) * page, MADV_POPULATE_WRITE);
  });
#endif
}

template <class T>
void resize(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
  populate(values.data(), values.data() + count);
  values.resize(count);
}

}  // namespace

void allocate(Scene& scene, std::size_t count, int sh_degree) {
  scene.sh_degree = sh_degree;
  for_each_array([&](const char*, std::size_t each, auto& values) { resize(values, each * count); }, scene);
}

bool renderable(const Scene& scene, std::size_t i) {
  bool finite = true;
  for_each_array(
      [&](const char*, std::size_t each, const auto& values) {
        const std::size_t floats = each * swiftgs::detail::floats_of_value(values);
        finite &= all_finite(swiftgs::detail::floats_of(values).data + i * floats, floats);
      },
      scene);
  return finite;
}

void drop_signs_of_scales(SceneFile& file) {
  std::uint64_t found = 0;
  for (vec3& scale : file.scene.scales) {
    found += scale.x < 0 || scale.y < 0 || scale.z < 0;
    scale = glm::abs(scale);
  }
  if (found != 0)
    file.notes.push_back(
        "Scales below 0 are taken without their sign, of Gaussians: " + std::to_string(found) + ".");
}

std::uint64_t drop_nonfinite(Scene& scene) {
  std::vector<dvec3> none;
  return drop_nonfinite(scene, none);
}

std::uint64_t drop_nonfinite(Scene& scene, std::vector<dvec3>& exact_means) {
  std::vector<std::uint8_t> wanted(scene.size());
  for_parts(scene.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) wanted[i] = renderable(scene, i);
  });
  const auto dropped = std::uint64_t(std::count(wanted.begin(), wanted.end(), 0));
  if (dropped == 0) return 0;
  if (!exact_means.empty()) keep(exact_means, wanted, 1);
  for_each_array([&](const char*, std::size_t each, auto& values) { keep(values, wanted, each); }, scene);
  return dropped;
}

bool note_rounded_means(SceneFile& file, const MeanRounding& rounding) {
  std::string note = rounding_note(file.scene, rounding.most());
  if (note.empty()) return false;
  file.notes.push_back(std::move(note));
  return true;
}

void note_dropped(std::uint64_t dropped, std::vector<std::string>& notes) {
  if (dropped != 0)
    notes.push_back("Gaussians with a NaN or an infinity are left out: " + std::to_string(dropped) + ".");
}

}  // namespace swiftgs::io

namespace swiftgs {

std::string rounding_note(const Scene& scene, double most) {
  constexpr double seen = 1e-6;
  vec3 lower(std::numeric_limits<float>::infinity()), upper = -lower;
  double size = 0;
  for (std::size_t i = 0; most > 0 && i < scene.size(); ++i) {
    if (!io::renderable(scene, i)) continue;
    const vec3 &mean = scene.means[i], &scale = scene.scales[i];
    lower = glm::min(lower, mean), upper = glm::max(upper, mean);
    for (int axis = 0; axis < 3; ++axis)
      size = std::max({size, double(scale[axis]), double(upper[axis]) - double(lower[axis])});
  }
  if (!(most > seen * size)) return "";
  char distance[32];
  std::snprintf(distance, sizeof distance, "%.3g", most);
  return "Positions are so far from the origin that rounding them to float moves them by up to " +
         std::string(distance) + " units of the scene.";
}

}  // namespace swiftgs
