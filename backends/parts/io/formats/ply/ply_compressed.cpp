// SPDX-License-Identifier: Apache-2.0

#include "ply_compressed.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include <swiftgs/project/sh.hpp>

#include "mapped_file.hpp"
#include "ply_fields.hpp"
#include "ply_header.hpp"
#include "scene_building.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

std::uint32_t nearest(double fraction, std::uint32_t most) {
  return std::uint32_t(std::clamp(fraction, 0.0, 1.0) * most + 0.5);
}

dvec3 within(const Range3& range, dvec3 fraction) {
  return dvec3(range.low) * (1.0 - fraction) + dvec3(range.high) * fraction;
}

}  // namespace

std::uint32_t pack_fractions(dvec3 fractions) {
  return nearest(fractions.x, 2047) << 21 | nearest(fractions.y, 1023) << 11 | nearest(fractions.z, 2047);
}

dvec3 unpack_fractions(std::uint32_t packed) {
  return {double(packed >> 21) / 2047, double(packed >> 11 & 1023) / 1023, double(packed & 2047) / 2047};
}

std::uint32_t pack_rotation(Quaternion unit) {
  const std::array<double, 4> q = {unit.w, unit.x, unit.y, unit.z};
  const auto smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto largest = std::size_t(std::max_element(q.begin(), q.end(), smaller) - q.begin());
  // The negative quaternion is the same rotation, and a largest component that is positive needs no sign.
  const double scale = std::copysign(1 / std::numbers::sqrt2, q[largest]);
  auto packed = std::uint32_t(largest);
  for (std::size_t i = 0; i < 4; ++i)
    if (i != largest) packed = packed << 10 | nearest(q[i] * scale + 0.5, 1023);
  return packed;
}

Quaternion unpack_rotation(std::uint32_t packed) {
  const std::size_t largest = packed >> 30;
  std::array<double, 4> q{};
  double squared = 0;
  for (std::size_t i = 0, shift = 20; i < 4; ++i) {
    if (i == largest) continue;
    q[i] = (double(packed >> shift & 1023) / 1023 - 0.5) * std::numbers::sqrt2;
    squared += q[i] * q[i];
    shift -= 10;
  }
  q[largest] = std::sqrt(std::max(0.0, 1 - squared));
  return normalised(float(q[0]), float(q[1]), float(q[2]), float(q[3]));
}

Vertex unpacked(const PackedVertex& packed, const ChunkRanges& ranges) {
  const auto [position, rotation, scale, colour_and_opacity] = packed;
  const dvec3 log_scale = within(ranges.log_scale, unpack_fractions(scale));
  const auto byte = [&, word = colour_and_opacity](int shift) { return double(word >> shift & 255); };
  const dvec3 colour = within(ranges.colour, dvec3(byte(24), byte(16), byte(8)) / 255.0);
  return {.mean = vec3(within(ranges.mean, unpack_fractions(position))),
          .scale = vec3(std::exp(log_scale.x), std::exp(log_scale.y), std::exp(log_scale.z)),
          .sh0 = vec3((colour - 0.5) / sh_c0),
          .rotation = unpack_rotation(rotation),
          .opacity = float(byte(0)) / 255};
}

std::uint8_t pack_sh(float coefficient, bool lower) {
  const double at = double(coefficient) * 32 + 128;
  // Bytes 0 and 255 stand for 0 and 256, which is further from their neighbours' 1.5 and 254.5 than 1.
  if (at < 0.75) return 0;
  if (at >= 255.25) return 255;
  const bool tie = at == std::floor(at) && at >= 2 && at <= 254;
  return std::uint8_t(std::clamp(at - (tie && lower ? 1 : 0), 1.0, 254.0));
}

float unpack_sh(std::uint8_t packed) {
  if (packed == 0) return -4;
  return packed == 255 ? 4 : (float(packed) + 0.5f) / 32 - 4;
}

namespace {

/// Rows of an element in the file.
struct Rows {
  std::uint64_t position = 0;
  std::size_t row_bytes = 0;
  std::vector<PlyField> fields;
};

/// What the elements of a file are.
struct CompressedLayout {
  Rows chunks, vertices, harmonics;
  PlySh sh;
  std::vector<std::string> unread;  ///< other properties
};

void append(std::vector<std::string>& to, std::vector<std::string> names) {
  std::move(names.begin(), names.end(), std::back_inserter(to));
}

Rows find_rows(PlyFields& fields, std::span<const char* const> names, PlyType type, const char* type_name,
               std::uint64_t position, std::vector<std::string>& unread) {
  Rows rows{position, fields.row_bytes(), {}};
  for (const char* name : names) rows.fields.push_back(fields.take(name, type, type_name));
  append(unread, fields.untaken());
  return rows;
}

/// The coefficients, which `element` holds.
void find_harmonics(const Source& source, const PlyElement& element, std::uint64_t vertices,
                    std::uint64_t position, CompressedLayout& layout) {
  if (element.count != vertices)
    source.fail(element.declared_at, "as many rows of 'sh' as of 'vertex', " + std::to_string(vertices) +
                                         ", found " + std::to_string(element.count));
  PlyFields fields(source, element, PlyEncoding::little_endian);
  layout.sh = fields.find_sh();
  for (const PlyField& field : layout.sh.fields)
    if (field.type != PlyType::u8) fields.fail("f_rest_0, f_rest_1, ... of type uchar");
  layout.harmonics = {position, fields.row_bytes(), layout.sh.fields};
  append(layout.unread, fields.untaken());
}

CompressedLayout find_compressed_layout(const Source& source, const PlyHeader& header,
                                        const ProgressMeter& progress) {
  const PlyElement *chunk = header.find("chunk"), *vertex = header.find("vertex"), *sh = header.find("sh");
  if (header.encoding != PlyEncoding::little_endian)
    source.fail(0, "a compressed PLY of format binary_little_endian");
  if (!vertex) source.fail(0, "a PLY with an element 'vertex'");
  const std::uint64_t chunks = vertex->count / chunk_size + (vertex->count % chunk_size != 0);
  if (chunk->count != chunks)
    source.fail(chunk->declared_at, std::to_string(chunks) + " chunks for " + std::to_string(vertex->count) +
                                        " vertices, found " + std::to_string(chunk->count));
  RowSample unused;
  const auto starts = locate_rows(source, header, progress, unused);
  CompressedLayout layout;
  PlyFields chunk_fields(source, *chunk, header.encoding), vertex_fields(source, *vertex, header.encoding);
  const std::span<const char* const> ranges(chunk_properties);
  layout.chunks = find_rows(chunk_fields, chunk_fields.has("min_r") ? ranges : ranges.first(12), PlyType::f32,
                            "float", starts.at("chunk"), layout.unread);
  layout.vertices =
      find_rows(vertex_fields, vertex_properties, PlyType::u32, "uint", starts.at("vertex"), layout.unread);
  if (sh) find_harmonics(source, *sh, vertex->count, starts.at("sh"), layout);
  return layout;
}

ChunkRanges decode_chunk(const Rows& chunks, const std::byte* row) {
  ChunkRanges ranges;
  const auto three = [&](std::size_t first) {
    const auto field = [&](std::size_t i) { return load<float>(row + chunks.fields[first + i].offset); };
    return vec3(field(0), field(1), field(2));
  };
  ranges.mean = {three(0), three(3)};
  ranges.log_scale = {three(6), three(9)};
  if (chunks.fields.size() > 12) ranges.colour = {three(12), three(15)};
  return ranges;
}

void decode_vertex(const ChunkRanges& ranges, const Rows& vertices, const std::byte* row, bool flat,
                   Scene& scene, std::size_t i) {
  PackedVertex packed;
  for (std::size_t field = 0; field < packed.size(); ++field)
    packed[field] = load<std::uint32_t>(row + vertices.fields[field].offset);
  const Vertex vertex = unpacked(packed, ranges);
  scene.means[i] = vertex.mean;
  scene.rotations[i] = vertex.rotation;
  scene.scales[i] = vertex.scale;
  if (flat) scene.scales[i].z = 0;
  scene.sh0[i] = vertex.sh0;
  scene.opacities[i] = vertex.opacity;
}

/// Gaussians from number `first` on, as many as `scene` has.
void decode_gaussians(const Source& source, const CompressedLayout& layout, bool flat, std::size_t first,
                      const ProgressMeter& progress, Scene& scene) {
  const auto row = [&](const Rows& rows, std::size_t i) {
    return source.bytes.data() + rows.position + i * rows.row_bytes;
  };
  const std::size_t rest = layout.sh.fields.size();
  for_parts(scene.size(), progress, [&](std::size_t begin, std::size_t end) {
    ChunkRanges ranges;
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t stored = first + i;
      if (i == begin || stored % chunk_size == 0)
        ranges = decode_chunk(layout.chunks, row(layout.chunks, stored / chunk_size));
      decode_vertex(ranges, layout.vertices, row(layout.vertices, stored), flat, scene, i);
      for (std::size_t k = 0; k < rest; ++k)
        scene.sh_rest[i * rest + k] =
            unpack_sh(load<std::uint8_t>(row(layout.harmonics, stored) + layout.sh.fields[k].offset));
    }
    for (const Rows* rows : {&layout.vertices, &layout.harmonics})
      let_go(source, rows->position + (first + begin) * rows->row_bytes,
             rows->position + (first + end) * rows->row_bytes);
  });
}

}  // namespace

SceneFile read_compressed_ply(const Source& source, const PlyHeader& header,
                              const SceneReadOptions& options) {
  const ProgressMeter progress(options.progress, source.name);
  const CompressedLayout layout = find_compressed_layout(source, header, progress.step(0, 0.05));
  std::vector<std::string> model_notes;
  const RenderingModel model = model_of(header, false, model_notes);
  const bool flat = model.kernel == RenderingModel::Kernel::disk;
  SceneFile file;
  file.format = "compressed PLY";
  const auto [first, last] = options.part.range(header.find("vertex")->count);
  file.stored = last - first;
  allocate(file.scene, file.stored, layout.sh.degree);
  file.scene.model = model;
  decode_gaussians(source, layout, flat, first, progress.step(0.05, 1), file.scene);
  file.left_out = leave_out_invalid(file.scene);
  file.notes = notes_of(flat, layout.sh);
  file.notes.insert(file.notes.end(), model_notes.begin(), model_notes.end());
  note_unread(header, {"chunk", "vertex", "sh"}, layout.unread, file.notes);
  return file;
}

}  // namespace swiftgs::io
