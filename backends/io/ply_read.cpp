// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "parallel.hpp"
#include "ply_layout.hpp"
#include "ply_rows.hpp"
#include "scene_building.hpp"
#include "scene_readers.hpp"
#include "tokens.hpp"

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
  float* rest = scene.sh_rest.data() + i * layout.sh_rest.size();
  for (const PlyField& f : layout.sh_rest) *rest++ = field(row, f);
}

template <class Field>
void decode_rows(const PlyLayout& layout, const std::byte* rows, const Field& field,
                 const ProgressMeter& progress, Scene& scene) {
  for_parts(scene.size(), progress, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      decode_row(layout, rows + i * layout.row_bytes, field, scene, i);
  });
}

/// Decodes all vertices, which start at `position`.
void decode_vertices(const Source& source, const PlyHeader& header, const PlyElement& vertex,
                     const PlyLayout& layout, std::uint64_t position, const ProgressMeter& progress,
                     Scene& scene) {
  if (header.encoding == PlyEncoding::ascii) {
    std::vector<double> row;
    for (std::size_t i = 0; i < scene.size(); ++i) {
      position = parse_text_row(source, vertex, position, row);
      const auto* bytes = reinterpret_cast<const std::byte*>(row.data());
      decode_row(layout, bytes, AnyScalar{std::endian::native}, scene, i);
      if (i % (1 << 16) == 0) progress.report(double(i) / double(scene.size()));
    }
    return;
  }
  const std::byte* rows = source.bytes.data() + position;
  const bool little = header.encoding == PlyEncoding::little_endian;
  if (little && layout.all_floats)
    decode_rows(layout, rows, LittleFloat{}, progress, scene);
  else
    decode_rows(layout, rows, AnyScalar{little ? std::endian::little : std::endian::big}, progress, scene);
}

/// Whether the trainer's comments say that the Gaussians are 2D; the last one counts.
bool says_flat(const PlyHeader& header) {
  bool flat = false;
  for (const std::string& comment : header.comments) {
    Tokens tokens(comment);
    if (tokens.next() == "SplatRenderMode:") flat = tokens.next() == "2dgs";
  }
  return flat;
}

/// What the trainer's comments say of the render model; the last one counts.
void apply_comments(const PlyHeader& header, const PlyLayout& layout, SceneFile& file) {
  for (const std::string& comment : header.comments) {
    Tokens tokens(comment);
    const std::string_view key = tokens.next(), value = tokens.next();
    if (key == "SplatRenderMode:") {
      file.scene.antialiased = value == "mip";
    } else if (key == "antialiased" && (value == "0" || value == "1")) {
      file.scene.antialiased = value == "1";
    }
  }
  if (!layout.flat) return;
  const std::string unused = layout.has_third_scale ? ", and scale_2 is not used." : ".";
  file.notes.push_back("The Gaussians were trained as 2D ones; they are kept as flat 3D ones" + unused);
}

/// Checks that all elements fit the file before memory is taken for the vertices; returns where these start.
std::uint64_t locate_vertices(const Source& source, const PlyHeader& header, const PlyElement& vertex) {
  std::uint64_t position = header.size, vertices = 0;
  for (const PlyElement& element : header.elements) {
    if (&element == &vertex) vertices = position;
    position = skip_rows(source, element, header.encoding, position);
  }
  expect_end(source, header.encoding, position);
  return vertices;
}

const PlyElement& find_vertex_element(const Source& source, const PlyHeader& header) {
  const PlyElement* vertex = nullptr;
  for (const PlyElement& element : header.elements) {
    if (element.name == "chunk")
      source.fail(element.declared_at, "an INRIA PLY; a compressed PLY (element chunk) is not supported");
    if (element.name == "vertex") vertex = &element;
  }
  if (!vertex) source.fail(0, "a PLY with an element 'vertex'");
  return *vertex;
}

}  // namespace

SceneFile read_ply(const Source& source, const SceneReadOptions& options) {
  const PlyHeader header = parse_ply_header(source);
  const PlyElement& vertex = find_vertex_element(source, header);
  PlyLayout layout = find_layout(source, vertex, header.encoding);
  layout.flat = !layout.has_third_scale || says_flat(header);
  const std::uint64_t vertices = locate_vertices(source, header, vertex);

  SceneFile file;
  file.format = std::string("INRIA PLY (") + header.encoding_name() + ")";
  file.stored = vertex.count;
  allocate(file.scene, vertex.count, layout.sh_degree);
  decode_vertices(source, header, vertex, layout, vertices, ProgressMeter(options.progress, source.name),
                  file.scene);
  file.dropped_nonfinite = drop_nonfinite(file.scene);
  apply_comments(header, layout, file);
  if (layout.stored_sh_degree > layout.sh_degree)
    file.notes.push_back("SH coefficients of degree 4 are stored; degree 3 and below are kept.");
  return file;
}

}  // namespace swiftgs::io
