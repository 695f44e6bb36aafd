// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "gltf_buffers.hpp"

namespace swiftgs::io {

/// Vectors of numbers in a buffer.
struct GltfAccessor {
  /// glTF's numbers for the types of components.
  enum Type { i8 = 5120, u8 = 5121, i16 = 5122, u16 = 5123, f32 = 5126 };

  const std::byte* data = nullptr;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  Type type = f32;
  bool normalised = false;
  std::uint64_t offset = 0;  ///< of its JSON, for errors
};

/// Accessor `index`, which has `components` components and lies inside its buffer. `user` is what refers to
/// it, by the name `attribute`.
GltfAccessor find_accessor(const GltfDocument& document, GltfBuffers& buffers, std::uint64_t index,
                           const JsonEntry& user, const std::string& attribute, int components);

/// Calls `store(i, numbers)` for vectors [begin, end), integers as glTF converts them to floats. The accessor
/// has `Components` components.
template <int Components, class Store>
void for_vectors(const GltfAccessor& accessor, std::size_t begin, std::size_t end, const Store& store) {
  const auto all = [&]<class T>(T, float unit) {
    float numbers[Components];
    for (std::size_t i = begin; i < end; ++i) {
      const std::byte* at = accessor.data + i * accessor.stride;
      for (int c = 0; c < Components; ++c) {
        numbers[c] = float(load<T>(at + std::size_t(c) * sizeof(T)));
        // Division, as the reciprocal of the largest integer would not make it 1. The least is below -1.
        if (unit != 0) numbers[c] = std::max(numbers[c] / unit, -1.0f);
      }
      store(i, numbers);
    }
  };
  const auto unit = [&](float largest) { return accessor.normalised ? largest : 0.0f; };
  switch (accessor.type) {
    case GltfAccessor::i8:
      return all(std::int8_t(), unit(127));
    case GltfAccessor::u8:
      return all(std::uint8_t(), unit(255));
    case GltfAccessor::i16:
      return all(std::int16_t(), unit(32767));
    case GltfAccessor::u16:
      return all(std::uint16_t(), unit(65535));
    case GltfAccessor::f32:
      return all(float(), 0);
  }
}

}  // namespace swiftgs::io
