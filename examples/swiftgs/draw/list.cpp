// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include <swiftgs/any_renderer.hpp>

#include "commands.hpp"
#include "json.hpp"
#include "options.hpp"
#include "result_file.hpp"
#include "result_head.hpp"
#include "words.hpp"

namespace swiftgs::cli {
namespace {

void print_list() {
  std::size_t width = 0;
  for (const RendererEntry& entry : renderers()) width = std::max(width, entry.name.size());
  for (const RendererEntry& entry : renderers())
    std::printf("%-*s  %s\n", int(width), entry.name.c_str(), entry.usable ? "runs here" : "cannot run here");
}

std::string row_of(const RendererEntry& entry) {
  const RendererWords words(entry.name);
  return text_of({{"renderer", entry.name},
                  {"backend", words.backend},
                  {"sort", words.sort},
                  {"raster", words.raster},
                  {"bounds", words.bounds},
                  {"usable", entry.usable}});
}

void list(const std::string& file) {
  ResultFile json(file);
  if (!json.is_standard_output()) print_list();
  if (json.is_wanted())
    json.write(document_of(head_of("swiftgs-list"), {{"rows", array_of(renderers(), row_of)}}));
  json.finish();
}

constexpr const char* list_help =
    R"(A name is BACKEND/SORT/RASTER/BOUNDS: where it runs, how splats are ordered, how pixels
are blended, which tiles a splat may touch.)";

}  // namespace

void add_list(CLI::App& app) {
  CLI::App* command = app.add_subcommand("list", "Every renderer, and whether it can run here");
  command->footer(list_help);
  const auto json = std::make_shared<std::string>();
  add_json(*command, *json);
  command->callback([json] { list(*json); });
}

}  // namespace swiftgs::cli
