// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// Throws `FormatError` that names the camera model, the distortion or the lens, unless the camera is a
/// pinhole.
void expect_pinhole(const CameraEntry& entry);

/// Collects the keys of a camera file that nobody reads.
class UnreadKeys {
 public:
  /// `read` are the keys that the reader takes, and those that no picture shows.
  explicit UnreadKeys(std::span<const std::string_view> read) : read_(read) {}

  /// Adds the keys of `entry` that may change the picture: neither read, nor part of a pinhole's check, nor
  /// switched off by 0, false, null or an empty value.
  void add(const JsonEntry& entry);

  void note(std::vector<std::string>& notes) const;

 private:
  std::span<const std::string_view> read_;
  std::set<std::string> keys_;
};

}  // namespace swiftgs::io
