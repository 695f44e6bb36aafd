// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include <swiftgs/any_renderer.hpp>

#include "commands.hpp"

namespace swiftgs::cli {
namespace {

void list() {
  std::size_t width = 0;
  for (const RendererEntry& entry : renderers()) width = std::max(width, entry.name.size());
  for (const RendererEntry& entry : renderers())
    std::printf("%-*s  %s\n", int(width), std::string(entry.name).c_str(),
                entry.usable ? "runs here" : "cannot run here");
}

constexpr const char* more =
    R"(A name is BACKEND/SORT/RASTER/BOUNDS: where it runs, how splats are ordered, how pixels
are blended, which tiles a splat may touch.)";

}  // namespace

void add_list(CLI::App& app) {
  CLI::App* command = app.add_subcommand("list", "Every renderer, and whether it can run here");
  command->footer(more);
  command->callback(list);
}

}  // namespace swiftgs::cli
