// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>

#include "json_entry.hpp"

namespace swiftgs::io {

/// A camera of a JSON file, and the object around all cameras, whose members count where the camera has none
/// of its own.
struct CameraEntry {
  JsonEntry own, shared;

  /// Whichever has `key`; null if neither has.
  const JsonEntry* with(const char* key) const {
    return own.has(key) ? &own : shared.has(key) ? &shared : nullptr;
  }
};

/// The lens of a camera, by `camera_model`, instant-ngp's marks and the coefficients, each of which a camera
/// may have itself. Of FULL_OPENCV k4 to k6 are rational; elsewhere k4 is radial, as nerfstudio has it.
/// Throws `FormatError` that names the model, the coefficient or the mark that `Lens` cannot be.
Lens lens_of(const CameraEntry& entry);

/// The focal length with which an image side shows the angle in `key`.
double length_of_angle(const JsonEntry& entry, const char* key, double to_radians, int side);

/// Collects the keys of a camera file that nobody reads.
class UnreadKeys {
 public:
  /// `read` are the keys that the reader takes, and those that no picture shows.
  explicit UnreadKeys(std::span<const std::string_view> read) : read_(read) {}

  /// Adds the keys of `entry` that may change the picture: neither read, nor of a lens, nor switched off by
  /// 0, false, null or an empty value.
  void add(const JsonEntry& entry);

  void add(const std::string& key) { keys_.insert(key); }

  void note(std::vector<std::string>& notes) const;

 private:
  std::span<const std::string_view> read_;
  std::set<std::string> keys_;
};

}  // namespace swiftgs::io
