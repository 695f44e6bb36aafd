// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <swiftgs/edit/origin.hpp>

#include "ksplat_layout.hpp"
#include "scene_building.hpp"
#include "scene_format.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

/// Number `index` of those at `at`: floats at level 0, halves at levels 1 and 2.
template <int Level>
float number(const std::byte* at, std::size_t index) {
  if constexpr (Level == 0)
    return load<float>(at + 4 * index);
  else
    return half_to_float(load<std::uint16_t>(at + 2 * index));
}

template <int Level>
Quaternion rotation_of_record(const std::byte* record) {
  const auto component = [&](std::size_t k) { return number<Level>(record, 6 + k); };
  return rotation_of(component(0), component(1), component(2), component(3));
}

/// Tells the bucket of Gaussians that are asked for in order.
class BucketWalk {
 public:
  BucketWalk(const KsplatSection& section, std::uint64_t begin)
      : section_(section),
        partial_(std::upper_bound(section.partial_ends.begin(), section.partial_ends.end(), begin)) {}

  std::uint64_t bucket_of(std::uint64_t i) {
    if (i < section_.bucket_size * section_.full_buckets) return i / section_.bucket_size;
    while (*partial_ <= i) ++partial_;
    return section_.full_buckets + std::uint64_t(partial_ - section_.partial_ends.begin());
  }

 private:
  const KsplatSection& section_;
  std::vector<std::uint64_t>::const_iterator partial_;
};

dvec3 quantised_mean(const KsplatSection& section, const std::byte* record, std::uint64_t bucket) {
  dvec3 mean;
  const std::byte* centre = section.centres + 12 * bucket;
  for (int axis = 0; axis < 3; ++axis) {
    const double stored = load<std::uint16_t>(record + 2 * axis);
    mean[axis] = (stored - section.middle) * section.unit + double(load<float>(centre + 4 * axis));
  }
  return mean;
}

/// The position in the world of number `local` of a section, which `buckets` come to.
template <int Level>
dvec3 position_of(const KsplatSection& section, const std::byte* record, BucketWalk& buckets,
                  std::uint64_t local) {
  if constexpr (Level == 0)
    return {number<0>(record, 0), number<0>(record, 1), number<0>(record, 2)};
  else
    return quantised_mean(section, record, buckets.bucket_of(local));
}

/// Each band has its coefficients of red, then of green, then of blue.
template <class Value>
void decode_harmonics(int degree, const Value& value, float* to) {
  std::size_t index = 0;
  for (int band = 1; band <= degree; ++band)
    for (int channel = 0; channel < 3; ++channel)
      for (int k = sh_rest_count(band - 1); k < sh_rest_count(band); ++k)
        to[3 * k + channel] = value(index++);
}

std::array<float, 256> colours_of_bytes() {
  std::array<float, 256> colours;
  for (int byte = 0; byte < 256; ++byte) colours[std::size_t(byte)] = float((byte / 255.0 - 0.5) / sh_c0);
  return colours;
}

/// Decodes Gaussians [begin, end) of a section, the first of which is number 0.
template <int Level>
void decode(const KsplatLayout& layout, const KsplatSection& section, Scene& scene, std::uint64_t begin,
            std::uint64_t end) {
  constexpr std::size_t size = Level == 0 ? 4 : 2, colour_at = Level == 0 ? 40 : 20;
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  static const std::array<float, 256> colours = colours_of_bytes();
  BucketWalk buckets(section, begin);
  for (std::uint64_t local = begin; local < end; ++local) {
    const std::byte* record = section.records + local * section.record_bytes;
    const std::size_t i = section.first + local;
    scene.means[i] = vec3(position_of<Level>(section, record, buckets, local) - scene.origin);
    const std::byte *scale = record + 3 * size, *colour = record + colour_at;
    scene.scales[i] = {number<Level>(scale, 0), number<Level>(scale, 1), number<Level>(scale, 2)};
    scene.rotations[i] = rotation_of_record<Level>(record);
    for (int channel = 0; channel < 3; ++channel)
      scene.sh0[i][channel] = colours[std::to_integer<std::size_t>(colour[channel])];
    scene.opacities[i] = float(std::to_integer<int>(colour[3])) / 255;
    const std::byte* sh = record + ksplat_base_bytes[Level];
    decode_harmonics(
        section.sh_degree,
        [&](std::size_t k) {
          if constexpr (Level == 2)
            return layout.sh_of_byte[std::to_integer<std::size_t>(sh[k])];
          else
            return number<Level>(sh, k);
        },
        scene.sh_rest.data() + i * rest);
  }
}

/// Looks at Gaussians of each section.
template <int Level>
dvec3 origin_of(const KsplatLayout& layout) {
  OriginChoice choice;
  for (const KsplatSection& section : layout.sections) {
    BucketWalk buckets(section, 0);
    OriginChoice::for_each_sample(section.count, [&](std::size_t local) {
      const std::byte* record = section.records + local * section.record_bytes;
      if (rotation_of_record<Level>(record) == not_a_rotation) return;
      const std::byte* scale = record + 3 * (Level == 0 ? 4 : 2);
      const auto size = [&](std::size_t axis) { return std::abs(number<Level>(scale, axis)); };
      choice.add(position_of<Level>(section, record, buckets, local), std::max({size(0), size(1), size(2)}));
    });
  }
  return choice.origin();
}

SceneFile read_ksplat(const Source& source, const SceneReadOptions& options) {
  const ProgressMeter progress(options.progress, source.name);
  const KsplatLayout layout = parse_ksplat(source);
  SceneFile file;
  file.format = ".ksplat (level " + std::to_string(layout.level) + ")";
  file.stored = layout.count;
  allocate(file.scene, layout.count, layout.sh_degree);
  constexpr auto origins = std::array{origin_of<0>, origin_of<1>, origin_of<2>};
  file.scene.origin = origins[std::size_t(layout.level)](layout);
  constexpr auto decoders = std::array{decode<0>, decode<1>, decode<2>};
  const auto count = double(layout.count);
  for (const KsplatSection& section : layout.sections) {
    const auto part =
        progress.step(double(section.first) / count, double(section.first + section.count) / count);
    for_parts(section.count, part, [&](std::size_t begin, std::size_t end) {
      decoders[std::size_t(layout.level)](layout, section, file.scene, begin, end);
    });
  }
  drop_signs_of_scales(file);
  file.left_out = leave_out_invalid(file.scene);
  return file;
}

}  // namespace

constinit const SceneFormat ksplat_format{.name = "a .ksplat",
                                          .names = {".ksplat"},
                                          .looks_so = looks_like_ksplat,
                                          .goes_by_name = true,
                                          .read = read_ksplat,
                                          .place_in_capture = 6,
                                          .last_in_capture = true};

}  // namespace swiftgs::io
