// SPDX-License-Identifier: Apache-2.0
#include "draw/choice.hpp"

#include <algorithm>
#include <stdexcept>

#include <swiftgs/any_renderer.hpp>

namespace swiftgs::cli {

bool matches(std::string_view pattern, std::string_view name) {
  // After a mismatch, let the last star take one character more.
  std::size_t p = 0, n = 0, star = std::string_view::npos, taken = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*')
      star = p++, taken = n;
    else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n]))
      ++p, ++n;
    else if (star != std::string_view::npos)
      p = star + 1, n = ++taken;
    else
      return false;
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

namespace {

bool has_backend(std::string_view start) {
  return std::any_of(renderers().begin(), renderers().end(),
                     [&](const RendererEntry& entry) { return entry.name.starts_with(start); });
}

}  // namespace

std::vector<RendererEntry> renderers_matching(const std::string& patterns) {
  std::vector<bool> chosen(renderers().size());
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t comma = patterns.find(',', at);
    const std::string pattern = patterns.substr(at, comma - at);
    bool found = false;
    for (std::size_t i = 0; i < chosen.size(); ++i)
      if (renderers()[i].usable && matches(pattern, renderers()[i].name)) found = chosen[i] = true;
    if (!found && pattern.starts_with("cuda") && !has_backend("cuda/"))
      throw std::invalid_argument("--renderers '" + pattern + "': built without CUDA");
    if (!found)
      throw std::invalid_argument("--renderers '" + pattern +
                                  "': no renderer that can run here matches; expected a name from 'swiftgs "
                                  "list', with * for any text, such as 'cpu/*/per-pixel/ellipse'");
    at = comma == std::string::npos ? comma : comma + 1;
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
