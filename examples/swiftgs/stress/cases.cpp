// SPDX-License-Identifier: Apache-2.0
#include "stress/cases.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <string_view>

#include <swiftgs/camera.hpp>

#include "bench/lists.hpp"
#include "number_text.hpp"

namespace swiftgs::cli {
namespace {

ImageSize size_named(const std::string& text) {
  const std::vector<std::string_view> sides = cli::split(text, 'x');
  const auto side = [&](std::size_t i) { return i < sides.size() ? parse<int>(sides[i]).value_or(0) : 0; };
  const ImageSize size{side(0), side(1)};
  const auto fits = [](int pixels) { return pixels >= 1 && pixels <= max_image_side; };
  if (sides.size() != 2 || !fits(size.width) || !fits(size.height))
    throw std::invalid_argument("--size '" + text + "': expected WIDTHxHEIGHT such as 64x48, each 1 to " +
                                std::to_string(max_image_side));
  return size;
}

/// The severities of `family` that `text` asks for: `max`, `all`, or numbers. Throws for a number outside of
/// the family's own range: a scene of any size could follow from it.
std::vector<double> severities_named(const std::string& text, const StressFamily& family) {
  if (text == "all") return family.severities;
  const double least = family.severities.front(), most = family.severities.back();
  if (text == "max") return {most};
  std::vector<double> severities;
  try {
    severities = numbers_of("--severity", text);
  } catch (const std::invalid_argument&) {
    throw std::invalid_argument("--severity '" + text +
                                "': expected max, all, or numbers separated by commas, each once");
  }
  for (const double severity : severities)
    if (!(severity >= least && severity <= most))
      throw std::invalid_argument("--severity '" + text + "': expected " + severity_text(least) + " to " +
                                  severity_text(most) + " for " + std::string(family.name) + " (" +
                                  std::string(family.severity) + ")");
  std::sort(severities.begin(), severities.end());
  return severities;
}

}  // namespace

std::vector<const StressFamily*> families_named(const std::string& names,
                                                const std::vector<StressFamily>& families) {
  std::vector<std::string> wanted;
  if (!names.empty()) wanted = list_of("--families", names);
  for (const std::string& name : wanted) {
    std::string valid;
    bool found = false;
    for (const StressFamily& family : families) {
      found |= family.name == name;
      valid += (valid.empty() ? "" : ", ") + std::string(family.name);
    }
    if (!found) throw std::invalid_argument("--families '" + name + "': expected some of " + valid);
  }
  std::vector<const StressFamily*> chosen;
  for (const StressFamily& family : families)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), family.name) != wanted.end())
      chosen.push_back(&family);
  return chosen;
}

std::vector<StressPoint> points_of(const std::string& families, const std::string& severities,
                                   const std::string& sizes) {
  std::vector<StressPoint> points;
  for (const std::string& size : list_of("--size", sizes))
    for (const StressFamily* family : families_named(families, stress_families()))
      for (const double severity : severities_named(severities, *family))
        points.push_back({family, severity, size_named(size)});
  return points;
}

std::string severity_text(double severity) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", severity);
  std::string short_text = text;
  if (const std::size_t e = short_text.find('e'); e != short_text.npos) {
    if (short_text[e + 1] == '+') short_text.erase(e + 1, 1);
    const std::size_t digits = e + 1 + (short_text[e + 1] == '-');
    while (short_text[digits] == '0') short_text.erase(digits, 1);
  }
  return short_text;
}

}  // namespace swiftgs::cli
