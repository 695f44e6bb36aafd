// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
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
  std::vector<swiftgs::View> views{};                     ///< of one call; their memory is kept
};

namespace swiftgs::c {

inline AnyRenderer& of(const swiftgs_renderer* renderer) {
  require_pointer(renderer, "renderer");
  return *renderer->renderer;
}

}  // namespace swiftgs::c
