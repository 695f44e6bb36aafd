// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/edit/order.hpp>
#include <swiftgs/edit/origin.hpp>

#include "ply_compressed.hpp"
#include "ply_fields.hpp"
#include "scene_building.hpp"
#include "scene_encoding.hpp"
#include "scene_format.hpp"

namespace swiftgs::io {
namespace {

/// A row of a compressed PLY.
struct ChunkRow {
  std::uint32_t gaussian;
  bool fills;  ///< shows nothing: of opacity 0, it fills the rest of a chunk
};

using Indices = std::vector<std::uint32_t>;

/// Takes those that stray out of `order` and keeps the order of both. Takes nothing if less than a chunk
/// would be left.
template <class Strays>
Indices take_out(Indices& order, const Strays& strays) {
  const auto count = std::size_t(std::count_if(order.begin(), order.end(), strays));
  if (count == 0 || order.size() - count < chunk_size) return {};
  Indices taken;
  std::erase_if(order, [&](std::uint32_t i) {
    if (strays(i)) taken.push_back(i);
    return strays(i);
  });
  return taken;
}

/// Appends a part that shares no chunk with what follows or precedes it.
void append(std::vector<ChunkRow>& rows, const Indices& part) {
  if (part.empty()) return;
  while (rows.size() % chunk_size != 0) rows.push_back({rows.back().gaussian, true});
  for (const std::uint32_t i : part) rows.push_back({i, false});
}

/// From 0 to 1 where the viewers that defined the format show it.
vec3 colour_of(const Scene& scene, std::size_t i) { return vec3(dvec3(scene.sh0[i]) * sh_c0 + 0.5); }

/// All Gaussians, of finite numbers, in the order in which the chunks of a compressed PLY have them. A chunk
/// divides its ranges evenly, so Gaussians of a chunk lie near each other, and those far from all others, or
/// of colours far beyond white, share no chunk with the rest. Rows that show nothing fill the chunks before
/// such a change. A scene of one chunk is not divided.
std::vector<ChunkRow> order_in_chunks(const Scene& scene) {
  constexpr float extreme = 8;  // a colour that leaves its neighbours less than 32 steps from black to white
  std::vector<ChunkRow> rows;
  Indices order = spatial_order(scene);
  while (!order.empty()) {
    const swiftgs::detail::Bulk bulk(order.size(), [&](std::size_t k) { return scene.means[order[k]]; });
    Indices rest = take_out(order, [&](std::uint32_t i) { return !bulk.has(scene.means[i]); });
    const Indices coloured = take_out(order, [&](std::uint32_t i) {
      const vec3 from_grey = glm::abs(colour_of(scene, i) - 0.5f);
      return std::max({from_grey.x, from_grey.y, from_grey.z}) > extreme;
    });
    append(rows, order), append(rows, coloured);
    swiftgs::detail::sort_spatially(scene, rest);
    order = std::move(rest);
  }
  return rows;
}

/// What other writers clamp logarithms of scales to; one of 0 would have no range.
constexpr float most_log_scale = 20;

vec3 log_scale_of(const Scene& scene, std::size_t i) {
  const vec3& scale = scene.scales[i];
  return glm::clamp(vec3(log_of_scale(scale.x), log_of_scale(scale.y), log_of_scale(scale.z)),
                    -most_log_scale, most_log_scale);
}

std::vector<ChunkRanges> ranges_of(const Scene& scene, const std::vector<ChunkRow>& rows) {
  std::vector<ChunkRanges> chunks((rows.size() + chunk_size - 1) / chunk_size);
  const auto measure = [&](std::size_t chunk) {
    const auto range_of = [&](const auto& value) {
      const std::size_t begin = chunk * chunk_size, end = std::min(begin + chunk_size, rows.size());
      Range3 range{value(scene, rows[begin].gaussian), value(scene, rows[begin].gaussian)};
      for (std::size_t k = begin + 1; k < end; ++k) {
        const vec3 v = value(scene, rows[k].gaussian);
        range = {glm::min(range.low, v), glm::max(range.high, v)};
      }
      return range;
    };
    const auto mean_of = [](const Scene& s, std::size_t i) { return s.means[i]; };
    chunks[chunk] = {range_of(mean_of), range_of(log_scale_of), range_of(colour_of)};
  };
  // Parts of Gaussians; a chunk belongs to the part of its first.
  for_parts(rows.size(), [&](std::size_t begin, std::size_t end) {
    const std::size_t first = (begin + chunk_size - 1) / chunk_size;
    for (std::size_t chunk = first; chunk * chunk_size < end; ++chunk) measure(chunk);
  });
  return chunks;
}

std::string header_of(const Scene& scene, std::size_t count, std::size_t chunks) {
  std::string header = "ply\nformat binary_little_endian 1.0\n" + model_comments(scene.model);
  const auto element = [&](const char* name, std::size_t rows) {
    header += "element " + std::string(name) + " " + std::to_string(rows) + "\n";
  };
  element("chunk", chunks);
  for (const char* name : chunk_properties) header += "property float " + std::string(name) + "\n";
  element("vertex", count);
  for (const char* name : vertex_properties) header += "property uint " + std::string(name) + "\n";
  if (scene.sh_degree > 0) element("sh", count);
  for (int i = 0; i < 3 * sh_rest_count(scene.sh_degree); ++i)
    header += "property uchar f_rest_" + std::to_string(i) + "\n";
  return header + "end_header\n";
}

void encode_chunk(const ChunkRanges& ranges, RowEncoder row) {
  for (const Range3* range : {&ranges.mean, &ranges.log_scale, &ranges.colour})
    row.add(range->low), row.add(range->high);
}

/// Where `value` lies in `range`, from 0 to 1; 0 of a range of one value.
dvec3 fraction(const Range3& range, vec3 value) {
  dvec3 result(0.0);
  for (int axis = 0; axis < 3; ++axis)
    if (range.low[axis] < range.high[axis])
      result[axis] = (double(value[axis]) - range.low[axis]) / (double(range.high[axis]) - range.low[axis]);
  return result;
}

PackedVertex packed(const Scene& scene, std::size_t i, const ChunkRanges& ranges) {
  const auto byte = [](double value) { return std::uint32_t(std::clamp(value, 0.0, 1.0) * 255 + 0.5); };
  const dvec3 colour = fraction(ranges.colour, colour_of(scene, i));
  const Quaternion& q = scene.rotations[i];
  return {pack_fractions(fraction(ranges.mean, scene.means[i])),
          pack_rotation(normalised(q.w, q.x, q.y, q.z)),
          pack_fractions(fraction(ranges.log_scale, log_scale_of(scene, i))),
          byte(colour.x) << 24 | byte(colour.y) << 16 | byte(colour.z) << 8 | byte(scene.opacities[i])};
}

void measure(std::size_t i, const Vertex& found, LossMeter& losses) {
  losses.add_position(i, found.mean);
  losses.add_scales(i, found.scale);
  losses.add_opacity(i, found.opacity);
  losses.add_colour(i, found.sh0);
}

/// Notes the numbers that the format cannot hold.
void note_clamped_fields(const Scene& scene, std::vector<std::string>& notes) {
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  ClampCount scales, harmonics;
  for_parts(scene.size(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      for (int axis = 0; axis < 3; ++axis)
        scales.add(std::abs(log_of_scale(scene.scales[i][axis])) > most_log_scale);
      for (std::size_t j = 0; j < rest; ++j) harmonics.add(std::abs(scene.sh_rest[i * rest + j]) > 4);
    }
  });
  scales.note("Scales", "exp(-20) to exp(20)", notes);
  harmonics.note("SH coefficients above band 0", "-4 to 4", notes);
}

WrittenScene write_compressed_ply(const std::filesystem::path& path, const Scene& scene,
                                  const SceneWriteOptions& options, LossMeter& losses) {
  const ProgressMeter progress(options.progress, path.string());
  progress.report(0);
  WrittenScene written = written_whole("compressed PLY", scene);
  const std::vector<ChunkRow> rows = order_in_chunks(scene);
  written.gaussians = rows.size(), written.added = rows.size() - scene.size();
  if (written.added > 0)
    written.notes.push_back(
        "Gaussians of opacity 0 are added, so that those far from the rest have chunks of "
        "their own: " +
        std::to_string(written.added) + ".");
  note_clamped_fields(scene, written.notes);
  progress.report(0.3);
  const std::vector<ChunkRanges> chunks = ranges_of(scene, rows);

  OutputFile file(path);
  const std::string header = header_of(scene, rows.size(), chunks.size());
  file.write(header.data(), header.size());
  write_rows(file, chunks.size(), chunk_properties.size() * sizeof(float), progress.step(0.3, 0.4),
             [&](std::size_t i, RowEncoder row) { encode_chunk(chunks[i], row); });
  write_rows(file, rows.size(), vertex_properties.size() * sizeof(std::uint32_t), progress.step(0.4, 0.6),
             [&](std::size_t i, RowEncoder row) {
               const auto [gaussian, fills] = rows[i];
               PackedVertex vertex = packed(scene, gaussian, chunks[i / chunk_size]);
               if (fills)
                 vertex[3] &= ~std::uint32_t(0xff);  // the opacity
               else
                 measure(gaussian, unpacked(vertex, chunks[i / chunk_size]), losses);
               for (const std::uint32_t word : vertex) row.add(word);
             });
  const std::size_t count = std::size_t(sh_rest_count(scene.sh_degree));
  if (count > 0)
    write_rows(file, rows.size(), 3 * count, progress.step(0.6, 1), [&](std::size_t i, RowEncoder row) {
      const float* rest = scene.sh_rest.data() + 3 * count * rows[i].gaussian;
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t j = 0; j < count; ++j) row.add(pack_sh(rest[3 * j + c], (i + j) % 2 == 0));
    });
  progress.report(1);  // a file that has taken its place cannot be cancelled
  file.close();
  written.bytes = file.size();
  if (const auto sentence = losses.sentence()) written.notes.push_back(*sentence);
  return written;
}

}  // namespace

constinit const SceneFormat compressed_ply_format{.name = "a compressed PLY",
                                                  .names = {".compressed.ply"},
                                                  .write = write_compressed_ply,
                                                  .place_in_capture = 2};

}  // namespace swiftgs::io
