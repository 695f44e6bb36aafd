// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <swiftgs/edit/origin.hpp>

#include "mapped_file.hpp"
#include "ply_compressed.hpp"
#include "ply_fields.hpp"
#include "ply_header.hpp"
#include "scene_building.hpp"
#include "scene_format.hpp"
#include "tasks.hpp"
#include "text.hpp"

namespace swiftgs::io {
namespace {

/// A field of a row in which every one is a little-endian float.
struct LittleFloat {
  float exact(const std::byte* row, PlyField field) const { return load<float>(row + field.offset); }
};

/// A field of any type and byte order.
struct AnyScalar {
  std::endian order;

  double exact(const std::byte* row, PlyField field) const { return scalar_at(row, field, order); }
};

/// Makes Gaussian `i` as smooth as Mip-Splatting's 3D filter does: variances grow along the first `axes`
/// local axes, and the opacity shrinks as the Gaussian grows.
void smooth(Scene& scene, std::size_t i, int axes, double deviation) {
  double kept = 1;
  for (int axis = 0; axis < axes; ++axis) {
    const double before = scene.scales[i][axis], after = std::hypot(before, deviation);
    scene.scales[i][axis] = float(after);
    if (after != 0) kept *= before / after;
  }
  scene.opacities[i] = float(scene.opacities[i] * kept);
}

/// The position in the world of the Gaussian in `row`.
template <class Field>
dvec3 position_in(const PlyLayout& layout, const std::byte* row, const Field& of) {
  return {of.exact(row, layout.mean[0]), of.exact(row, layout.mean[1]), of.exact(row, layout.mean[2])};
}

/// The rotation in `row`. A double holds quaternions that float would make zeros or infinite: they are scaled
/// first, as the length of a quaternion says nothing.
template <class Field>
Quaternion rotation_in(const PlyLayout& layout, const std::byte* row, const Field& of) {
  std::array<double, 4> q;
  for (std::size_t k = 0; k < 4; ++k) q[k] = of.exact(row, layout.rotation[k]);
  const double largest = std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2]), std::abs(q[3])});
  using Float = std::numeric_limits<float>;
  if (largest > Float::max() || (largest < Float::min() && largest != 0))
    for (double& component : q) component /= largest;
  return rotation_of(float(q[0]), float(q[1]), float(q[2]), float(q[3]));
}

/// Activates the Gaussian in `row` and stores it as number `i`.
template <class Field>
void decode_row(const PlyLayout& layout, const std::byte* row, const Field& of, Scene& scene, std::size_t i) {
  const auto field = [&](const std::byte* at, PlyField f) { return float(of.exact(at, f)); };
  const auto three = [&](const auto& f) {
    return vec3(field(row, f[0]), field(row, f[1]), field(row, f[2]));
  };
  const vec3 log_scale = three(layout.scale), colour = three(layout.colour);
  scene.means[i] = vec3(position_in(layout, row, of) - scene.origin);
  scene.scales[i] = {std::exp(log_scale.x), std::exp(log_scale.y), layout.flat ? 0 : std::exp(log_scale.z)};
  scene.rotations[i] = rotation_in(layout, row, of);
  scene.opacities[i] = sigmoid(field(row, layout.opacity));
  scene.sh0[i] = layout.byte_colour ? (colour / 255.0f - 0.5f) / float(sh_c0) : colour;
  float* rest = scene.sh_rest.data() + i * layout.sh.fields.size();
  for (const PlyField& f : layout.sh.fields) *rest++ = field(row, f);
  if (layout.filter) smooth(scene, i, layout.flat ? 2 : 3, of.exact(row, *layout.filter));
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

std::endian byte_order_of(const PlyHeader& header) {
  return header.encoding == PlyEncoding::little_endian ? std::endian::little : std::endian::big;
}

/// The origin for the scene that has the Gaussians in `rows` among others. Rows that cannot be parsed are
/// left to who decodes them.
dvec3 origin_of(const Source& source, const PlyHeader& header, const PlyElement& vertex,
                const PlyLayout& layout, const RowSample& rows) {
  OriginChoice choice;
  const auto add = [&](const std::byte* row, std::endian order) {
    const AnyScalar field{order};
    if (rotation_in(layout, row, field) == not_a_rotation) return;
    const auto scale = [&](int axis) { return field.exact(row, layout.scale[std::size_t(axis)]); };
    const double largest = std::max({scale(0), scale(1), layout.flat ? scale(1) : scale(2)});
    choice.add(position_in(layout, row, field), std::exp(float(largest)));
  };
  std::vector<double> numbers;
  for (const std::uint64_t position : rows) {
    if (header.encoding != PlyEncoding::ascii) {
      add(source.bytes.data() + position, byte_order_of(header));
      continue;
    }
    try {
      parse_text_row(source, vertex, position, numbers);
    } catch (const FormatError&) {
      continue;
    }
    add(reinterpret_cast<const std::byte*>(numbers.data()), std::endian::native);
  }
  return choice.origin();
}

/// Decodes vertices from number `first` on, as many as there is room for. The rows of all start at
/// `position`.
void decode_vertices(const Source& source, const PlyHeader& header, const PlyElement& vertex,
                     const PlyLayout& layout, std::uint64_t position, std::size_t first,
                     const ProgressMeter& progress, Scene& scene) {
  const std::size_t count = scene.size();
  if (header.encoding == PlyEncoding::ascii) {
    std::vector<double> row;
    for (std::size_t i = 0; i < first; ++i) position = parse_text_row(source, vertex, position, row);
    for (std::size_t i = 0; i < count; ++i) {
      position = parse_text_row(source, vertex, position, row);
      const auto* bytes = reinterpret_cast<const std::byte*>(row.data());
      decode_row(layout, bytes, AnyScalar{std::endian::native}, scene, i);
      if (i % (1 << 12) == 0) progress.report(double(i) / double(count));
    }
    progress.report(1);
    return;
  }
  position += first * layout.row_bytes;
  const std::endian order = byte_order_of(header);
  if (order == std::endian::little && layout.all_floats)
    decode_rows(source, position, layout, LittleFloat{}, progress, scene);
  else
    decode_rows(source, position, layout, AnyScalar{order}, progress, scene);
}

/// Whether the first line is `ply`. Exporters pad it, and end it in any way.
bool is_ply(std::string_view text) {
  text.remove_prefix(mark_bytes(text));
  if (!text.starts_with("ply")) return false;
  const std::size_t end = text.find_first_not_of(" \t", 3);
  return end != text.npos && (text[end] == '\n' || text[end] == '\r');
}

SceneFile read_ply(const Source& source, const SceneReadOptions& options) {
  const PlyHeader header = parse_ply_header(source);
  if (header.find("chunk")) return read_compressed_ply(source, header, options);
  const PlyElement* found = header.find("vertex");
  if (!found) source.fail(0, "a PLY with an element 'vertex'");
  const PlyElement& vertex = *found;
  PlyLayout layout = find_layout(source, vertex, header.encoding);
  std::vector<std::string> model_notes;
  RenderingModel model = model_of(header, layout.filter.has_value(), model_notes);
  if (!layout.has_third_scale) model.kernel = RenderingModel::Kernel::disk;
  layout.flat = model.kernel == RenderingModel::Kernel::disk;
  const ProgressMeter progress(options.progress, source.name);
  // Rows of binary files have known places. Finding the rows of text takes a third of the time.
  const double locating = header.encoding == PlyEncoding::ascii ? 0.3 : 0.02;
  RowSample sample;
  const auto starts = locate_rows(source, header, progress.step(0, locating), sample);

  SceneFile file;
  file.format = std::string("INRIA PLY (") + header.encoding_name() + ")";
  const auto [first, last] = options.part.range(vertex.count);
  file.stored = last - first;
  allocate(file.scene, file.stored, layout.sh.degree);
  file.scene.model = model;
  if (layout.wide_means()) file.scene.origin = origin_of(source, header, vertex, layout, sample);
  decode_vertices(source, header, vertex, layout, starts.at(vertex.name), first, progress.step(locating, 1),
                  file.scene);
  file.notes = notes_of(layout.flat && layout.has_third_scale, layout.sh);
  file.notes.insert(file.notes.end(), model_notes.begin(), model_notes.end());
  if (layout.filter)
    file.notes.push_back(
        "The 3D filter of the Gaussians (filter_3D) is applied to scales and opacities. They are drawn with "
        "the 2D "
        "filter of Mip-Splatting, unless a model says otherwise, as --model blur=0.3,antialiased=no does.");
  std::vector<std::string_view> read = {"vertex"};
  read_photograph(source, header, starts, file, read);
  note_unread(header, read, layout.unread, file.notes);
  file.left_out = leave_out_invalid(file.scene);
  return file;
}

}  // namespace

SceneWriter write_ply;

constinit const SceneFormat ply_format{.name = "a PLY",
                                       .names = {".ply"},
                                       .has_mark = is_ply,
                                       .read = read_ply,
                                       .reads_parts = true,
                                       .write = write_ply,
                                       .holds_doubles = true,
                                       .place_in_capture = 3};

}  // namespace swiftgs::io
