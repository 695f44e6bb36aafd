// SPDX-License-Identifier: Apache-2.0
#include "scene_building.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include <sys/mman.h>
#include <unistd.h>

#include "tasks.hpp"

namespace swiftgs::io {
namespace {

template <class T>
void keep(std::vector<T>& values, const std::vector<Fault>& faults, std::size_t stride) {
  auto to = values.begin();
  for (std::size_t i = 0; i < faults.size(); ++i) {
    if (faults[i] != Fault::none) continue;
    const auto from = values.begin() + std::ptrdiff_t(i * stride);
    to = std::copy(from, from + std::ptrdiff_t(stride), to);
  }
  values.erase(to, values.end());
}

/// Makes the system allocate the pages of [begin, end) now, large ones where it can, from all threads. The
/// system clears each page, which takes longer than decoding a page of the scene. Without this call the one
/// thread that touches a page first would clear it.
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

Fault fault_of(const Scene& scene, std::size_t i) {
  bool finite = true;
  for_each_array(
      [&](const char*, std::size_t each, const auto& values) {
        const std::size_t floats = each * swiftgs::detail::floats_of_value(values);
        finite &= swiftgs::detail::are_finite(swiftgs::detail::floats_of(values).data + i * floats, floats);
      },
      scene);
  if (!finite) return Fault::not_finite;
  return scene.rotations[i] == not_a_rotation ? Fault::no_rotation : Fault::none;
}

void drop_signs_of_scales(SceneFile& file) {
  for (vec3& scale : file.scene.scales) {
    file.signs_dropped += scale.x < 0 || scale.y < 0 || scale.z < 0;
    scale = glm::abs(scale);
  }
}

LeftOut leave_out(Scene& scene, const std::vector<Fault>& faults) {
  const auto count = [&](Fault fault) {
    return std::uint64_t(std::count(faults.begin(), faults.end(), fault));
  };
  const LeftOut left_out{count(Fault::not_finite), count(Fault::no_rotation)};
  if (left_out.total() != 0)
    for_each_array([&](const char*, std::size_t each, auto& values) { keep(values, faults, each); }, scene);
  return left_out;
}

LeftOut leave_out_invalid(Scene& scene) {
  std::vector<Fault> faults(scene.size());
  for_parts(scene.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) faults[i] = fault_of(scene, i);
  });
  return leave_out(scene, faults);
}

std::string text_of(const dvec3& origin) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    char digits[512];
    const auto end = std::to_chars(digits, std::end(digits), origin[axis] + 0.0,  // no -0
                                   std::chars_format::fixed)
                         .ptr;
    text.append(axis == 0 ? "" : ",").append(digits, end);
  }
  return text;
}

void note_left_out(const LeftOut& left_out, std::vector<std::string>& notes) {
  const auto note = [&](const char* which, std::uint64_t count) {
    if (count != 0)
      notes.push_back(std::string("Gaussians ") + which + " are left out: " + std::to_string(count) + ".");
  };
  note("with a NaN or an infinity", left_out.not_finite);
  note("whose quaternion is no rotation", left_out.no_rotation);
}

void note_dropped_signs(std::uint64_t count, const char* done, std::vector<std::string>& notes) {
  if (count == 0) return;
  notes.push_back(std::string("Scales below 0 are ") + done +
                  " without their sign, of Gaussians: " + std::to_string(count) + ".");
}

}  // namespace swiftgs::io
