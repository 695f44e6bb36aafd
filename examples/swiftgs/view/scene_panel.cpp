// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include <glm/common.hpp>
#include <imgui.h>

#include <swiftgs/io/scene_list.hpp>
#include <swiftgs/tools/scene_bounds.hpp>

#include "view/angles.hpp"
#include "view/panels.hpp"

namespace swiftgs::cli {
namespace {

/// Moves, turns and scales a scene, in numbers of lists. It turns where it stands: around its `origin`.
bool pose_panel(ListedScene& scene, const dvec3& origin, double step) {
  Similarity& pose = scene.world_from_scene;
  bool edited = drag("place", pose.translation, step);
  const dvec3 stands = pose(origin);
  dvec3 angles = angles_of(pose.rotation);
  bool turned = drag("angles", angles, 0.5);
  if (turned) pose.rotation = rotation_of(angles);
  turned |= slide("scale", pose.scale, 0.01, 100, "%.3g", true);
  if (turned) pose.translation += stands - pose(origin), edited = true;
  return edited;
}

/// The box that shows of a scene, in numbers of its file.
bool clip_panel(ListedScene& scene, const Scene& gaussians) {
  std::optional<Box> box = box_of(scene.half_spaces);
  bool is_clipped = box.has_value();
  if (ImGui::Checkbox("clip by a box", &is_clipped)) {
    const SceneBounds bounds = robust_bounds(gaussians);
    const Box all{gaussians.origin + bounds.low, gaussians.origin + bounds.high};
    scene.half_spaces = is_clipped ? half_spaces_of(all) : std::vector<HalfSpace>();
    return true;
  }
  if (!box && !scene.half_spaces.empty()) ImGui::Text("clipped by %zu half-spaces", scene.half_spaces.size());
  if (scene.sphere) ImGui::TextUnformatted("clipped by a sphere");
  if (!box) return false;
  const dvec3 size = box->high - box->low;
  const double step = std::max(0.002 * std::max({size.x, size.y, size.z}), 1e-6);
  bool edited = false;
  if (drag("from", box->low, step)) box->low = glm::min(box->low, box->high), edited = true;
  if (drag("to", box->high, step)) box->high = glm::max(box->low, box->high), edited = true;
  if (edited) scene.half_spaces = half_spaces_of(*box);
  return edited;
}

/// Shows the scene's line and, where it is open, its numbers. Returns whether they changed.
bool edit(ListedScene& scene, const ShownScene& shown, bool is_picked, double step) {
  bool edited = ImGui::Checkbox("##visible", &scene.visible);
  ImGui::SameLine();
  const std::string name = shown.name();
  const std::string fits = end_within(name, ImGui::GetContentRegionAvail().x - 2 * ImGui::GetFontSize());
  if (is_picked) ImGui::PushStyleColor(ImGuiCol_Text, IM_COL32(255, 255, 0, 255));  // as its mark
  const bool is_open = ImGui::TreeNode("scene", "%s", fits.c_str());
  if (is_picked) ImGui::PopStyleColor();
  tell_whole(name, fits);
  if (!is_open) return edited;
  edited |= pose_panel(scene, shown.gaussians->origin, step);
  edited |= ImGui::SliderFloat("opacity", &scene.opacity, 0, 1, "%.3f", ImGuiSliderFlags_AlwaysClamp);
  edited |= ImGui::ColorEdit3("tint", &scene.tint.colour.x);
  edited |= ImGui::SliderFloat("of it", &scene.tint.amount, 0, 1, "%.3f", ImGuiSliderFlags_AlwaysClamp);
  edited |= clip_panel(scene, *shown.gaussians);
  ImGui::TreePop();
  return edited;
}

}  // namespace

void scene_panel(Viewer& viewer, bool& changed) {
  for (std::size_t i = 0; i < viewer.drawing.scenes().size(); ++i) {
    const ShownScene& shown = viewer.drawing.scenes()[i];
    ListedScene scene = shown.listed;
    ImGui::PushID(int(i));
    const bool is_picked = viewer.picked && viewer.picked->scene == i;
    if (edit(scene, shown, is_picked, 0.01 * viewer.least_way))
      attempt(viewer, [&] {
        viewer.drawing.change(i, std::move(scene));
        viewer.picked.reset(), viewer.has_edited_scenes = true, changed = true;
      });
    ImGui::PopID();
  }
  if (ImGui::Button("save scenes")) attempt(viewer, [&] { save_scenes(viewer); });
  ImGui::SameLine();
  ImGui::TextUnformatted(viewer.has_edited_scenes ? "not saved" : viewer.list_file.c_str());
}

}  // namespace swiftgs::cli
