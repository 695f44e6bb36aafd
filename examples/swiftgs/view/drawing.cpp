// SPDX-License-Identifier: Apache-2.0
#include "view/drawing.hpp"

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "read/placed_input.hpp"
#include "read/views.hpp"

namespace swiftgs::cli {
namespace {

void require_gaussians(const ShownScene& shown) {
  if (shown.gaussians->size() == 0)
    throw std::invalid_argument(shown.listed.file + ": expected a Gaussian or more to show, found none");
}

}  // namespace

std::string ShownScene::name() const {
  const std::filesystem::path whole = std::filesystem::path(listed.file).lexically_normal();
  const std::filesystem::path path = whole.has_filename() ? whole : whole.parent_path();  // of a folder
  return path.filename().string();
}

Drawing::Drawing(const std::string& renderer, const RenderSettings& settings, std::vector<ShownScene> shown)
    : renderer_(make_renderer(renderer)), settings_(settings) {
  settings_.time = true;
  add(std::move(shown));
}

void Drawing::use(const std::string& renderer) {
  std::unique_ptr<AnyRenderer> other = make_renderer(renderer);
  if (!other->share_scene(*renderer_))
    for (const auto& scene : uploaded_) other->add_scene(scene);
  const std::vector<Placement> now = placements(scenes_);
  other->place({now.data(), now.size()});
  renderer_ = std::move(other), apart_.reset();
}

void Drawing::add(std::vector<ShownScene> more) {
  for (const ShownScene& scene : more) require_gaussians(scene);
  for (const ShownScene& scene : more) {
    if (std::find(uploaded_.begin(), uploaded_.end(), scene.gaussians) != uploaded_.end()) continue;
    renderer_->add_scene(scene.gaussians);
    uploaded_.push_back(scene.gaussians);
  }
  std::vector<ShownScene> all = scenes_;
  std::move(more.begin(), more.end(), std::back_inserter(all));
  place(std::move(all));
}

void Drawing::change(std::size_t number, ListedScene listed) {
  std::vector<ShownScene> all = scenes_;
  all[number].listed = std::move(listed);
  place(std::move(all));
}

void Drawing::place(std::vector<ShownScene> all) {
  const std::vector<Placement> now = placements(all);
  renderer_->place({now.data(), now.size()});
  scenes_ = std::move(all);
  ++version_;
}

std::vector<Placement> Drawing::placements(const std::vector<ShownScene>& all) const {
  std::vector<Placement> placements;
  for (const ShownScene& scene : all) {
    const auto uploaded = std::find(uploaded_.begin(), uploaded_.end(), scene.gaussians);
    placements.push_back(placement_of(scene.listed, std::size_t(uploaded - uploaded_.begin()),
                                      scene.gaussians->origin, all[0].gaussians->origin));
  }
  return placements;
}

dvec3 Drawing::in_world(std::size_t scene, const dvec3& position) const {
  return scenes_[scene].listed.world_from_scene(position) - scenes_[0].gaussians->origin;
}

std::vector<PlacedGaussians> Drawing::visible() const {
  std::vector<PlacedGaussians> visible;
  const std::vector<Placement> now = placements(scenes_);
  for (std::size_t i = 0; i < now.size(); ++i)
    if (scenes_[i].listed.visible) visible.push_back({scenes_[i].gaussians, now[i]});
  return visible;
}

void Drawing::show_plane(std::string_view name) {
  plane_ = name;
  settings_.outputs = planes_of(plane_);
}

void Drawing::draw(const Camera& camera, bool count) {
  RenderSettings settings = settings_;
  settings.count = count;
  renderer_->render(camera, settings, frame_);
  depth_range_.reset();
  if (plane_.empty()) return;
  PlanePicture shown = picture_of_plane(frame_);
  plane_picture_ = std::move(shown.picture), depth_range_ = shown.range;
}

std::optional<Picked> Drawing::pick(int x, int y) {
  const PickedPixel found = renderer_->pick(x, y);
  std::size_t number = found.gaussian;
  if (found.gaussian == PickedPixel::nothing) return std::nullopt;
  const std::vector<Placement> now = placements(scenes_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    const std::size_t size = std::min(now[i].count, scenes_[i].gaussians->size() - now[i].first);
    if (number < size) return Picked{i, now[i].first + number, found.weight, found.depth};
    number -= size;
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
