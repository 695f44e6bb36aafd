// SPDX-License-Identifier: Apache-2.0
#include "loss_meter.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <string_view>

#include <glm/geometric.hpp>

#include <swiftgs/message.hpp>

#include "scene_building.hpp"

namespace swiftgs::io {

void LossMeter::add_position(std::size_t i, const vec3& found) {
  constexpr float least_shown = 1.0f / 255;
  const double moved = glm::distance(dvec3(scene_.means[i]), dvec3(found));
  if (moved == 0) return;
  const vec3& scale = scene_.scales[i];
  if (moved > double(std::max({scale.x, scale.y, scale.z})) && scene_.opacities[i] >= least_shown)
    ++displaced_;
  if (moved < position_.load(std::memory_order_relaxed)) return;
  const std::scoped_lock lock(mutex_);
  if (moved < position_ || (moved == position_ && i >= farthest_)) return;
  position_ = moved, farthest_ = i;
}

void LossMeter::add_scales(std::size_t i, const vec3& found) {
  for (int axis = 0; axis < 3; ++axis) {
    const double from = scene_.scales[i][axis];
    if (!(from > 0)) continue;
    const double ratio = double(std::max(found[axis], std::numeric_limits<float>::min())) / from;
    raise(scale_, std::max(ratio, 1 / ratio));
  }
}

void LossMeter::add_opacity(std::size_t i, float found) {
  raise(opacity_, std::abs(double(scene_.opacities[i]) - double(found)));
}

void LossMeter::add_colour(std::size_t i, const vec3& found) {
  const dvec3 apart = glm::abs(dvec3(scene_.sh0[i]) - dvec3(found));
  raise(colour_, sh_c0 * std::max({apart.x, apart.y, apart.z}));
}

std::size_t LossMeter::number_in_whole(std::size_t i) const {
  if (scene_.size() == whole_.size()) return i;
  for (std::size_t number = 0;; ++number)
    if (fault_of(whole_, number) == Fault::none && i-- == 0) return number;
}

LargestLosses LossMeter::losses() const {
  if (scene_.size() == 0) return {};
  return {.position = position_,
          .gaussian = number_in_whole(farthest_),
          .displaced = displaced_,
          .scale = scale_,
          .opacity = opacity_,
          .colour = colour_};
}

std::optional<std::string> LossMeter::sentence() const {
  const LargestLosses found = losses();
  if (found.displaced == 0) return std::nullopt;
  char digits[32];
  const auto end = std::to_chars(digits, std::end(digits), found.position, std::chars_format::general, 3).ptr;
  return swiftgs::detail::message(
      "Positions move by up to ", std::string_view(digits, end), " units (Gaussian ", found.gaussian,
      "). Gaussians that move by more than their longest scale: ", found.displaced, ".");
}

}  // namespace swiftgs::io

namespace swiftgs {

std::string text_of(const LargestLosses& losses) {
  std::string text;
  const auto add = [&](const char* format, double loss, double none) {
    char part[64];
    std::snprintf(part, sizeof part, format, loss);
    if (loss > none) text += (text.empty() ? "" : ", ") + std::string(part);
  };
  add("positions by %.3g units", losses.position, 0);
  add("scales by a factor of %.4g", losses.scale, 1);
  add("opacities by %.3g", losses.opacity, 0);
  add("colours by %.3g", losses.colour, 0);
  return text;
}

}  // namespace swiftgs
