// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include <swiftgs/edit/select.hpp>

#include "mapped_file.hpp"
#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "scene_format.hpp"
#include "tasks.hpp"

/// @file
/// A `.splat` file is records of 32 bytes: mean and scales (3 floats each, the scales not logarithms), red,
/// green, blue and opacity (a byte each, 255 is 1), and the rotation w, x, y, z (a byte each, 128 is 0 and
/// 0 is -1, as the format's first viewer reads them). Some writers truncate where that viewer's own rounds;
/// no file says which.

namespace swiftgs::io {
namespace {

constexpr std::size_t splat_record_bytes = 32;

/// The SH coefficient of band 0 that a byte of a colour stands for.
float sh0_of_splat(std::uint8_t byte) { return float((double(byte) / 255 - 0.5) / sh_c0); }

/// Decodes the Gaussian in `record` as number `i`.
void decode_record(const std::byte* record, Scene& scene, std::size_t i) {
  const auto three = [&](std::size_t offset) {
    const auto at = [&](std::size_t k) { return load<float>(record + offset + 4 * k); };
    return vec3(at(0), at(1), at(2));
  };
  const auto byte = [&](std::size_t offset) { return load<std::uint8_t>(record + offset); };
  const auto component = [&](std::size_t offset) { return (float(byte(offset)) - 128) / 128; };
  scene.means[i] = three(0);
  scene.scales[i] = three(12);
  for (std::size_t c = 0; c < 3; ++c) scene.sh0[i][int(c)] = sh0_of_splat(byte(24 + c));
  scene.opacities[i] = float(byte(27)) / 255;
  scene.rotations[i] = rotation_of(component(28), component(29), component(30), component(31));
}

SceneFile read_splat(const Source& source, const SceneReadOptions& options) {
  const std::uint64_t size = source.bytes.size(), partial = size % splat_record_bytes;
  if (partial != 0)
    source.fail(size - partial, "records of 32 bytes, as a .splat scene has, found the last one with " +
                                    std::to_string(partial));
  SceneFile file;
  file.format = ".splat";
  const auto [first, last] = options.part.range(size / splat_record_bytes);
  file.stored = last - first;
  allocate(file.scene, file.stored, 0);
  const ProgressMeter progress(options.progress, source.name);
  const std::uint64_t position = first * splat_record_bytes;
  for_parts(file.stored, progress, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      decode_record(source.bytes.data() + position + i * splat_record_bytes, file.scene, i);
    let_go(source, position + begin * splat_record_bytes, position + end * splat_record_bytes);
  });
  drop_signs_of_scales(file);
  file.left_out = leave_out_invalid(file.scene);
  return file;
}

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

}  // namespace

constinit const SceneFormat splat_format{.name = "a .splat",
                                         .names = {".splat"},
                                         .goes_by_name = true,
                                         .read = read_splat,
                                         .reads_parts = true,
                                         .write = write_splat,
                                         .place_in_capture = 7,
                                         .last_in_capture = true};

}  // namespace swiftgs::io
