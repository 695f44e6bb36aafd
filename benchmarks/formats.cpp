// SPDX-License-Identifier: Apache-2.0

/// @file
/// What each format of scenes costs: size, times, and what a scene loses that is written in it, or in one and
/// then in another, and what formats cost that are only read. docs/formats.md shows the tables.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <swiftgs/edit/all.hpp>
#include <swiftgs/io/scene_file.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>

#include "inputs.hpp"

namespace {

using namespace swiftgs;
using Json = nlohmann::ordered_json;

using Order = std::vector<std::uint32_t>;

struct Format {
  const char* name;
  const char* ending;
  Order (*order)(const Scene&);  ///< the order that the writer brings a scene into
  int spz_version = 4;
};

Order unchanged(const Scene& scene) {
  Order order(scene.size());
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

/// Greatest volume times opacity first, of equal ones the lower index, as a `.splat` file has them.
Order most_visible_first(const Scene& scene) {
  std::vector<double> scores(scene.size());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const dvec3 scale(scene.scales[i]);
    scores[i] = scale.x * scale.y * scale.z * double(scene.opacities[i]);
  }
  Order order = unchanged(scene);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return scores[a] > scores[b]; });
  return order;
}

constexpr Format formats[] = {
    {"INRIA PLY", ".ply", unchanged}, {"compressed PLY", ".compressed.ply", spatial_order},
    {"SPZ 4", ".spz", unchanged},     {"SPZ 3", ".spz", unchanged, 3},
    {"SOG", ".sog", spatial_order},   {".splat", ".splat", most_visible_first}};

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
    // A cosine near 1 holds half the digits of a small angle.
    const DQuaternion turn =
        DQuaternion{p.w, p.x, p.y, p.z} * DQuaternion{q.w, -double(q.x), -double(q.y), -double(q.z)};
    return 2 * std::atan2(std::hypot(turn.x, turn.y, turn.z), std::abs(turn.w)) * 180 / 3.141592653589793;
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
    return renderer_.render(renderer_.backend().upload(scene), camera_, settings).colour;
  }

 private:
  Camera camera_;
  Renderer<Serial> renderer_;
};

/// A scene that went through a file.
struct Written {
  Scene scene;  ///< as it was read
  Order order;  ///< in which it was written
  Json costs;
};

/// Reads a file several times. Returns the time of the quickest.
double seconds_to_read(const std::filesystem::path& file, SceneFile& read) {
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 5; ++i) least = std::min(least, seconds_of([&] { read = read_scene(file); }));
  return least;
}

Written write_and_read(const Format& format, const Scene& scene, const Folder& folder) {
  WrittenScene written;
  SceneFile read;
  const std::filesystem::path file = folder.file(format);
  const double write =
      seconds_of([&] { written = write_scene(file, scene, {.spz_version = format.spz_version}); });
  const double seconds = seconds_to_read(file, read);
  if (read.scene.size() != scene.size())
    throw std::runtime_error(std::string(format.name) + ": expected " + std::to_string(scene.size()) +
                             " Gaussians, read " + std::to_string(read.scene.size()));
  return {std::move(read.scene),
          format.order(scene),
          {{"file_format", written.format},
           {"file_bytes", written.bytes},
           {"write_seconds", significant(write)},
           {"read_seconds", significant(seconds)}}};
}

/// What `written` has lost of `before`, which has the order in which it was written, and of the frame
/// `whole`.
Json losses(const Scene& before, const Written& written, const std::vector<float>& whole, Eye& eye) {
  return {{"errors", errors_of(before, written.scene)},
          {"psnr_db", significant(psnr(whole, eye.see(written.scene)))}};
}

/// Of an index such as `lod-meta.json`, all files in its folder.
std::uintmax_t bytes_of(const std::filesystem::path& file) {
  if (file.extension() != ".json") return std::filesystem::file_size(file);
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(file.parent_path()))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

/// A file that another program made of `scene`. Its frame is compared with that of `scene` at its SH degree,
/// as it may hold fewer bands, in any order of Gaussians.
Json read_only(const std::filesystem::path& file, const Scene& scene, Eye& eye) {
  SceneFile read;
  const double seconds = seconds_to_read(file, read);
  const std::vector<float> whole = eye.see(with_degree(scene, read.scene.sh_degree));
  return {{"file_format", read.format},           {"gaussians", read.scene.size()},
          {"sh_degree", read.scene.sh_degree},    {"file_bytes", bytes_of(file)},
          {"read_seconds", significant(seconds)}, {"psnr_db", significant(psnr(whole, eye.see(read.scene)))}};
}

/// Rows, each with what `print` adds.
template <class Print>
void measure(const Scene& scene, const Camera& camera, const std::vector<std::filesystem::path>& files,
             const Print& print) {
  Eye eye(camera);
  const Folder folder;
  const std::vector<float> whole = eye.see(scene);
  for (const Format& first : formats) {
    Written one = write_and_read(first, scene, folder);
    const Scene before = subset(scene, one.order);
    one.costs.update(losses(before, one, whole, eye));
    print(one.costs);
    if (first.spz_version == 3) continue;  // the numbers of version 4
    for (const Format& second : formats) {
      if (second.spz_version == 3) continue;
      const Written two = write_and_read(second, one.scene, folder);
      Json row{{"file_format", second.name}, {"read_from", first.name}};
      row.update(losses(subset(before, two.order), two, whole, eye));
      print(row);
    }
  }
  for (const std::filesystem::path& file : files) print(read_only(file, scene, eye));
}

}  // namespace

/// formats_table SCENE [FILE...]: rows as JSON, for benchmarks/result_file.sh. Each FILE is SCENE in a format
/// that is only read.
int main(int argc, char** argv) try {
  if (argc < 2) {
    std::cerr
        << "usage: formats_table SCENE [FILE...]; expected a capture or builtin:N, and files that hold it\n";
    return 2;
  }
  const bench::Input input = bench::inputs_named({argv[1]}).at(0);
  const Scene scene = input.load();
  const Camera& camera = input.views.at(0);
  measure(scene, camera, {argv + 2, argv + argc}, [&](const Json& found) {
    Json row{{"scene", input.name},
             {"gaussians", scene.size()},
             {"width", camera.width},
             {"height", camera.height}};
    row.update(found);
    std::cout << row << std::endl;
  });
  return 0;
} catch (const std::exception& error) {
  std::cerr << "formats_table: " << error.what() << "\n";
  return 1;
}
