// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <string>

#include "axis_flip.hpp"
#include "parallel.hpp"
#include "scene_building.hpp"
#include "scene_readers.hpp"
#include "spz_content.hpp"
#include "spz_values.hpp"

namespace swiftgs::io {
namespace {

SpzContent unpack(const Source& source) {
  if (source.text().starts_with("\x1f\x8b")) return unpack_spz_gzip(source);
  ByteReader reader(source);
  const SpzHeader header = parse_spz_header(source, reader.take(spz_header_size, "an SPZ header"));
  return header.version == 4 ? unpack_spz_streams(source) : unpack_spz_plain(source);
}

AxisFlip choose_flip(const Source& source, const SpzContent& content, SpzFrame frame,
                     std::vector<std::string>& notes) {
  switch (frame) {
    case SpzFrame::rub:
      return rub_to_rdf;
    case SpzFrame::luf:
      return luf_to_rdf;
    case SpzFrame::rdf:
    case SpzFrame::raw:
      return {};
    case SpzFrame::specified:
      break;
  }
  if (content.coordinates.system == 0) return rub_to_rdf;
  const auto flip = flip_of_coordinate_system(content.coordinates.system);
  if (!flip)
    source.fail(content.coordinates.offset, "an SPZ coordinate system of 1 to 8 (y up or down), found " +
                                                std::to_string(content.coordinates.system));
  if (*flip != rub_to_rdf)
    notes.push_back("The file states its axes, and they are not RUB; they were converted.");
  return *flip;
}

/// Decodes Gaussians [begin, end) of all attributes.
void decode(const SpzContent& content, const SpzTables& tables, const AxisFlip& flip, Scene& scene,
            std::size_t begin, std::size_t end) {
  const SpzHeader& header = content.header;
  const auto sizes = spz_sizes(header);
  const auto signs = flip.sh_signs();
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  for (std::size_t i = begin; i < end; ++i) {
    const auto at = [&](SpzAttribute a) { return content.arrays[a].data() + i * sizes[a]; };
    const auto three = [](const std::array<float, 256>& table, const std::byte* from) {
      return vec3(table[std::to_integer<int>(from[0])], table[std::to_integer<int>(from[1])],
                  table[std::to_integer<int>(from[2])]);
    };
    scene.means[i] = flip.position(decode_spz_position(header, at(spz_positions)));
    scene.opacities[i] = float(std::to_integer<int>(*at(spz_alphas))) / 255;
    scene.sh0[i] = three(tables.colour, at(spz_colours));
    scene.scales[i] = three(tables.scale, at(spz_scales));
    scene.rotations[i] = flip.rotation(decode_spz_rotation(header, at(spz_rotations)));
    // Coefficients that are not kept are the last of each Gaussian.
    const std::byte* sh = at(spz_sh);
    for (std::size_t k = 0; k < rest; ++k)
      scene.sh_rest[i * rest + k] = signs[k / 3] * tables.sh[std::to_integer<int>(sh[k])];
  }
}

}  // namespace

SceneFile read_spz(const Source& source, const SceneReadOptions& options) {
  const ProgressMeter progress(options.progress, source.name);
  const SpzContent content = unpack(source);
  const SpzHeader& header = content.header;

  SceneFile file;
  file.format = "SPZ version " + std::to_string(header.version);
  file.stored = header.count;
  const AxisFlip flip = choose_flip(source, content, options.spz_frame, file.notes);
  allocate(file.scene, header.count, std::min(header.sh_degree, max_sh_degree));
  const SpzTables tables;
  for_parts(file.scene.size(), progress.step(0.5, 1), [&](std::size_t begin, std::size_t end) {
    decode(content, tables, flip, file.scene, begin, end);
  });
  file.scene.antialiased = header.antialiased;
  file.dropped_nonfinite = drop_nonfinite(file.scene);
  if (header.sh_degree > max_sh_degree)
    file.notes.push_back("SH coefficients of degree 4 are stored; degree 3 and below are kept.");
  return file;
}

}  // namespace swiftgs::io
