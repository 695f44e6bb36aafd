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

Picked picked(std::size_t scene, const Scene& gaussians, std::size_t i, std::string name,
              const PickedPixel& found) {
  return {.scene = scene,
          .name = std::move(name),
          .position = gaussians.origin + dvec3(gaussians.means[i]),
          .scale = gaussians.scales[i],
          .opacity = gaussians.opacities[i],
          .weight = found.weight,
          .depth = found.depth};
}

/// Reads the page again: it may lie on a device.
Picked picked(std::size_t scene, const PagedScene& pages, const NamedNode& node, const PickedPixel& found) {
  const PageContent content = pages.read(node.page);
  const std::string number = std::to_string(node.number);
  if (!node.is_gaussian)
    return picked(scene, content.scene, node.number,
                  "Node " + number + " of page " + std::to_string(node.page), found);
  const std::size_t i =
      content.ids.empty()
          ? node.number - pages.pages()[node.page].first
          : std::size_t(std::find(content.ids.begin(), content.ids.end(), node.number) - content.ids.begin());
  return picked(scene, content.scene, i, "Gaussian " + number, found);
}

}  // namespace

std::string ShownScene::name() const {
  const std::filesystem::path whole = std::filesystem::path(listed.file).lexically_normal();
  const std::filesystem::path path = whole.has_filename() ? whole : whole.parent_path();  // of a folder
  return path.filename().string();
}

Drawing::Drawing(const std::string& renderer, const RenderSettings& settings, const PageOptions& pages,
                 std::vector<ShownScene> shown)
    : renderer_(make_renderer(renderer)),
      settings_(settings),
      page_bytes_(pages.bytes()),
      goal_(pages.goal()) {
  settings_.time = true;
  add(std::move(shown));
}

void Drawing::use(const std::string& renderer) {
  std::unique_ptr<AnyRenderer> other = make_renderer(renderer);
  const std::vector<Placement> now = placements(scenes_);
  std::unique_ptr<PageFrames> pages;
  if (known_.has_pages()) {
    pages = page_frames(*other, now);
  } else {
    if (!other->share_scene(*renderer_))
      for (const auto& scene : known_.gaussians) other->add_scene(scene);
    other->place({now.data(), now.size()});
  }
  pages_ = std::move(pages), renderer_ = std::move(other), apart_.reset();
}

void Drawing::add(std::vector<ShownScene> more) {
  for (const ShownScene& scene : more) require_gaussians(scene);
  for (const ShownScene& scene : more) {
    if (std::find(known_.gaussians.begin(), known_.gaussians.end(), scene.gaussians) !=
        known_.gaussians.end())
      continue;
    if (!scene.pages && !pages_) renderer_->add_scene(scene.gaussians);
    known_.gaussians.push_back(scene.gaussians), known_.pages.push_back(scene.pages);
    pages_.reset();
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
  if (!known_.has_pages())
    renderer_->place({now.data(), now.size()});
  else if (pages_)
    pages_->place(now);
  else
    pages_ = page_frames(*renderer_, now);
  scenes_ = std::move(all);
  ++version_;
}

std::unique_ptr<PageFrames> Drawing::page_frames(AnyRenderer& renderer,
                                                 std::vector<Placement> placements) const {
  DrawnScenes drawn = known_;
  drawn.placements = std::move(placements);
  return std::make_unique<PageFrames>(renderer, drawn, HarmonicsKept::smallest, page_bytes_);
}

std::vector<Placement> Drawing::placements(const std::vector<ShownScene>& all) const {
  std::vector<Placement> placements;
  for (const ShownScene& scene : all) {
    const auto known = std::find(known_.gaussians.begin(), known_.gaussians.end(), scene.gaussians);
    placements.push_back(placement_of(scene.listed, std::size_t(known - known_.gaussians.begin()),
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
  if (pages_) pages_->show({&camera, 1}, settings, goal_);
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
  if (pages_ && number < pages_->cut().splats()) {
    const NamedNode node = pages_->cut().named(found.gaussian);
    const std::size_t scene = pages_->placement_of(node.scene);
    return picked(scene, *scenes_[scene].pages, node, found);
  }
  if (pages_) number -= pages_->cut().splats();
  const std::vector<Placement> now = placements(scenes_);
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (scenes_[i].pages) continue;  // they come first
    const std::size_t size = std::min(now[i].count, scenes_[i].gaussians->size() - now[i].first);
    if (number < size)
      return picked(i, *scenes_[i].gaussians, now[i].first + number,
                    "Gaussian " + std::to_string(now[i].first + number), found);
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
