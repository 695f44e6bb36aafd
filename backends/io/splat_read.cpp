// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "mapped_file.hpp"
#include "parallel.hpp"
#include "scene_building.hpp"
#include "scene_readers.hpp"
#include "splat_record.hpp"

namespace swiftgs::io {
namespace {

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

}  // namespace

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

}  // namespace swiftgs::io
