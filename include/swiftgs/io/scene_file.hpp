// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/scene.hpp>

namespace swiftgs {

/// World axes that an SPZ file is stored in; letters name where +x, +y, +z point (Right, Left, Up, Down,
/// Forward, Back). A scene in memory is always RDF, the axes of COLMAP and of INRIA's files.
enum class SpzFrame {
  specified,  ///< what the file's coordinate-system extension says; without one RUB, as the format specifies
  rub,        ///< OpenGL's axes
  rdf,        ///< COLMAP's axes
  luf,        ///< glTF's axes
  raw,        ///< numbers as stored, the same as `rdf`: for files that a tool wrote without conversion
};

struct SceneReadOptions {
  SpzFrame spz_frame = SpzFrame::specified;
};

/// A scene and what reading it brought up.
struct SceneFile {
  Scene scene;
  std::string format;                   ///< such as "INRIA PLY (binary_little_endian)" or "SPZ version 2"
  std::uint64_t stored = 0;             ///< Gaussians in the file
  std::uint64_t dropped_nonfinite = 0;  ///< those of them with a NaN or an infinity that cannot be rendered
  std::vector<std::string> notes;       ///< what of the file the scene does not carry, a sentence each
};

/// Reads an INRIA PLY or an SPZ file (versions 1 to 4). The content decides which, never the name. `path` may
/// also be the folder of a capture, in which `find_capture` finds the file.
///
/// A Gaussian with a NaN, or with an infinite mean, rotation, SH coefficient or scale, is counted and left
/// out. A scale of 0 and an opacity of 0 or 1 are legal, whatever infinity the file writes them as. The file
/// must not change while it is read. Throws `FormatError`, `std::system_error` if it cannot be read, and what
/// `find_capture` throws.
SWIFTGS_API SceneFile read_scene(const std::filesystem::path& path, const SceneReadOptions& options = {});

/// `read_scene(path, options).scene`.
SWIFTGS_API Scene load_scene(const std::filesystem::path& path, const SceneReadOptions& options = {});

/// The same from memory; `name` stands for the file in error messages.
SWIFTGS_API SceneFile read_scene(std::span<const std::byte> bytes, const std::string& name,
                                 const SceneReadOptions& options = {});

/// An INRIA PLY from memory. Throws `FormatError`.
SWIFTGS_API SceneFile read_ply(std::span<const std::byte> bytes, const std::string& name);

/// An SPZ file from memory. Throws `FormatError`.
SWIFTGS_API SceneFile read_spz(std::span<const std::byte> bytes, const std::string& name,
                               const SceneReadOptions& options = {});

/// Writes an INRIA PLY, little-endian floats, with as many `f_rest` properties as the scene has bands.
/// Opacities are clamped to [1e-6, 1 - 1e-6], because the file holds logits; a scale of 0 becomes -infinity.
/// Throws `std::invalid_argument` as `validate` does, or `std::system_error` if the file cannot be written.
SWIFTGS_API void write_ply(const std::filesystem::path& path, const Scene& scene);

}  // namespace swiftgs
