// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>

#include <swiftgs/any_renderer.hpp>

#include "commands.hpp"

namespace swiftgs::cli {

void list() {
  std::size_t width = 0;
  for (const RendererEntry& entry : renderers()) width = std::max(width, entry.name.size());
  for (const RendererEntry& entry : renderers())
    std::printf("%-*s  %s\n", int(width), std::string(entry.name).c_str(),
                entry.usable ? "runs here" : "cannot run here");
}

}  // namespace swiftgs::cli
