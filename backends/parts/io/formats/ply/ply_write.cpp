// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "ply_fields.hpp"
#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "scene_format.hpp"

namespace swiftgs::io {
namespace {

/// Whether positions are doubles.
bool has_origin(const Scene& scene) { return scene.origin != dvec3(0.0); }

std::string ply_header_of(const Scene& scene) {
  std::string header = "ply\nformat binary_little_endian 1.0\n" + model_comments(scene.model);
  header += "element vertex " + std::to_string(scene.size()) + "\n";
  const auto add = [&](const std::string& name) { header += "property float " + name + "\n"; };
  for (const char* name : {"x", "y", "z"})
    header += std::string("property ") + (has_origin(scene) ? "double " : "float ") + name + "\n";
  for (const char* name : {"nx", "ny", "nz", "f_dc_0", "f_dc_1", "f_dc_2"}) add(name);
  for (int i = 0; i < 3 * sh_rest_count(scene.sh_degree); ++i) add("f_rest_" + std::to_string(i));
  for (const char* name : {"opacity", "scale_0", "scale_1", "scale_2", "rot_0", "rot_1", "rot_2", "rot_3"})
    add(name);
  return header + "end_header\n";
}

float logit(float opacity) {
  const double p = std::clamp(double(opacity), 1e-6, 1 - 1e-6);
  return float(std::log(p / (1 - p)));
}

/// Gaussian `i` as the header announces it.
void encode_row(const Scene& scene, std::size_t i, RowEncoder row) {
  const std::size_t count = std::size_t(sh_rest_count(scene.sh_degree));
  const float* rest = scene.sh_rest.data() + i * 3 * count;
  if (has_origin(scene)) {
    const dvec3 position = scene.origin + dvec3(scene.means[i]);
    row.add(position.x), row.add(position.y), row.add(position.z);
  } else {
    row.add(scene.means[i]);
  }
  row.add(vec3(0.0f));  // normals, which nobody reads
  row.add(scene.sh0[i]);
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t j = 0; j < count; ++j) row.add(rest[3 * j + c]);
  row.add(logit(scene.opacities[i]));
  for (int axis = 0; axis < 3; ++axis) row.add(log_of_scale(scene.scales[i][axis]));
  const Quaternion& q = scene.rotations[i];
  row.add(q.w), row.add(q.x), row.add(q.y), row.add(q.z);
}

}  // namespace

WrittenScene write_ply(const std::filesystem::path& path, const Scene& scene,
                       const SceneWriteOptions& options, LossMeter&) {
  const ProgressMeter progress(options.progress, path.string());
  OutputFile file(path);
  const std::string header = ply_header_of(scene);
  file.write(header.data(), header.size());
  const std::size_t floats = 17 + 3 * std::size_t(sh_rest_count(scene.sh_degree));
  const std::size_t more = has_origin(scene) ? 3 * (sizeof(double) - sizeof(float)) : 0;
  write_rows(file, scene.size(), floats * sizeof(float) + more, progress,
             [&](std::size_t i, RowEncoder row) { encode_row(scene, i, row); });
  progress.report(1);  // a file that has taken its place cannot be cancelled
  file.close();
  WrittenScene written = written_whole("INRIA PLY (binary_little_endian)", scene);
  written.bytes = file.size();
  if (has_origin(scene))
    written.notes.push_back("Positions are written as doubles, those in the world: the scene's origin is " +
                            text_of(scene.origin) + ".");
  return written;
}

}  // namespace swiftgs::io
