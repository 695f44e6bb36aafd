// SPDX-License-Identifier: Apache-2.0
#include "draw/choice.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fnmatch.h>

#include <swiftgs/any_renderer.hpp>

#include "words.hpp"

namespace swiftgs::cli {

namespace {

bool has_backend(std::string_view start) {
  return std::any_of(renderers().begin(), renderers().end(),
                     [&](const RendererEntry& entry) { return entry.name.starts_with(start); });
}

}  // namespace

std::vector<RendererEntry> renderers_matching(const std::string& patterns) {
  std::vector<bool> chosen(renderers().size());
  for (const std::string_view part : split(patterns, ',')) {
    const std::string pattern(part);
    bool found = false;
    for (std::size_t i = 0; i < chosen.size(); ++i)
      if (renderers()[i].usable && fnmatch(pattern.c_str(), renderers()[i].name.c_str(), 0) == 0)
        found = chosen[i] = true;
    for (const auto& [backend, needs] : {std::pair("cuda", "CUDA"), std::pair("vulkan", "Vulkan")})
      if (!found && pattern.starts_with(backend) && !has_backend(backend))
        throw std::invalid_argument("--renderers '" + pattern + "': built without " + needs);
    if (!found)
      throw std::invalid_argument("--renderers '" + pattern +
                                  "': no renderer that can run here matches; expected a name from 'swiftgs "
                                  "list', with * for any text, such as 'cpu/*/per-pixel/ellipse'");
  }
  std::vector<RendererEntry> entries;
  for (std::size_t i = 0; i < chosen.size(); ++i)
    if (chosen[i]) entries.push_back(renderers()[i]);
  return entries;
}

std::string exact_renderer(std::string_view backend) {
  return std::string(backend) + "/early/axis-shared-threshold-float-cholesky/ellipse";
}

std::string default_renderer() {
  for (const char* backend : {"cpu", "serial"})
    for (const RendererEntry& entry : renderers())
      if (entry.usable && entry.name == exact_renderer(backend)) return entry.name;
  throw std::runtime_error("no renderer can run here");
}

}  // namespace swiftgs::cli
