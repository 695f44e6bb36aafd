// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include <imgui.h>

#include "view/panels.hpp"

namespace swiftgs::cli {
namespace {

constexpr ImGuiWindowFlags fitted_window = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoMove |
                                           ImGuiWindowFlags_NoResize | ImGuiWindowFlags_AlwaysAutoResize |
                                           ImGuiWindowFlags_NoFocusOnAppearing;

/// Places the next window in the right corner at the top, 0, or the bottom, 1. Panels have the left part.
void place_right(float corner) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float margin = ImGui::GetStyle().WindowPadding.x;
  ImGui::SetNextWindowPos(ImVec2(display.x - margin, corner == 0 ? margin : display.y - margin),
                          ImGuiCond_Always, ImVec2(1, corner));
  ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), ImVec2(0.35f * display.x - 3 * margin, 0.6f * display.y));
}

/// A bar of the colours of depths, the farthest at the top, with numbers beside it.
void draw_scale(const DepthRange& range) {
  constexpr int parts = 4;
  const float line = ImGui::GetTextLineHeight(), step = 1.5f * line, width = 1.5f * line;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  ImDrawList& draws = *ImGui::GetWindowDrawList();
  const auto colour = [](int part) {
    const vec3 c = false_colour(float(part) / parts);
    return ImGui::ColorConvertFloat4ToU32(ImVec4(c.x, c.y, c.z, 1));
  };
  const int digits = digits_of(double(range.high), double(range.high - range.low) / parts);
  const std::string format = "%." + std::to_string(digits) + "g";
  float widest = 0;
  for (int part = 0; part <= parts; ++part) {
    const float y = at.y + 0.5f * line + float(parts - part) * step;
    if (part > 0)
      draws.AddRectFilledMultiColor(ImVec2(at.x, y), ImVec2(at.x + width, y + step), colour(part),
                                    colour(part), colour(part - 1), colour(part - 1));
    const char* beyond = part == 0 ? "<= " : part == parts ? ">= " : "   ";
    const std::string text = beyond + text_of(format.c_str(), double(range.depth(float(part) / parts)));
    draws.AddText(ImVec2(at.x + 1.3f * width, y - 0.5f * line), ImGui::GetColorU32(ImGuiCol_Text),
                  text.c_str());
    widest = std::max(widest, ImGui::CalcTextSize(text.c_str()).x);
  }
  ImGui::Dummy(ImVec2(1.3f * width + widest, float(parts) * step + line));
}

}  // namespace

void draw_marks(const Viewer& viewer) {
  const ImVec2 points = ImGui::GetIO().DisplayFramebufferScale;
  ImDrawList& marks = *ImGui::GetBackgroundDrawList();
  const auto at = [&](double x, double y) { return ImVec2(float(x) / points.x, float(y) / points.y); };
  if (viewer.compares) {
    const Camera crop = crop_around(viewer.shown, viewer.crop_x, viewer.crop_y, CropError::side);
    const double x = viewer.shown.cx - crop.cx, y = viewer.shown.cy - crop.cy;
    marks.AddRect(at(x, y), at(x + crop.width, y + crop.height), IM_COL32(255, 255, 255, 255));
  }
  if (!viewer.picked || !viewer.shown.lens.is_pinhole()) return;
  const Camera& camera = viewer.shown;
  const dvec3 p = camera.rotation * viewer.drawing.in_world(viewer.picked->scene, viewer.picked->position) +
                  camera.translation;
  if (p.z > 0)
    marks.AddCircle(at(camera.fx * p.x / p.z + camera.cx, camera.fy * p.y / p.z + camera.cy),
                    0.5f * ImGui::GetFontSize(), IM_COL32(255, 255, 0, 255));
}

void draw_legend(const Viewer& viewer) {
  const std::optional<DepthRange>& range = viewer.drawing.depth_range();
  if (!range || viewer.plane.empty()) return;
  place_right(0);
  if (ImGui::Begin("legend", nullptr, fitted_window | ImGuiWindowFlags_NoInputs)) {
    ImGui::TextUnformatted(viewer.plane.c_str());
    ImGui::TextUnformatted(range->length_power == 2 ? "world units squared" : "world units");
    draw_scale(*range);
  }
  ImGui::End();
}

void draw_messages(Viewer& viewer) {
  const auto& messages = viewer.messages.all();
  if (messages.empty()) return;
  const bool has_errors =
      std::any_of(messages.begin(), messages.end(), [](const auto& m) { return m.is_error; });
  place_right(1);
  ImGui::Begin("messages", nullptr, fitted_window | (has_errors ? 0 : ImGuiWindowFlags_NoInputs));
  ImGui::PushTextWrapPos(0.35f * ImGui::GetIO().DisplaySize.x - 6 * ImGui::GetStyle().WindowPadding.x);
  std::optional<std::size_t> dismissed;
  for (std::size_t i = 0; i < messages.size(); ++i) {
    ImGui::PushID(int(i));
    if (messages[i].is_error) {
      if (ImGui::SmallButton("x")) dismissed = i;
      ImGui::SameLine();
    }
    ImGui::TextUnformatted(messages[i].text.c_str());
    ImGui::PopID();
  }
  ImGui::PopTextWrapPos();
  ImGui::End();
  if (dismissed) viewer.messages.dismiss(*dismissed);
}

void ask_to_quit(Viewer& viewer) {
  if (!viewer.asks_to_quit) return;
  constexpr const char* title = "Not saved";
  if (!ImGui::IsPopupOpen(title)) ImGui::OpenPopup(title);
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(0.5f * display.x, 0.5f * display.y), ImGuiCond_Always, ImVec2(0.5f, 0.5f));
  if (!ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_AlwaysAutoResize)) return;
  if (viewer.has_edited_scenes) ImGui::TextUnformatted("The list of scenes has changes that are not saved.");
  if (has_unsaved_path(viewer)) ImGui::TextUnformatted("The path has changes that are not saved.");
  bool answered = std::exchange(viewer.escapes, false);
  if (ImGui::Button("save and quit")) {
    answered = true;
    attempt(viewer, [&] {
      if (viewer.has_edited_scenes) save_scenes(viewer);
      if (has_unsaved_path(viewer)) save_path(viewer);
      viewer.quits = true;
    });
  }
  ImGui::SameLine();
  if (ImGui::Button("quit without")) answered = viewer.quits = true;
  ImGui::SameLine();
  if (ImGui::Button("stay")) answered = true;
  if (answered) ImGui::CloseCurrentPopup(), viewer.asks_to_quit = false;
  ImGui::EndPopup();
}

}  // namespace swiftgs::cli
