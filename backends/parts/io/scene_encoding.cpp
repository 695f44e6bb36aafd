// SPDX-License-Identifier: Apache-2.0

#include "scene_encoding.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <string_view>

#include <glm/geometric.hpp>

#include <swiftgs/error.hpp>

#include "scene_building.hpp"
#include "tasks.hpp"

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

namespace swiftgs::io {
namespace {

bool has_negative_scale(const Scene& scene, std::size_t i) {
  const vec3& scale = scene.scales[i];
  return scale.x < 0 || scale.y < 0 || scale.z < 0;
}

}  // namespace

std::optional<Scene> encodable(const Scene& scene, std::vector<std::string>& notes) {
  std::vector<Fault> faults(scene.size());
  std::atomic<std::uint64_t> invalid = 0, opacities = 0, negative = 0;
  for_parts(scene.size(), [&](std::size_t begin, std::size_t end) {
    std::uint64_t own_invalid = 0, own_opacities = 0, own_negative = 0;
    for (std::size_t i = begin; i < end; ++i) {
      faults[i] = fault_of(scene, i);
      own_invalid += faults[i] != Fault::none;
      if (faults[i] != Fault::none) continue;
      own_opacities += scene.opacities[i] < 0 || scene.opacities[i] > 1;
      own_negative += has_negative_scale(scene, i);
    }
    invalid += own_invalid, opacities += own_opacities, negative += own_negative;
  });
  if (invalid + opacities + negative == 0) return std::nullopt;

  Scene result = scene;
  note_left_out(leave_out(result, faults), notes);
  note_clamped(opacities, "Opacities", "0 to 1", notes);
  note_dropped_signs(negative, "written", notes);
  for (float& opacity : result.opacities) opacity = std::clamp(opacity, 0.0f, 1.0f);
  for (vec3& scale : result.scales) scale = glm::abs(scale);
  return result;
}

WrittenScene written_whole(std::string format, const Scene& scene) {
  return {.format = std::move(format),
          .gaussians = scene.size(),
          .sh_degree = scene.sh_degree,
          .model = scene.model};
}

void note_clamped(std::uint64_t count, const std::string& things, const std::string& range,
                  std::vector<std::string>& notes) {
  if (count != 0) notes.push_back(things + " are clamped to " + range + ": " + std::to_string(count) + ".");
}

}  // namespace swiftgs::io
