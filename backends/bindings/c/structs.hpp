// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include <swiftgs/c/camera.h>
#include <swiftgs/c/pages.h>
#include <swiftgs/c/renderer.h>
#include <swiftgs/c/scene.h>
#include <swiftgs/c/view.h>

#include "error.hpp"

/// @file
/// Structs that begin with their size, so that programs and libraries of different age understand each other.

namespace swiftgs::c {

/// The size of `T` in the first version that had it: no program has a smaller one. Specialise it for a struct
/// that grows.
template <class T>
inline constexpr std::uint32_t first_size = sizeof(T);

template <>
inline constexpr std::uint32_t first_size<swiftgs_camera> = offsetof(swiftgs_camera, radial);
template <>
inline constexpr std::uint32_t first_size<swiftgs_conventions> = offsetof(swiftgs_conventions, depth);
template <>
inline constexpr std::uint32_t first_size<swiftgs_gaussians> = offsetof(swiftgs_gaussians, features);
template <>
inline constexpr std::uint32_t first_size<swiftgs_scene_info> = offsetof(swiftgs_scene_info, origin);
template <>
inline constexpr std::uint32_t first_size<swiftgs_image> = offsetof(swiftgs_image, squared_depth);
template <>
inline constexpr std::uint32_t first_size<swiftgs_placement> = offsetof(swiftgs_placement, first);
template <>
inline constexpr std::uint32_t first_size<swiftgs_recorded_scenes> = offsetof(swiftgs_recorded_scenes, tint);
template <>
inline constexpr std::uint32_t first_size<swiftgs_view> = offsetof(swiftgs_view, stored_depth);
template <>
inline constexpr std::uint32_t first_size<swiftgs_renderer_options> = offsetof(swiftgs_renderer_options,
                                                                               harmonics);
template <>
inline constexpr std::uint32_t first_size<swiftgs_renderer_entry> = offsetof(swiftgs_renderer_entry,
                                                                             on_device);
template <>
inline constexpr std::uint32_t first_size<swiftgs_pool_options> = offsetof(swiftgs_pool_options, estimate);
template <>
inline constexpr std::uint32_t first_size<swiftgs_cut_goal> = offsetof(swiftgs_cut_goal, blend);
template <>
inline constexpr std::uint32_t first_size<swiftgs_cut> = offsetof(swiftgs_cut, estimated_db);

namespace detail {
template <class T>
std::uint32_t size_of(const T* given, const char* what) {
  static_assert(std::is_trivially_copyable_v<T> && offsetof(T, size) == 0);
  require_pointer(given, what);
  std::uint32_t size = 0;
  std::memcpy(&size, given, sizeof(size));  // the caller's struct may be smaller than T
  if (size < first_size<T>) refuse(what, ": size is ", size, ", expected ", sizeof(T), ", the struct's size");
  return size;
}
}  // namespace detail

/// A struct of the caller's. What an older program does not have is as in `defaults`. Throws
/// `InvalidArgument` for an impossible size, or if a newer program sets a member unknown here.
template <class T>
T read_struct(const T* given, const char* what, T defaults = {}) {
  const std::uint32_t size = detail::size_of(given, what);
  const auto* const bytes = reinterpret_cast<const unsigned char*>(given);
  for (std::size_t i = sizeof(T); i < size; ++i)
    if (bytes[i] != 0)
      refuse(what, ": byte ", i, " is ", bytes[i],
             ", expected 0: the program is newer than the library, whose struct has ", sizeof(T), " bytes");
  std::memcpy(&defaults, given, std::min<std::size_t>(size, sizeof(T)));
  defaults.size = sizeof(T);
  return defaults;
}

/// As `read_struct`; NULL stands for the defaults.
template <class T>
T read_options(const T* given, const char* what) {
  return given ? read_struct(given, what) : T{};
}

/// Throws as `write_struct`, before work is done in vain.
template <class T>
void check_struct(const T* given, const char* what) {
  detail::size_of(given, what);
}

/// Fills a struct of the caller's, whose size stays. What a newer program has beside is zero.
template <class T>
void write_struct(T* given, T value, const char* what) {
  const std::uint32_t size = detail::size_of(given, what);
  value.size = size;
  std::memcpy(given, &value, std::min<std::size_t>(size, sizeof(T)));
  auto* const bytes = reinterpret_cast<unsigned char*>(given);
  if (size > sizeof(T)) std::memset(bytes + sizeof(T), 0, size - sizeof(T));
}

/// f(element) for each of `count` structs of the caller's, which all have the first one's size.
template <class T, class F>
void for_each_struct(const T* first, std::uint64_t count, const char* what, const F& f) {
  if (count == 0) return;
  const std::uint32_t size = detail::size_of(first, what);
  const auto* bytes = reinterpret_cast<const unsigned char*>(first);
  for (std::uint64_t i = 0; i < count; ++i, bytes += size) {
    std::uint32_t found = 0;
    std::memcpy(&found, bytes, sizeof(found));
    if (found != size)
      refuse(what, ": size of number ", i, " is ", found, ", expected that of the first, ", size);
    f(read_struct(reinterpret_cast<const T*>(bytes), what));
  }
}

}  // namespace swiftgs::c
