// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include <swiftgs/edit/select.hpp>

#include "row_writing.hpp"
#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "scene_writers.hpp"
#include "splat_record.hpp"

namespace swiftgs::io {
namespace {

/// Puts Gaussians of more volume and opacity first: viewers that load a file little by little show them
/// first.
void sort_by_size(const Scene& scene, std::vector<std::uint32_t>& order) {
  std::vector<std::pair<double, std::uint32_t>> keys(order.size());
  for_parts(order.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const dvec3 scale(scene.scales[order[k]]);
      keys[k] = {-scale.x * scale.y * scale.z * double(scene.opacities[order[k]]), order[k]};
    }
  });
  std::sort(keys.begin(), keys.end());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& key) { return key.second; });
}

dvec3 byte_colour_of(const Scene& scene, std::size_t i) {
  return 255.0 * (dvec3(scene.sh0[i]) * sh_c0 + 0.5);
}

std::uint8_t nearest_byte(double value) { return std::uint8_t(std::clamp(value, 0.0, 255.0) + 0.5); }

void encode_record(const Scene& scene, std::size_t i, RowEncoder row, LossMeter& losses) {
  const dvec3 colour = byte_colour_of(scene, i);
  const Quaternion unit =
      normalised(scene.rotations[i].w, scene.rotations[i].x, scene.rotations[i].y, scene.rotations[i].z);
  const std::array<double, 4> q = {unit.w, unit.x, unit.y, unit.z};
  // Bytes hold -1 but not 1; the negative quaternion is the same rotation.
  const bool negate = *std::max_element(q.begin(), q.end()) > 127.5 / 128;
  row.add(scene.means[i]);
  row.add(scene.scales[i]);
  vec3 sh0;
  for (int c = 0; c < 3; ++c) {
    const std::uint8_t byte = nearest_byte(colour[c]);
    row.add(byte);
    sh0[c] = sh0_of_splat(byte);
  }
  losses.add_colour(i, sh0);
  const std::uint8_t opacity = nearest_byte(255 * double(scene.opacities[i]));
  row.add(opacity);
  losses.add_opacity(i, float(opacity) / 255);
  for (const double component : q) row.add(nearest_byte(128 + 128 * (negate ? -component : component)));
}

void note_losses(const Scene& scene, const std::vector<std::uint32_t>& order,
                 std::vector<std::string>& notes) {
  if (scene.sh_degree > 0)
    notes.push_back("Harmonics of degree 1 to " + std::to_string(scene.sh_degree) + " are left out, " +
                    std::to_string(3 * sh_rest_count(scene.sh_degree)) + " coefficients of each of " +
                    std::to_string(order.size()) + " Gaussians.");
  ClampCount colours;
  for_parts(order.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const dvec3 colour = byte_colour_of(scene, order[k]);
      for (int c = 0; c < 3; ++c) colours.add(colour[c] < -0.5 || colour[c] > 255.5);
    }
  });
  colours.note("Channels of colours", "0 to 1", notes);
}

}  // namespace

WrittenScene write_splat(const std::filesystem::path& path, const Scene& scene,
                         const SceneWriteOptions& options, LossMeter& losses) {
  const ProgressMeter progress(options.progress, path.string());
  progress.report(0);
  WrittenScene written = written_whole(".splat", scene);
  written.sh_degree = 0;
  written.model = {};
  std::vector<std::uint32_t> order = select(scene, [](std::size_t) { return true; });
  sort_by_size(scene, order);
  note_losses(scene, order, written.notes);
  OutputFile file(path);
  write_rows(file, order.size(), splat_record_bytes, progress.step(0.5, 1),
             [&](std::size_t i, RowEncoder row) { encode_record(scene, order[i], row, losses); });
  progress.report(1);  // a file that has taken its place cannot be cancelled
  file.close();
  written.bytes = file.size();
  return written;
}

}  // namespace swiftgs::io
