// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <string>

#include "output_file.hpp"
#include "progress_meter.hpp"
#include "scene_writers.hpp"

namespace swiftgs::io {
namespace {

std::string ply_header_of(const Scene& scene) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  if (scene.antialiased) header += "comment SplatRenderMode: mip\n";
  header += "element vertex " + std::to_string(scene.size()) + "\n";
  const auto add = [&](const std::string& name) { header += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) add(name);
  for (int i = 0; i < 3 * sh_rest_count(scene.sh_degree); ++i) add("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    add(name);
  return header + "end_header\n";
}

float logit(float opacity) {
  const double p = std::clamp(double(opacity), 1e-6, 1 - 1e-6);
  return float(std::log(p / (1 - p)));
}

/// Appends Gaussian `i` as the header announces it.
void append_row(const Scene& scene, std::size_t i, std::string& out) {
  const auto add = [&](float value) {
    const auto raw = std::bit_cast<std::array<char, 4>>(value);
    if constexpr (std::endian::native == std::endian::little)
      out.append(raw.begin(), raw.end());
    else
      out.append(raw.rbegin(), raw.rend());
  };
  const auto add3 = [&](vec3 v) { add(v.x), add(v.y), add(v.z); };
  const std::size_t count = std::size_t(sh_rest_count(scene.sh_degree));
  const float* rest = scene.sh_rest.data() + i * 3 * count;
  add3(scene.means[i]);
  add3(vec3(0.0f));  // normals, which nobody reads
  add3(scene.sh0[i]);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < count; ++j) add(rest[3 * j + c]);
  add(logit(scene.opacities[i]));
  for (int axis = 0; axis < 3; ++axis) add(std::log(scene.scales[i][axis]));
  const Quaternion& q = scene.rotations[i];
  add(q.w), add(q.x), add(q.y), add(q.z);
}

}  // namespace

WrittenScene write_ply(const std::filesystem::path& path, const Scene& scene,
                       const SceneWriteOptions& options) {
  const ProgressMeter progress(options.progress, path.string());
  OutputFile file(path);
  std::string buffer = ply_header_of(scene);
  constexpr std::size_t flush_at = 1 << 20;
  for (std::size_t i = 0; i < scene.size(); ++i) {
    append_row(scene, i, buffer);
    if (buffer.size() < flush_at) continue;
    file.write(buffer.data(), buffer.size());
    buffer.clear();
    progress.report(double(i) / double(scene.size()));
  }
  file.write(buffer.data(), buffer.size());
  file.close();
  progress.report(1);
  return {.format = "INRIA PLY (binary_little_endian)", .bytes = file.size()};
}

}  // namespace swiftgs::io
