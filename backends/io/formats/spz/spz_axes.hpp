// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/math.hpp>

#include "axis_flip.hpp"

/// @file
/// The sixteen coordinate systems of SPZ.

namespace swiftgs::io {

/// How numbers in the axes of an SPZ file become RDF: systems with z up or down are turned a quarter about x
/// first, which makes y their vertical axis, and then all are flipped.
struct SpzAxes {
  AxisFlip flip{};
  bool quarter_turn = false;

  bool operator==(const SpzAxes&) const = default;

  vec3 position(vec3 p) const { return flip.position(quarter_turn ? vec3(p.x, p.z, -p.y) : p); }

  Quaternion rotation(Quaternion q) const {
    constexpr float h = 0.70710678f;
    if (quarter_turn) q = {h * (q.w + q.x), h * (q.x - q.w), h * (q.y + q.z), h * (q.z - q.y)};
    return flip.rotation(q);
  }

  /// What `position` multiplies by.
  dmat3 matrix() const {
    return dmat3(dvec3(position({1, 0, 0})), dvec3(position({0, 1, 0})), dvec3(position({0, 0, 1})));
  }
};

/// By the numbers that SPZ gives them. The letters tell where +x, +y, +z point.
inline constexpr std::array<std::string_view, 17> spz_system_names = {
    "unspecified", "LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF",
    "LFD",         "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};

/// The axes of coordinate system 1 to 16. None for any other.
///
/// LFD, RFD, LBU and RBU do not follow their letters: Niantic's library, which writes such files, stores
/// under these names what the letters say turned by 180 degrees about x. So it is read.
inline std::optional<SpzAxes> axes_of_spz_system(std::uint32_t system) {
  if (system < 1 || system > 16) return std::nullopt;
  const auto bit = [&](int i) { return (system - 1) >> i & 1; };
  const float x = bit(0) ? 1.0f : -1.0f, second = bit(1) ? -1.0f : 1.0f, third = bit(2) ? 1.0f : -1.0f;
  if (system <= 8) return SpzAxes{{x, second, third}};
  return SpzAxes{{x, third, second}, true};
}

/// What a frame turns into RDF by; the same turns RDF into it.
inline AxisFlip flip_of(SpzFrame frame) {
  switch (frame) {
    case SpzFrame::luf:
      return luf_to_rdf;
    case SpzFrame::rdf:
    case SpzFrame::raw:
      return {};
    case SpzFrame::specified:
    case SpzFrame::rub:
      break;
  }
  return rub_to_rdf;
}

}  // namespace swiftgs::io
