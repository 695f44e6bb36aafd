// SPDX-License-Identifier: Apache-2.0
#include "view/panels.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <imgui.h>

#include "words.hpp"

namespace swiftgs::cli {
namespace {

/// The words of all renderers that can run here, place by place of their names.
struct Words {
  std::vector<std::string> backend, sort, raster, bounds;

  Words() {
    const auto add = [](std::vector<std::string>& words, const std::string& word) {
      if (std::find(words.begin(), words.end(), word) == words.end()) words.push_back(word);
    };
    for (const RendererEntry& entry : renderers()) {
      if (!entry.usable) continue;
      const RendererWords each(entry.name);
      add(backend, each.backend), add(sort, each.sort), add(raster, each.raster), add(bounds, each.bounds);
    }
  }

  static const Words& all() {
    static const Words words;
    return words;
  }
};

constexpr const char* longest_label = "seconds a key";

/// Of controls: wide enough for the longest word.
float control_width() {
  float widest = 0;
  for (const auto* words :
       {&Words::all().backend, &Words::all().sort, &Words::all().raster, &Words::all().bounds})
    for (const std::string& word : *words) widest = std::max(widest, ImGui::CalcTextSize(word.c_str()).x);
  return widest + ImGui::GetFrameHeight() + 2 * ImGui::GetStyle().FramePadding.x + 1;
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
  ImGui::SetNextItemWidth(control_width() - 2 * (ImGui::GetFrameHeight() + ImGui::GetStyle().ItemSpacing.x));
  if (begin_list("camera", viewer.cameras[viewer.camera].name, viewer.escapes)) {
    for (std::size_t i = 0; i <= last; ++i)
      if (list_entry(i, viewer.cameras[i].name, i == viewer.camera)) camera = i;
    ImGui::EndCombo();
  }
  if (camera != viewer.camera) jump_to(viewer, camera), changed = true;
}

void renderer_panel(Viewer& viewer, bool& changed) {
  RendererWords words(viewer.drawing.renderer().name());
  bool other = choose("backend", Words::all().backend, words.backend, viewer.escapes);
  other |= choose("sort", Words::all().sort, words.sort, viewer.escapes);
  other |= choose("raster", Words::all().raster, words.raster, viewer.escapes);
  other |= choose("bounds", Words::all().bounds, words.bounds, viewer.escapes);
  if (other) attempt(viewer, [&] { viewer.drawing.use(words.name()), changed = true; });

  std::string plane = viewer.plane.empty() ? "colour" : viewer.plane;
  std::vector<std::string> planes;
  for_each_plane([&](std::size_t, const PlaneRow& row) { planes.emplace_back(row.name); }, plane_table);
  planes.pop_back();  // no file has features
  if (choose("plane", planes, plane, viewer.escapes)) {
    viewer.plane = plane == "colour" ? "" : plane;
    viewer.drawing.show_plane(viewer.plane), changed = true;
  }
  if (viewer.drawing.pages()) return;  // which the reference does not draw
  ImGui::Checkbox("error beside float64, in the square", &viewer.compares);
  if (viewer.compares && viewer.error)
    ImGui::Text("%.1f dB, %.2g at most", viewer.error->psnr_db, viewer.error->max_abs);
  else if (viewer.compares)
    ImGui::TextUnformatted(viewer.crop_error.is_under_way() ? "the reference is drawn"
                                                            : "when it stands still");
}

void pages_panel(Viewer& viewer, bool& changed) {
  CutGoal goal = viewer.drawing.goal();
  double millions = std::min(1e-6 * double(goal.splats), 100.0);
  bool other = slide("pixels", goal.pixels, 0, 64, "%.2f", true);
  if (slide("M splats", millions, 0.05, 100, "%.2f", true))
    goal.splats = std::uint64_t(1e6 * millions), other = true;
  if (other) viewer.drawing.set_goal(goal), changed = true;
  const PageFrames& pages = *viewer.drawing.pages();
  const Cut& cut = pages.cut();
  ImGui::Text("%.2f M splats of %.2f M drawn", 1e-6 * double(cut.splats()), 1e-6 * double(cut.wanted()));
  ImGui::Text("%zu pages in memory, %.0f MB", pages.pool().resident(), 1e-6 * double(pages.pool().bytes()));
  ImGui::Text("%zu pages missing", cut.missing());
  ImGui::Text("errors of %.2f pixels", cut.pixels());
  if (const double db = pages.pool().estimated_db(); !std::isnan(db)) ImGui::Text("estimated %.1f dB", db);
  if (!cut.failed().empty()) ImGui::TextWrapped("%s", cut.failed()[0].reason.c_str());
}

void picked_panel(const Viewer& viewer) {
  if (!viewer.picked) return ImGui::TextUnformatted("Click on the picture.");
  const Picked& picked = *viewer.picked;
  const dvec3& at = picked.position;
  const vec3& size = picked.scale;
  ImGui::TextWrapped("%s of %s", picked.name.c_str(), viewer.drawing.scenes()[picked.scene].name().c_str());
  ImGui::Text("weight %.3f, depth %.4g", double(picked.weight), double(picked.depth));
  ImGui::Text("position %.5g %.5g %.5g", at.x, at.y, at.z);
  ImGui::Text("scale %.3g %.3g %.3g", double(size.x), double(size.y), double(size.z));
  ImGui::Text("opacity %.3f", double(picked.opacity));
}

void path_panel(Viewer& viewer, bool& changed) {
  CameraPath& path = viewer.path;
  if (ImGui::Button("add key")) add_key(viewer);
  ImGui::SameLine();
  if (ImGui::Button("drop last") && !path.keys.empty())
    path.keys.pop_back(), viewer.plays = false, viewer.has_edited_path = true;
  ImGui::SameLine();
  ImGui::Text("%zu %s, %.1f s", path.keys.size(), path.keys.size() == 1 ? "key" : "keys", path.seconds());
  if (slide(longest_label, path.seconds_a_key, 0.02, 10, "%.2f", true)) viewer.has_edited_path = true;
  viewer.path_at = std::min(viewer.path_at, path.seconds());
  if (path.keys.empty()) return;
  if (slide("at", viewer.path_at, 0, path.seconds(), "%.2f s", false)) follow_path(viewer), changed = true;
  if (ImGui::Button(viewer.plays ? "stop" : "play")) viewer.plays = !viewer.plays;
  ImGui::SameLine();
  if (ImGui::Button("save path")) attempt(viewer, [&] { save_path(viewer); });
  ImGui::SameLine();
  ImGui::TextUnformatted(viewer.has_edited_path ? "not saved" : viewer.path_file.c_str());
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
    "L           save the list of scenes\n"
    "P           picture to a PNG\n"
    "N, B, R     next, previous, this camera\n"
    "H           hide panels\n"
    "Esc         close a list, dismiss a message\n"
    "Ctrl+click  type the number of a control";

}  // namespace

bool draw_panels(Viewer& viewer) {
  bool changed = false;
  const ImGuiStyle& style = ImGui::GetStyle();
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float margin = style.WindowPadding.x, controls = control_width();
  const float width = controls + style.ItemInnerSpacing.x + ImGui::CalcTextSize(longest_label).x +
                      2 * style.WindowPadding.x + style.ScrollbarSize;
  ImGui::SetNextWindowPos(ImVec2(margin, margin), ImGuiCond_FirstUseEver);
  ImGui::SetNextWindowSize(ImVec2(width, 54 * ImGui::GetFontSize()), ImGuiCond_FirstUseEver);
  // Messages and the legend have the rest of the window.
  ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(0.65f * display.x, display.y - 2 * margin));
  ImGui::Begin("SwiftGS", nullptr, ImGuiWindowFlags_HorizontalScrollbar);
  ImGui::PushItemWidth(controls);
  const Frame& picture = viewer.drawing.picture();
  if (picture.width > 0)
    ImGui::Text("%dx%d  %.1f ms", picture.width, picture.height, viewer.drawing.times().total);
  if (viewer.interval > 0) {
    ImGui::SameLine();
    ImGui::Text(" %.0f frames a second", 1 / viewer.interval);
  }
  const auto opens = [](const char* title) {
    return ImGui::CollapsingHeader(title, ImGuiTreeNodeFlags_DefaultOpen);
  };
  if (opens("Camera")) camera_panel(viewer, changed);
  if (opens("Scenes")) scene_panel(viewer, changed);
  if (viewer.drawing.pages() && opens("Pages")) pages_panel(viewer, changed);
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
