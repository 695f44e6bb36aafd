// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/scene_view.hpp>
#include <swiftgs/memory/growing_buffer.hpp>

namespace swiftgs {

/// Memory of the current device. `allocate` throws `CapacityError` where there is not enough of it.
struct SWIFTGS_API DeviceMemory {
  static void* allocate(std::size_t bytes);
  static void release(void* memory);
};

/// Uninitialised device memory that grows, and shrinks by `trim` alone. Both wait for the device, unless the
/// buffer has a hook that does not.
template <class T>
using DeviceBuffer = GrowingBuffer<T, DeviceMemory>;

/// A scene in the memory of a device. Copies share it; `Cuda::update` alone changes it.
class DeviceScene {
 public:
  struct Arrays;
  DeviceScene(std::shared_ptr<Arrays> arrays, const SceneView& view)
      : arrays_(std::move(arrays)), view_(view) {}

  /// Arrays of the caller, which outlive all frames of it and may change between them, in stream order.
  static DeviceScene borrow(const SceneView& view) { return {nullptr, view}; }

  DeviceScene(const DeviceScene& other) : arrays_(other.arrays_), view_(other.view_), copied_(true) {
    other.copied_ = true;
  }
  DeviceScene(DeviceScene&& other) noexcept
      : arrays_(std::move(other.arrays_)), view_(other.view_), copied_(other.copied_.load()) {}
  DeviceScene& operator=(DeviceScene other) noexcept {
    arrays_.swap(other.arrays_), view_ = other.view_, copied_ = other.copied_.load();
    return *this;
  }
  ~DeviceScene() = default;

  SceneView view() const { return view_; }
  /// For the backend. Null of borrowed arrays.
  Arrays* arrays() { return arrays_.get(); }

  /// The memory of a scene that is given up; null if it was ever copied. Another stream may then still draw
  /// it, even if the copy is gone.
  static std::shared_ptr<Arrays> take(DeviceScene scene) {
    return scene.copied_ ? nullptr : std::move(scene.arrays_);
  }

 private:
  std::shared_ptr<Arrays> arrays_;
  SceneView view_;
  mutable std::atomic<bool> copied_{false};
};

}  // namespace swiftgs
