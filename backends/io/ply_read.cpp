// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "mapped_file.hpp"
#include "parallel.hpp"
#include "ply_compressed.hpp"
#include "ply_layout.hpp"
#include "ply_model.hpp"
#include "ply_rows.hpp"
#include "scene_building.hpp"
#include "scene_readers.hpp"

namespace swiftgs::io {
namespace {

/// A field of a row in which every one is a little-endian float.
struct LittleFloat {
  float operator()(const std::byte* row, PlyField field) const { return load<float>(row + field.offset); }
};

/// A field of any type and byte order.
struct AnyScalar {
  std::endian order;

  float operator()(const std::byte* row, PlyField field) const {
    const std::byte* at = row + field.offset;
    switch (field.type) {
      case PlyType::i8:
        return load<std::int8_t>(at, order);
      case PlyType::u8:
        return load<std::uint8_t>(at, order);
      case PlyType::i16:
        return load<std::int16_t>(at, order);
      case PlyType::u16:
        return load<std::uint16_t>(at, order);
      case PlyType::i32:
        return float(load<std::int32_t>(at, order));
      case PlyType::u32:
        return float(load<std::uint32_t>(at, order));
      case PlyType::f32:
        return load<float>(at, order);
      default:
        return float(load<double>(at, order));
    }
  }
};

/// Activates the Gaussian in `row` and stores it as number `i`.
template <class Field>
void decode_row(const PlyLayout& layout, const std::byte* row, const Field& field, Scene& scene,
                std::size_t i) {
  const auto three = [&](const auto& f) {
    return vec3(field(row, f[0]), field(row, f[1]), field(row, f[2]));
  };
  const vec3 log_scale = three(layout.scale), colour = three(layout.colour);
  scene.means[i] = three(layout.mean);
  scene.scales[i] = {std::exp(log_scale.x), std::exp(log_scale.y), layout.flat ? 0 : std::exp(log_scale.z)};
  scene.rotations[i] = normalised(field(row, layout.rotation[0]), field(row, layout.rotation[1]),
                                  field(row, layout.rotation[2]), field(row, layout.rotation[3]));
  scene.opacities[i] = sigmoid(field(row, layout.opacity));
  scene.sh0[i] = layout.byte_colour ? (colour / 255.0f - 0.5f) / float(sh_c0) : colour;
  float* rest = scene.sh_rest.data() + i * layout.sh.fields.size();
  for (const PlyField& f : layout.sh.fields) *rest++ = field(row, f);
}

template <class Field>
void decode_rows(const Source& source, std::uint64_t position, const PlyLayout& layout, const Field& field,
                 const ProgressMeter& progress, Scene& scene) {
  const std::byte* rows = source.bytes.data() + position;
  for_parts(scene.size(), progress, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      decode_row(layout, rows + i * layout.row_bytes, field, scene, i);
    let_go(source, position + begin * layout.row_bytes, position + end * layout.row_bytes);
  });
}

/// Decodes vertices from number `first` on, as many as `scene` has. The rows of all start at `position`.
void decode_vertices(const Source& source, const PlyHeader& header, const PlyElement& vertex,
                     const PlyLayout& layout, std::uint64_t position, std::size_t first,
                     const ProgressMeter& progress, Scene& scene) {
  if (header.encoding == PlyEncoding::ascii) {
    std::vector<double> row;
    for (std::size_t i = 0; i < first; ++i) position = parse_text_row(source, vertex, position, row);
    for (std::size_t i = 0; i < scene.size(); ++i) {
      position = parse_text_row(source, vertex, position, row);
      const auto* bytes = reinterpret_cast<const std::byte*>(row.data());
      decode_row(layout, bytes, AnyScalar{std::endian::native}, scene, i);
      if (i % (1 << 12) == 0) progress.report(double(i) / double(scene.size()));
    }
    progress.report(1);
    return;
  }
  position += first * layout.row_bytes;
  const std::endian order =
      header.encoding == PlyEncoding::little_endian ? std::endian::little : std::endian::big;
  if (order == std::endian::little && layout.all_floats)
    decode_rows(source, position, layout, LittleFloat{}, progress, scene);
  else
    decode_rows(source, position, layout, AnyScalar{order}, progress, scene);
}

}  // namespace

SceneFile read_ply(const Source& source, const SceneReadOptions& options) {
  const PlyHeader header = parse_ply_header(source);
  if (header.find("chunk")) return read_compressed_ply(source, header, options);
  const PlyElement* found = header.find("vertex");
  if (!found) source.fail(0, "a PLY with an element 'vertex'");
  const PlyElement& vertex = *found;
  const PlyModel model = model_of(header);
  PlyLayout layout = find_layout(source, vertex, header.encoding);
  layout.flat = !layout.has_third_scale || model.flat;
  const ProgressMeter progress(options.progress, source.name);
  // Rows of binary files are where they are. Those of text are looked for, which takes a third of the time.
  const double locating = header.encoding == PlyEncoding::ascii ? 0.3 : 0.02;
  const std::uint64_t vertices = locate_rows(source, header, progress.step(0, locating)).at(vertex.name);

  SceneFile file;
  file.format = std::string("INRIA PLY (") + header.encoding_name() + ")";
  const auto [first, last] = options.part.range(vertex.count);
  file.stored = last - first;
  allocate(file.scene, file.stored, layout.sh.degree);
  file.scene.antialiased = model.antialiased;
  decode_vertices(source, header, vertex, layout, vertices, first, progress.step(locating, 1), file.scene);
  file.dropped_nonfinite = drop_nonfinite(file.scene);
  file.notes = notes_of(layout.flat, layout.has_third_scale, layout.sh);
  note_unread(header, {"vertex"}, layout.unread, file.notes);
  return file;
}

}  // namespace swiftgs::io
