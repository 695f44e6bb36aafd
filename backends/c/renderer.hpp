// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <swiftgs/any_renderer.hpp>
#include <swiftgs/c/renderer.h>
#include <swiftgs/view.hpp>

#include "device.hpp"
#include "error.hpp"

struct swiftgs_renderer {
  std::string name, device_name;
  std::unique_ptr<swiftgs::AnyRenderer> renderer;
  std::unique_ptr<swiftgs::c::HostFrames> host_frames{};  ///< null: the backend reaches the host's memory
  void* stream = nullptr;                                 ///< of a device
  swiftgs::HarmonicsKept harmonics{};                     ///< of scenes that are uploaded
  std::vector<swiftgs::View> views{};                     ///< of one call; their memory is kept
  mutable std::recursive_mutex turn{};  ///< of calls; a memory hook may ask the renderer that called it
};

namespace swiftgs::c {

/// A renderer while it is the turn of this call.
class Turn {
 public:
  explicit Turn(const swiftgs_renderer& renderer) : lock_(renderer.turn), renderer_(*renderer.renderer) {}
  AnyRenderer* operator->() const { return &renderer_; }
  AnyRenderer& operator*() const { return renderer_; }

 private:
  std::unique_lock<std::recursive_mutex> lock_;
  AnyRenderer& renderer_;
};

inline Turn of(const swiftgs_renderer* renderer) {
  require_pointer(renderer, "renderer");
  return Turn(*renderer);
}

}  // namespace swiftgs::c
