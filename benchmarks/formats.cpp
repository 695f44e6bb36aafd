// SPDX-License-Identifier: Apache-2.0

/// @file
/// What each format of scenes costs: size, times, and what a scene loses that is written in it, or in one and
/// then in another. docs/formats.md shows the tables that are made of this.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/edit.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>

#include "inputs.hpp"

namespace {

using namespace swiftgs;
using Json = nlohmann::ordered_json;

struct Format {
  const char* name;
  const char* ending;
  Scene (*ordered)(const Scene&);  ///< the scene in the order that the writer brings it into
};

Scene as_it_is(const Scene& scene) { return scene; }

/// Greatest volume times opacity first, of equal ones the lower index, as a `.splat` file has them.
Scene most_visible_first(const Scene& scene) {
  std::vector<double> scores(scene.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const dvec3 scale(scene.scales[i]);
    scores[i] = scale.x * scale.y * scale.z * double(scene.opacities[i]);
  }
  std::vector<std::uint32_t> order(scene.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return scores[a] > scores[b]; });
  return subset(scene, order);
}

constexpr Format formats[] = {{"INRIA PLY", ".ply", as_it_is},
                              {"compressed PLY", ".compressed.ply", order_spatially},
                              {"SPZ", ".spz", as_it_is},
                              {"SOG", ".sog", order_spatially},
                              {".splat", ".splat", most_visible_first}};

/// A folder that is removed with the files of each format in it.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "swiftgs-formats-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error(name + ": cannot be made");
    path_ = name;
  }
  ~Folder() {
    for (const Format& format : formats) std::filesystem::remove(file(format));
    std::filesystem::remove(path_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path file(const Format& format) const {
    return path_ / (std::string("scene") + format.ending);
  }

 private:
  std::filesystem::path path_;
};

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double significant(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return std::strtod(text, nullptr);
}

/// The largest of `difference(i)`.
template <class Difference>
double largest(const Scene& scene, const Difference& difference) {
  double most = 0;
  for (std::size_t i = 0; i < scene.size(); ++i) most = std::max(most, double(difference(i)));
  return significant(most);
}

double largest_of(const vec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// What `b` has lost of `a`, Gaussian by Gaussian.
Json errors_of(const Scene& a, const Scene& b) {
  const auto angle = [&](std::size_t i) {
    const Quaternion &p = a.rotations[i], &q = b.rotations[i];
    const double cosine =
        std::abs(double(p.w) * q.w + double(p.x) * q.x + double(p.y) * q.y + double(p.z) * q.z);
    return 2 * std::acos(std::min(1.0, cosine)) * 180 / 3.141592653589793;
  };
  const auto log_scale = [&](std::size_t i) {
    double most = 0;
    for (int axis = 0; axis < 3; ++axis)
      if (a.scales[i][axis] > 0 && b.scales[i][axis] > 0)
        most = std::max(most, std::abs(std::log(double(a.scales[i][axis]) / b.scales[i][axis])));
    return most;
  };
  Json errors{
      {"mean", largest(a, [&](std::size_t i) { return largest_of(a.means[i] - b.means[i]); })},
      {"log_scale", largest(a, log_scale)},
      {"degrees", largest(a, angle)},
      {"opacity", largest(a, [&](std::size_t i) { return std::abs(a.opacities[i] - b.opacities[i]); })},
      {"sh0", largest(a, [&](std::size_t i) { return largest_of(a.sh0[i] - b.sh0[i]); })}};
  const Scene full = with_degree(b, a.sh_degree);
  double squared = 0;
  for (std::size_t k = 0; k < a.sh_rest.size(); ++k) {
    const double difference = double(a.sh_rest[k]) - full.sh_rest[k];
    squared += difference * difference;
  }
  errors["sh_rest_rms"] = a.sh_rest.empty() ? 0 : significant(std::sqrt(squared / double(a.sh_rest.size())));
  return errors;
}

/// Frames of one view, by the serial backend.
class Eye {
 public:
  explicit Eye(const Camera& camera) : camera_(camera) {}

  std::vector<float> see(const Scene& scene) {
    RenderSettings settings;
    settings.conventions.antialiased = scene.antialiased;
    return renderer_.render(renderer_.backend().upload(scene), camera_, settings).colour;
  }

 private:
  Camera camera_;
  Renderer<Serial, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer_;
};

/// What a scene becomes that is written in a format.
struct Written {
  Scene scene, ordered;  ///< as it is read, and as it was, in the same order
  Json costs;
};

Written write_and_read(const Format& format, const Scene& scene, const Folder& folder) {
  Written result;
  WrittenScene written;
  SceneFile read;
  const std::filesystem::path file = folder.file(format);
  const double write = seconds_of([&] { written = write_scene(file, scene); });
  const double once = seconds_of([&] { read = read_scene(file); });
  const double again = seconds_of([&] { read = read_scene(file); });
  result.ordered = format.ordered(scene);
  if (read.scene.size() != scene.size())
    throw std::runtime_error(std::string(format.name) + ": expected " + std::to_string(scene.size()) +
                             " Gaussians, read " + std::to_string(read.scene.size()));
  result.costs = {{"format", format.name},
                  {"file_format", written.format},
                  {"bytes", written.bytes},
                  {"write_seconds", significant(write)},
                  {"read_seconds", significant(std::min(once, again))},
                  {"errors", errors_of(result.ordered, read.scene)}};
  result.scene = std::move(read.scene);
  return result;
}

Json measure(const Scene& scene, const Camera& camera) {
  Eye eye(camera);
  const Folder folder;
  const std::vector<float> whole = eye.see(scene);
  Json single = Json::array(), pairs = Json::array();
  for (const Format& first : formats) {
    Written one = write_and_read(first, scene, folder);
    one.costs["psnr_db"] = significant(psnr(whole, eye.see(one.scene)));
    single.push_back(one.costs);
    for (const Format& second : formats) {
      const Written two = write_and_read(second, one.scene, folder);
      pairs.push_back({{"first", first.name},
                       {"second", second.name},
                       {"errors", two.costs["errors"]},
                       {"psnr_db", significant(psnr(whole, eye.see(two.scene)))}});
    }
  }
  return {{"single", single}, {"pairs", pairs}};
}

Json read_json(const char* file) {
  std::ifstream stream(file);
  return Json::parse(stream, nullptr, false);
}

}  // namespace

/// formats_table MACHINE.json SCENE: results as JSON. `machine` is what benchmarks/describe_machine.sh
/// prints.
int main(int argc, char** argv) try {
  const Json machine = argc == 3 ? read_json(argv[1]) : Json(Json::value_t::discarded);
  if (machine.is_discarded()) {
    std::cerr << "usage: formats_table MACHINE.json SCENE; expected what describe_machine.sh prints, and a "
                 "capture or builtin:N\n";
    return 2;
  }
  const bench::Input input = bench::inputs_named({argv[2]}).at(0);
  const Scene scene = input.load();
  const Json found = measure(scene, input.views.at(0));
  std::cout << "{\"format\": \"swiftgs-formats\", \"version\": 1,\n\"machine\": " << machine.dump()
            << ",\n\"command\": \"formats_table MACHINE.json " << input.name << "\",\n\"scene\": \""
            << input.name << "\", \"gaussians\": " << scene.size() << ", \"sh_degree\": " << scene.sh_degree
            << ", \"size\": \"" << input.size() << "\"";
  for (const char* member : {"single", "pairs"}) {
    std::cout << ",\n\"" << member << "\": [";
    const char* separator = "\n ";
    for (const Json& row : found[member]) std::cout << separator << row.dump(), separator = ",\n ";
    std::cout << "]";
  }
  std::cout << "}\n";
  return 0;
} catch (const std::exception& error) {
  std::cerr << "formats_table: " << error.what() << "\n";
  return 1;
}
