// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <future>
#include <optional>
#include <string>

#include <swiftgs/edit/rotation.hpp>

#include "scene_building.hpp"
#include "scene_format.hpp"
#include "spz_content.hpp"
#include "tasks.hpp"

namespace swiftgs::io {
namespace {

SpzContent unpack(const Source& source, const SpzUnpacking& unpacking) {
  if (source.text().starts_with("\x1f\x8b")) return unpack_spz_gzip(source, unpacking);
  return read_spz_header(source).version == 4 ? unpack_spz_streams(source, unpacking)
                                              : unpack_spz_plain(source, unpacking);
}

SpzAxes choose_axes(const Source& source, const SpzExtensions& stated, SpzFrame frame,
                    std::vector<std::string>& notes) {
  const auto axes = axes_of_spz_system(stated.system);
  const bool known = stated.system < spz_system_names.size();
  const std::string name =
      known ? std::string(spz_system_names[stated.system]) : "system " + std::to_string(stated.system);
  if (frame != SpzFrame::specified) {
    const SpzAxes wanted{flip_of(frame)};
    if (stated.system != 0 && axes != wanted)
      notes.push_back("The file states the axes " + name + "; the axes asked for were taken instead.");
    return wanted;
  }
  if (stated.system == 0) return {rub_to_rdf};
  if (!axes)
    source.fail(stated.offset, "an SPZ coordinate system of 0 to 16, found " + std::to_string(stated.system));
  if (*axes != SpzAxes{rub_to_rdf})
    notes.push_back("The axes are " + name + ", as the file states, and not RUB.");
  return *axes;
}

/// Decodes Gaussians [begin, end) of a scene that begins with number `first` of the file, all attributes.
class SpzDecoder {
 public:
  SpzDecoder(const SpzContent& content, const SpzAxes& axes, int sh_degree, std::size_t first)
      : content_(content), axes_(axes), first_(first), sizes_(spz_sizes(content.header)) {
    if (axes.quarter_turn)
      turn_.emplace(axes.matrix(), sh_degree);
    else
      signs_ = axes.flip.sh_signs();
  }

  void decode(Scene& scene, std::size_t begin, std::size_t end) const {
    for (std::size_t i = begin; i < end; ++i) {
      scene.means[i] = axes_.position(decode_spz_position(content_.header, at(spz_positions, i)));
      scene.opacities[i] = decode_spz_opacity(at(spz_alphas, i));
      scene.sh0[i] = SpzTables::three(tables_.colour, at(spz_colours, i));
      scene.scales[i] = SpzTables::three(tables_.scale, at(spz_scales, i));
      scene.rotations[i] = axes_.rotation(decode_spz_rotation(content_.header, at(spz_rotations, i)));
    }
    if (scene.sh_degree != 0) decode_harmonics(scene, begin, end);
  }

 private:
  const std::byte* at(SpzAttribute a, std::size_t i) const {
    return content_.arrays[a].data() + (first_ + i) * sizes_[a];
  }

  void decode_harmonics(Scene& scene, std::size_t begin, std::size_t end) const {
    const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
    std::array<float, 3 * sh_rest_count(max_sh_degree)> steps;
    for (std::size_t k = 0; k < rest; ++k) steps[k] = signs_[k / 3] / 128;
    for (std::size_t i = begin; i < end; ++i) {
      // Coefficients that are not kept are the last of each Gaussian.
      const std::byte* from = at(spz_sh, i);
      float* to = scene.sh_rest.data() + i * rest;
      for (std::size_t k = 0; k < rest; ++k) to[k] = steps[k] * float(std::to_integer<int>(from[k]) - 128);
      if (turn_) turn_->apply(to);
    }
  }

  const SpzContent& content_;
  SpzAxes axes_;
  std::size_t first_;
  std::array<std::size_t, spz_attributes> sizes_;
  SpzTables tables_;
  std::array<float, 15> signs_ = AxisFlip{}.sh_signs();
  std::optional<ShRotation> turn_;
};

bool is_spz(std::string_view text) { return text.starts_with("NGSP") || is_gzip_of_spz(text); }

SceneFile read_spz(const Source& source, const SceneReadOptions& options) {
  const ProgressMeter progress(options.progress, source.name);
  progress.report(0);
  SceneFile file;
  // Taking the memory of a large scene lasts about as long as unpacking it.
  std::future<void> allocated;
  const auto take = [&](const SpzHeader& header) {
    const std::size_t size = options.part.range(header.count).size();
    allocated = std::async(std::launch::async, [&, count = size, degree = header.sh_degree] {
      allocate(file.scene, count, std::min(degree, max_sh_degree));
    });
  };
  const SpzContent content = unpack(source, {progress.step(0, 0.6), take});
  allocated.get();
  const SpzHeader& header = content.header;

  file.format = "SPZ version " + std::to_string(header.version);
  const ScenePart::Range range = options.part.range(header.count);
  file.stored = range.size();
  file.notes = content.extensions.notes;
  const SpzAxes axes = choose_axes(source, content.extensions, options.spz_frame, file.notes);
  const SpzDecoder decoder(content, axes, file.scene.sh_degree, range.begin);
  for_parts(file.scene.size(), progress.step(0.6, 1),
            [&](std::size_t first, std::size_t end) { decoder.decode(file.scene, first, end); });
  file.scene.model.antialiased = header.antialiased;
  // Only the halves of version 1 can be infinite or NaN, and every quaternion of SPZ is a rotation.
  if (header.version == 1) file.left_out = leave_out_invalid(file.scene);
  if (header.sh_degree > max_sh_degree)
    file.notes.push_back("SH coefficients of degree 4 are stored; degree 3 and below are kept.");
  return file;
}

}  // namespace

SpzHeader read_spz_header(const Source& source) {
  if (source.text().starts_with("\x1f\x8b")) return read_spz_gzip_header(source);
  return parse_spz_header(source, ByteReader(source).take(spz_header_size, "an SPZ header"));
}

SceneWriter write_spz;

constinit const SceneFormat spz_format{.name = "an SPZ",
                                       .names = {".spz"},
                                       .has_mark = is_spz,
                                       .read = read_spz,
                                       .reads_parts = true,
                                       .write = write_spz,
                                       .place_in_capture = 1};

}  // namespace swiftgs::io
