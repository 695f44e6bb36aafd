// SPDX-License-Identifier: Apache-2.0

// Measures an honest rasterizer and one that is a fifth slower in turns, and writes what a reader of results
// should notice:
//   before.json, after.json   the same renderer, rasterizing slower in the second
//   same.json                 the renderer of before.json again, another object measured in the same turns
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <memory>
#include <vector>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/drivers/renderer_table.hpp>
#include <swiftgs/io/replace_file.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>

#include "bench/runner.hpp"

namespace swiftgs {
namespace {

/// `Raster`, and then a fifth of the time that it took.
template <class Raster>
struct Slowed : Raster {};

template <class Raster>
void rasterize(Serial& serial, Slowed<Raster>, const RasterJob& job) {
  const auto start = serial.now();
  rasterize(serial, Raster{}, job);
  const auto end = serial.now() + (serial.now() - start) / 5;
  while (serial.now() < end) {
  }
}

template <class... Rasters>
std::vector<RendererEntry> entries() {
  std::vector<RendererEntry> table;
  append_renderers<Serial>(table, TypeList<EarlySort>{}, TypeList<Rasters...>{}, TypeList<Ellipse>{});
  return table;
}

}  // namespace

namespace cli {
namespace {

constexpr double scale = 0.2;  // of the built-in camera's image

Session session() {
  Session s;
  s.gaussians = std::make_shared<const Scene>(make_builtin_scene(3000));
  s.scene = {"builtin", s.gaussians->size(), s.gaussians->size(), 1, s.gaussians->sh_degree, "", {}};
  s.views = {{scaled(builtin_camera(), scale), "front"}};
  s.scale = scale, s.conventions = "gsplat", s.threads = 1;
  return s;
}

Results measured(const std::vector<RendererEntry>& table, int frames) {
  Results results;
  results.head = {"swiftgs-bench", describe_machine(), "flawed_policies"};
  ResultFile file("");
  Progress progress(table.size());
  Runner runner(table, {{frames, frames, 0.001, 1}, 0}, results, file, progress);
  const Session s = session();
  results.scenes.push_back(s.scene);
  runner.run(s);
  return results;
}

void write_all(const std::filesystem::path& folder) {
  const Results timed = measured(entries<PerPixel, Slowed<PerPixel>, PerPixel>(), 20);
  const char* const names[] = {"before.json", "after.json", "same.json"};
  for (std::size_t i = 0; i < std::size(names); ++i) {
    Results one = timed;
    one.rows = {timed.rows.at(i)};
    replace_file(folder / names[i], to_json(one));
  }
}

}  // namespace
}  // namespace cli
}  // namespace swiftgs

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::invalid_argument("usage: flawed_policies FOLDER");
    swiftgs::cli::write_all(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "flawed_policies: %s\n", error.what());
    return 1;
  }
}
