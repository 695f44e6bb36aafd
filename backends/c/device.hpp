// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

#include <swiftgs/any_renderer.hpp>

/// @file
/// What needs a device. A build without CUDA has no device.

namespace swiftgs::c {

/// Throws `std::runtime_error` if there is no device that this build can use.
void require_device();

/// Copies in the order of `stream`, and waits for the copy. Throws `DeviceError`.
void copy_from_device(const void* from, std::size_t bytes, void* stream, void* to);

/// Frames of a device's renderer whose planes lie in the host's memory.
class HostFrames {
 public:
  virtual ~HostFrames() = default;

  /// As `AnyRenderer::render_into`; complete when it returns.
  virtual void render_into(AnyRenderer& renderer, Span<const View> views, Measures measures) = 0;
  virtual std::size_t bytes() const = 0;
  virtual void trim() = 0;
};

/// For renderers that are made with `options`. Null in a build without CUDA.
std::unique_ptr<HostFrames> make_host_frames(const BackendOptions& options);

}  // namespace swiftgs::c
