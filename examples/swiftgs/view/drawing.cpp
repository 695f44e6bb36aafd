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

/// Where `known` has the scene; behind its last one if it does not.
std::size_t number_of(const ShownScene& scene, const DrawnScenes& known) {
  const auto& all = known.gaussians;
  return std::size_t(std::find(all.begin(), all.end(), scene.gaussians) - all.begin());
}

/// Of each scene. The only place where a list's numbers become those of a frame.
std::vector<Placement> placements(const std::vector<ShownScene>& all, const DrawnScenes& known) {
  std::vector<Placement> placements;
  for (const ShownScene& scene : all)
    placements.push_back(placement_of(scene.listed, number_of(scene, known), scene.gaussians->origin,
                                      all[0].gaussians->origin));
  return placements;
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
      pool_options_(pages.pool()),
      goal_(pages.goal()) {
  settings_.time = true;
  add(std::move(shown));
}

void Drawing::use(const std::string& renderer) {
  std::unique_ptr<AnyRenderer> other = make_renderer(renderer);
  const std::vector<Placement> now = placements(scenes_, known_);
  std::unique_ptr<PageFrames> pages;
  if (pages_) {
    pages = page_frames(*other, known_, now);
  } else {
    if (!other->share_scene(*renderer_))
      for (const auto& scene : known_.gaussians) other->add_scene(scene);
    other->place({now.data(), now.size()});
  }
  pages_ = std::move(pages), renderer_ = std::move(other), apart_.reset();
}

void Drawing::add(std::vector<ShownScene> more) {
  for (const ShownScene& scene : more) require_gaussians(scene);
  DrawnScenes known = known_;
  for (const ShownScene& scene : more)
    if (number_of(scene, known) == known.gaussians.size())
      known.gaussians.push_back(scene.gaussians), known.pages.push_back(scene.pages);
  std::vector<ShownScene> all = scenes_;
  std::move(more.begin(), more.end(), std::back_inserter(all));
  const std::size_t before = known_.gaussians.size();
  if (known.has_pages()) {
    // The pages of before stay until the new ones are there: a renderer may show them if something throws.
    if (known.gaussians.size() != before) pages_ = page_frames(*renderer_, known, placements(all, known));
    known_ = std::move(known);
  } else {
    for (std::size_t i = before; i < known.gaussians.size(); ++i) {
      renderer_->add_scene(known.gaussians[i]);
      known_.gaussians.push_back(known.gaussians[i]), known_.pages.emplace_back();
    }
  }
  place(std::move(all));
}

void Drawing::change(std::size_t number, ListedScene listed) {
  std::vector<ShownScene> all = scenes_;
  all[number].listed = std::move(listed);
  place(std::move(all));
}

void Drawing::place(std::vector<ShownScene> all) {
  const std::vector<Placement> now = placements(all, known_);
  if (pages_)
    pages_->place(now);
  else
    renderer_->place({now.data(), now.size()});
  scenes_ = std::move(all);
  ++version_;
}

std::unique_ptr<PageFrames> Drawing::page_frames(AnyRenderer& renderer, DrawnScenes drawn,
                                                 std::vector<Placement> placements) const {
  drawn.placements = std::move(placements);
  return std::make_unique<PageFrames>(renderer, drawn, HarmonicsKept::smallest, pool_options_);
}

dvec3 Drawing::in_world(std::size_t scene, const dvec3& position) const {
  return scenes_[scene].listed.world_from_scene(position) - scenes_[0].gaussians->origin;
}

std::vector<PlacedGaussians> Drawing::visible() const {
  std::vector<PlacedGaussians> visible;
  const std::vector<Placement> now = placements(scenes_, known_);
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
  const std::vector<Placement> now = placements(scenes_, known_);
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
