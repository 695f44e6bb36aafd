// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include <imgui.h>

#include <swiftgs/scene_bounds.hpp>

#include "draw/renderer_words.hpp"
#include "view/placement_numbers.hpp"
#include "view/viewer.hpp"

namespace swiftgs::cli {
namespace {

/// Lists `words` to choose one of. Returns whether `chosen` changed.
bool choose(const char* label, const std::vector<std::string>& words, std::string& chosen) {
  const std::string before = chosen;
  if (!ImGui::BeginCombo(label, chosen.c_str())) return false;
  for (const std::string& word : words)
    if (ImGui::Selectable(word.c_str(), word == chosen)) chosen = word;
  ImGui::EndCombo();
  return chosen != before;
}

/// Three doubles to drag. Returns whether they changed.
bool drag(const char* label, dvec3& values, double speed) {
  std::array<double, 3> numbers{values.x, values.y, values.z};
  if (!ImGui::DragScalarN(label, ImGuiDataType_Double, numbers.data(), 3, float(speed), nullptr, nullptr,
                          "%.3g"))
    return false;
  values = {numbers[0], numbers[1], numbers[2]};
  return true;
}

bool slide(const char* label, double& value, double low, double high, const char* format, bool logarithmic) {
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &low, &high, format,
                             logarithmic ? ImGuiSliderFlags_Logarithmic : 0);
}

/// `part` of `whole` as a bar with a text.
void bar(const char* label, double part, double whole, const std::string& text) {
  ImGui::ProgressBar(whole > 0 ? float(part / whole) : 0.0f, ImVec2(160, 0), text.c_str());
  ImGui::SameLine();
  ImGui::TextUnformatted(label);
}

std::string text_of(const char* format, double number) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), format, number);
  return text.data();
}

void camera_panel(Viewer& viewer, bool& changed) {
  int navigation = int(viewer.navigation);
  for (const auto& [label, value] : {std::pair("orbit", 0), {"fly", 1}, {"walk", 2}}) {
    if (value > 0) ImGui::SameLine();
    ImGui::RadioButton(label, &navigation, value);
  }
  viewer.navigation = Navigation(navigation);
  slide("speed", viewer.speed, 0.01 * viewer.least_way, 100 * viewer.least_way, "%.3g", true);
  const std::size_t last = viewer.cameras.size() - 1;
  std::size_t camera = viewer.camera;
  if (ImGui::ArrowButton("previous", ImGuiDir_Left)) camera = camera == 0 ? last : camera - 1;
  ImGui::SameLine();
  if (ImGui::ArrowButton("next", ImGuiDir_Right)) camera = camera == last ? 0 : camera + 1;
  ImGui::SameLine();
  if (ImGui::BeginCombo("camera", viewer.cameras[viewer.camera].name.c_str())) {
    for (std::size_t i = 0; i <= last; ++i)
      if (ImGui::Selectable(viewer.cameras[i].name.c_str(), i == viewer.camera)) camera = i;
    ImGui::EndCombo();
  }
  if (camera != viewer.camera) jump_to(viewer, camera), changed = true;
}

/// The box that shows of a scene, in numbers of its file.
bool clip_panel(ShownScene& scene) {
  Clip& clip = scene.placement.clip;
  std::optional<Corners> box = box_of(clip);
  bool clipped = box.has_value(), changed = ImGui::Checkbox("clip by a box", &clipped);
  if (changed && clipped) {
    const SceneBounds bounds = robust_bounds(*scene.gaussians);
    box = {vec3(bounds.low), vec3(bounds.high)};
  } else if (!clipped) {
    box.reset();
  }
  if (box) {
    const vec3 size = box->high - box->low;
    const double speed = 0.002 * double(std::max({size.x, size.y, size.z}));
    const dvec3& origin = scene.gaussians->origin;
    dvec3 low = origin + dvec3(box->low), high = origin + dvec3(box->high);
    if (drag("from", low, speed)) box->low = vec3(low - origin), changed = true;
    if (drag("to", high, speed)) box->high = vec3(high - origin), changed = true;
  }
  if (changed) clip = with_box(clip, box);
  return changed;
}

void scene_panel(Viewer& viewer, bool& changed) {
  bool placed = false;
  for (std::size_t i = 0; i < viewer.drawing.scenes.size(); ++i) {
    ShownScene& scene = viewer.drawing.scenes[i];
    ImGui::PushID(int(i));
    placed |= ImGui::Checkbox("##visible", &scene.visible);
    ImGui::SameLine();
    if (ImGui::TreeNode(scene.name.c_str())) {
      Similarity& pose = scene.placement.world_from_scene;
      placed |= drag("place", pose.translation, 0.01 * viewer.least_way);
      dvec3 angles = angles_of(pose.rotation);
      if (drag("angles", angles, 0.5)) pose.rotation = rotation_of(angles), placed = true;
      placed |= slide("scale", pose.scale, 0.01, 100, "%.3g", true);
      placed |= ImGui::SliderFloat("opacity", &scene.placement.opacity, 0, 1);
      placed |= clip_panel(scene);
      ImGui::TreePop();
    }
    ImGui::PopID();
  }
  if (placed) attempt(viewer, [&] { viewer.drawing.place(), viewer.picked.reset(), changed = true; });
}

/// The words at this place of the names of all renderers that can run here.
std::vector<std::string> words_at(std::string RendererWords::*place) {
  std::vector<std::string> words;
  for (const RendererEntry& entry : renderers()) {
    const RendererWords each(entry.name);
    if (entry.usable && std::find(words.begin(), words.end(), each.*place) == words.end())
      words.push_back(each.*place);
  }
  return words;
}

void renderer_panel(Viewer& viewer, bool& changed) {
  RendererWords words(viewer.drawing.renderer().name());
  bool other = choose("backend", words_at(&RendererWords::backend), words.backend);
  other |= choose("sort", words_at(&RendererWords::sort), words.sort);
  other |= choose("raster", words_at(&RendererWords::raster), words.raster);
  other |= choose("bounds", words_at(&RendererWords::bounds), words.bounds);
  if (other) attempt(viewer, [&] { viewer.drawing.use(words.with_sort(words.sort)), changed = true; });

  std::string plane = viewer.plane.empty() ? "colour" : viewer.plane;
  std::vector<std::string> planes;
  for_each_plane([&](std::size_t, const char* name) { planes.emplace_back(name); }, plane_names);
  planes.pop_back();  // no file has features
  if (choose("plane", planes, plane)) {
    viewer.plane = plane == "colour" ? "" : plane;
    viewer.drawing.show_plane(viewer.plane), changed = true;
  }
  ImGui::Checkbox("error beside float64, in the square", &viewer.compares);
  if (viewer.compares && viewer.error)
    ImGui::Text("%.1f dB, %.2g at most", viewer.error->psnr_db, viewer.error->max_abs);
  else if (viewer.compares)
    ImGui::TextUnformatted(viewer.crop_error.is_under_way() ? "the reference is drawn"
                                                            : "when it stands still");
}

void picked_panel(const Viewer& viewer) {
  if (!viewer.picked) return ImGui::TextUnformatted("Click on the picture.");
  const Picked& picked = *viewer.picked;
  const ShownScene& shown = viewer.drawing.scenes[picked.scene];
  const Scene& scene = *shown.gaussians;
  const std::size_t i = picked.gaussian;
  const dvec3 at = scene.origin + dvec3(scene.means[i]);
  const vec3& size = scene.scales[i];
  ImGui::Text("Gaussian %zu of %s", i, shown.name.c_str());
  ImGui::Text("weight %.3f, depth %.4g", double(picked.weight), double(picked.depth));
  ImGui::Text("position %.5g %.5g %.5g", at.x, at.y, at.z);
  ImGui::Text("scale %.3g %.3g %.3g", double(size.x), double(size.y), double(size.z));
  ImGui::Text("opacity %.3f", double(scene.opacities[i]));
}

void path_panel(Viewer& viewer, bool& changed) {
  CameraPath& path = viewer.path;
  if (ImGui::Button("add key")) path.keys.push_back(viewer.shown);
  ImGui::SameLine();
  if (ImGui::Button("drop last") && !path.keys.empty()) path.keys.pop_back(), viewer.plays = false;
  ImGui::SameLine();
  ImGui::Text("%zu %s, %.1f s", path.keys.size(), path.keys.size() == 1 ? "key" : "keys", path.seconds());
  slide("seconds a key", path.seconds_a_key, 0.02, 10, "%.2f", true);
  if (path.keys.empty()) return;
  if (slide("at", viewer.path_at, 0, path.seconds(), "%.2f s", false)) follow_path(viewer), changed = true;
  if (ImGui::Button(viewer.plays ? "stop" : "play")) viewer.plays = !viewer.plays;
  ImGui::SameLine();
  if (ImGui::Button("save")) attempt(viewer, [&] { save_path(viewer); });
}

void statistics_panel(Viewer& viewer, bool& changed) {
  const StageTimes ms = viewer.drawing.times();
  for (const auto& [label, time] :
       {std::pair("project", ms.project), {"sort", ms.sort}, {"raster", ms.raster}})
    bar(label, time, ms.total, text_of("%.1f ms", time));
  if (ImGui::Checkbox("count", &viewer.counts)) changed = true;
  if (!viewer.counts) return;
  const Statistics counts = viewer.drawing.renderer().statistics();
  const auto of = [](const char* label, double part, double whole) {
    bar(label, part, whole, text_of("%.0f", part));
  };
  const double visited = double(counts.raster.intersections_visited);
  const double pixels = viewer.scale * viewer.scale * viewer.shown.width * viewer.shown.height;
  of("visible Gaussians", double(counts.visible), double(counts.gaussians));
  of("intersections visited", visited, double(counts.intersections));
  of("pixels stopped early", double(counts.raster.pixels_stopped), pixels);
  ImGui::Text("%.2f tiles a visible Gaussian", counts.intersections_a_visible());
  ImGui::Text("%.1f blended a pixel", pixels > 0 ? double(counts.raster.contributing_pairs) / pixels : 0);
}

constexpr const char* keys_of_viewer =
    "left drag   turn\n"
    "right drag  pan\n"
    "wheel       nearer, farther\n"
    "W A S D Q E move, Shift faster\n"
    "1 2 3       orbit, fly, walk\n"
    "click       pick; twice: orbit it\n"
    "K, Space, F add key, play, save path\n"
    "P           picture to a PNG\n"
    "N, B, R     next, previous, this camera\n"
    "H           hide panels";

}  // namespace

bool draw_panels(Viewer& viewer) {
  bool changed = false;
  ImGui::SetNextWindowPos(ImVec2(8, 8), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize(ImVec2(330, 700), ImGuiCond_FirstUseEver);
  ImGui::Begin("SwiftGS");
  ImGui::PushItemWidth(190);
  const StageTimes ms = viewer.drawing.times();
  ImGui::Text("%dx%d  %.1f ms", viewer.drawing.picture().width, viewer.drawing.picture().height, ms.total);
  if (viewer.interval > 0) {
    ImGui::SameLine();
    ImGui::Text(" %.0f frames a second", 1 / viewer.interval);
  }
  const auto opens = [](const char* title) {
    return ImGui::CollapsingHeader(title, ImGuiTreeNodeFlags_DefaultOpen);
  };
  if (opens("Camera")) camera_panel(viewer, changed);
  if (opens("Scenes")) scene_panel(viewer, changed);
  if (opens("Renderer")) renderer_panel(viewer, changed);
  if (opens("Picked")) picked_panel(viewer);
  if (opens("Path")) path_panel(viewer, changed);
  if (opens("Statistics")) statistics_panel(viewer, changed);
  if (ImGui::CollapsingHeader("Keys")) ImGui::TextUnformatted(keys_of_viewer);
  ImGui::PopItemWidth();
  ImGui::End();
  return changed;
}

}  // namespace swiftgs::cli
