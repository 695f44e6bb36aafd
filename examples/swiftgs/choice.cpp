// SPDX-License-Identifier: Apache-2.0
#include "choice.hpp"

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

std::vector<std::string> renderers_matching(const std::string& pattern) {
  std::vector<std::string> names;
  for (const RendererEntry& entry : renderers())
    if (entry.usable && matches(pattern, entry.name)) names.emplace_back(entry.name);
  if (names.empty())
    throw std::invalid_argument("--renderers '" + pattern +
                                "': no renderer that can run here matches; expected a name from 'swiftgs "
                                "list', with * for any text, such as 'cpu/*/per-pixel/ellipse'");
  return names;
}

std::string default_renderer() {
  for (const char* backend : {"cpu", "serial"})
    for (const RendererEntry& entry : renderers())
      if (entry.usable &&
          entry.name == std::string(backend) + "/early/axis-shared-threshold-float-cholesky/ellipse")
        return std::string(entry.name);
  throw std::runtime_error("no renderer can run here");
}

}  // namespace swiftgs::cli
