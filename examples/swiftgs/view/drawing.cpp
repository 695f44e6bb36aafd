// SPDX-License-Identifier: Apache-2.0
#include "view/drawing.hpp"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "draw/plane_pictures.hpp"

namespace swiftgs::cli {
namespace {

std::size_t size_of(const ShownScene& shown) {
  return std::min(shown.placement.count, shown.gaussians->size() - shown.placement.first);
}

void require_gaussians(const ShownScene& shown) {
  if (shown.gaussians->size() == 0)
    throw std::invalid_argument(shown.name + ": expected a Gaussian or more to show, found none");
}

}  // namespace

Drawing::Drawing(const std::string& renderer, const RenderSettings& settings, std::vector<ShownScene> shown)
    : renderer_(make_renderer(renderer)), settings_(settings) {
  settings_.time = true;
  for (ShownScene& scene : shown) add(std::move(scene));
}

void Drawing::use(const std::string& renderer) {
  std::unique_ptr<AnyRenderer> other = make_renderer(renderer);
  if (!other->share_scene(*renderer_))
    for (const auto& scene : uploaded_) other->add_scene(scene);
  const std::vector<Placement> now = placements();
  other->place({now.data(), now.size()});
  renderer_ = std::move(other), apart_.reset();
}

void Drawing::add(ShownScene shown) {
  require_gaussians(shown);
  const auto known = std::find(uploaded_.begin(), uploaded_.end(), shown.gaussians);
  shown.placement.scene = std::size_t(known - uploaded_.begin());
  if (known == uploaded_.end()) {
    renderer_->add_scene(shown.gaussians);
    uploaded_.push_back(shown.gaussians);
  }
  scenes.push_back(std::move(shown));
  place();
}

std::vector<ShownScene> Drawing::visible() const {
  std::vector<ShownScene> visible;
  for (const ShownScene& scene : scenes)
    if (scene.visible) visible.push_back(scene);
  return visible;
}

std::vector<Placement> Drawing::placements() const {
  std::vector<Placement> placements;
  for (const ShownScene& scene : visible()) placements.push_back(scene.placement);
  // A frame needs a placed scene, though it show none of its Gaussians.
  if (placements.empty()) placements.push_back({.count = 0});
  return placements;
}

void Drawing::place() {
  const std::vector<Placement> now = placements();
  renderer_->place({now.data(), now.size()});
  ++version_;
}

void Drawing::show_plane(std::string_view name) {
  plane_ = name;
  settings_.outputs = {};
  for_each_plane(
      [&]<class Wanted>(std::size_t, std::string_view known, Wanted& wanted) {
        if constexpr (std::is_same_v<Wanted, bool>)
          if (known == name) wanted = true;
      },
      plane_names, settings_.outputs);
}

void Drawing::draw(const Camera& camera, bool count) {
  RenderSettings settings = settings_;
  settings.count = count;
  renderer_->render(camera, settings, frame_);
  if (!plane_.empty()) plane_picture_ = std::move(pictures_of_planes(frame_).at(0).picture);
}

std::optional<Picked> Drawing::pick(int x, int y) {
  const PickedPixel found = renderer_->pick(x, y);
  std::size_t number = found.gaussian;
  if (found.gaussian == PickedPixel::nothing) return std::nullopt;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    if (!scenes[i].visible) continue;
    if (number < size_of(scenes[i]))
      return Picked{i, scenes[i].placement.first + number, found.weight, found.depth};
    number -= size_of(scenes[i]);
  }
  return std::nullopt;
}

std::vector<float> Drawing::draw_apart(const Camera& camera) {
  if (!apart_) apart_ = make_renderer(renderer_->name());
  apart_->share_scene(*renderer_);
  RenderSettings colour = settings_;
  colour.outputs = {};
  Frame frame;
  apart_->render(camera, colour, frame);
  return std::move(frame.colour);
}

}  // namespace swiftgs::cli
