// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The core: types, policies, the serial backend and the renderer. Other backends and file formats are
/// included on their own: `<swiftgs/cpu.hpp>`, `<swiftgs/io/scene_file.hpp>`, ...

#include <bit>

#include <swiftgs/bounds/all.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/raster/all.hpp>
#include <swiftgs/renderer.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/sort/all.hpp>
#include <swiftgs/version.hpp>

static_assert(std::endian::native == std::endian::little,
              "SwiftGS: expected a little-endian processor: readers and pixels of 8 bits rely on it");
