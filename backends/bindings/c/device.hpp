// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/memory/scene_arrays.hpp>

/// @file
/// What needs a device: one of CUDA, but for frames and updates of `vulkan`. A build without CUDA has no
/// device.

namespace swiftgs::c {

/// Throws `Unavailable`, which names `what` is needed for, if there is no device that this build can
/// use.
void require_device(const char* what);

// Of the current device, after `require_device`. Throw `DeviceError`, and `CapacityError` without memory.
int current_device();
void* allocate_memory(std::size_t bytes);
void free_memory(void* memory);
/// Copies between host and device in the order of `stream`, and waits for the copy.
void copy_memory(void* to, const void* from, std::size_t bytes, void* stream);
/// Work that `after` is given from now on waits for the work that `before` has now.
void order_streams(void* before, void* after);

/// Frames of a device's renderer whose planes lie in the host's memory.
class HostFrames {
 public:
  virtual ~HostFrames() = default;

  /// As `AnyRenderer::render_into`; complete when it returns.
  virtual void render_into(AnyRenderer& renderer, Span<const View> views, Measures measures) = 0;
  virtual std::size_t bytes() const = 0;
  virtual void trim() = 0;
};

/// For renderers of `cuda` or `vulkan` that are made with `options`. Null in a build without the backend.
std::unique_ptr<HostFrames> make_cuda_frames(const BackendOptions& options);
std::unique_ptr<HostFrames> make_vulkan_frames(const BackendOptions& options);

/// `AnyRenderer::update_scene` of a renderer of `vulkan`, by arrays in the host's memory.
void update_vulkan_scene(AnyRenderer& renderer, std::size_t scene, std::size_t first, SceneArrays arrays);

}  // namespace swiftgs::c
