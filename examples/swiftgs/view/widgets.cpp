// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <utility>

#include <imgui.h>

#include "view/panels.hpp"

namespace swiftgs::cli {
int digits_of(double value, double step) {
  const double steps = std::abs(value) / step;
  return std::isfinite(steps) && steps > 1 ? std::clamp(int(std::ceil(std::log10(steps))) + 1, 3, 15) : 3;
}

bool begin_list(const char* label, const std::string& shown, bool& escape) {
  const float width = ImGui::CalcItemWidth() - ImGui::GetFrameHeight() - 2 * ImGui::GetStyle().FramePadding.x;
  const std::string fits = end_within(shown, width);
  const bool is_open = ImGui::BeginCombo(label, fits.c_str());
  if (!is_open) tell_whole(shown, fits);
  if (is_open && std::exchange(escape, false)) ImGui::CloseCurrentPopup();
  return is_open;
}

bool list_entry(std::size_t number, const std::string& name, bool is_chosen) {
  ImGui::PushID(int(number));
  const bool chosen = ImGui::Selectable("##", is_chosen);  // a label would end at the first ##
  ImGui::SameLine(0, 0);
  ImGui::TextUnformatted(name.c_str());
  ImGui::PopID();
  return chosen;
}

bool choose(const char* label, const std::vector<std::string>& words, std::string& chosen, bool& escape) {
  const std::string before = chosen;
  if (!begin_list(label, chosen, escape)) return false;
  for (std::size_t i = 0; i < words.size(); ++i)
    if (list_entry(i, words[i], words[i] == before)) chosen = words[i];
  ImGui::EndCombo();
  return chosen != before;
}

bool drag(const char* label, dvec3& values, double step) {
  std::array<double, 3> numbers{values.x, values.y, values.z};
  const double largest = std::max({std::abs(values.x), std::abs(values.y), std::abs(values.z)});
  const std::string format = "%." + std::to_string(digits_of(largest, step)) + "g";
  if (!ImGui::DragScalarN(label, ImGuiDataType_Double, numbers.data(), 3, float(step), nullptr, nullptr,
                          format.c_str(), ImGuiSliderFlags_NoRoundToFormat))
    return false;
  values = {numbers[0], numbers[1], numbers[2]};
  return true;
}

bool slide(const char* label, double& value, double low, double high, const char* format, bool logarithmic) {
  return ImGui::SliderScalar(label, ImGuiDataType_Double, &value, &low, &high, format,
                             ImGuiSliderFlags_AlwaysClamp | (logarithmic ? ImGuiSliderFlags_Logarithmic : 0));
}

void bar(const char* label, double part, double whole, const std::string& text) {
  ImGui::ProgressBar(whole > 0 ? float(part / whole) : 0.0f, ImVec2(12 * ImGui::GetFontSize(), 0),
                     text.c_str());
  ImGui::SameLine();
  ImGui::TextUnformatted(label);
}

std::string text_of(const char* format, double number) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), format, number);
  return text.data();
}

std::string end_within(const std::string& text, float width) {
  const auto fits = [width](const std::string& part) { return ImGui::CalcTextSize(part.c_str()).x <= width; };
  if (fits(text)) return text;
  const auto is_within_letter = [&](std::size_t i) { return i < text.size() && (text[i] & 0xC0) == 0x80; };
  std::size_t first = 1;
  while (first < text.size() && (is_within_letter(first) || !fits("..." + text.substr(first)))) ++first;
  return "..." + text.substr(first);
}

void tell_whole(const std::string& whole, const std::string& shown) {
  if (whole != shown && ImGui::IsItemHovered()) {
    ImGui::BeginTooltip();
    ImGui::TextUnformatted(whole.c_str());
    ImGui::EndTooltip();
  }
}

}  // namespace swiftgs::cli
