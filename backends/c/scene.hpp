// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <swiftgs/c/scene.h>
#include <swiftgs/camera.hpp>
#include <swiftgs/scene.hpp>

struct swiftgs_scene {
  std::shared_ptr<const swiftgs::Scene> scene;
  std::string format{};
  std::uint64_t stored = 0, dropped = 0;
  std::optional<swiftgs::Camera> camera{};
};

namespace swiftgs::c {

/// Copies the arrays of a caller. Throws `InvalidArgument`, and as `require_device` and `copy_memory`.
Scene to_scene(const swiftgs_gaussians* given);

}  // namespace swiftgs::c
