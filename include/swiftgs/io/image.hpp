// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <swiftgs/frame.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/math.hpp>

namespace swiftgs {

/// A picture from a file, rows from top to bottom.
struct Image {
  int width = 0, height = 0;
  int channels = 0;             ///< 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha
  std::vector<float> pixels{};  ///< @shape{height, width, channels} 0 to 1 from integer files, else as stored
};

/// Reads a PNG (8 or 16 bits), a JPEG, a PFM or, where built with OpenEXR, an EXR. The content decides which,
/// never the name. Values are those of the file: no gamma is applied, no colour profile is used. Throws
/// `FormatError`, or `FileError` if the file cannot be read.
SWIFTGS_API Image read_image(const std::filesystem::path& path);

/// The same from memory; `name` stands for the file in error messages.
SWIFTGS_API Image read_image(std::span<const std::byte> bytes, const std::string& name);

/// Writes colour as 8-bit RGB, clamped to 0 to 1 and rounded; a NaN becomes 0. With alpha in the frame the
/// image is RGBA, of straight colours: of colours over alpha, so the background should be black. Values are
/// the scene's own and written as they are: no gamma is applied. That is right if they are sRGB-encoded, as
/// they usually are. The writers throw `InvalidArgument` if the frame holds no colour, or
/// `FileError` if the file cannot be written; `path` then keeps what it held, as the new file takes
/// its place when it is whole.
SWIFTGS_API void write_png(const std::filesystem::path& path, const Frame& frame);

/// The bytes of the file that `write_png` writes.
SWIFTGS_API std::vector<std::byte> encode_png(const Frame& frame);

/// Writes colour as three floats a pixel in the byte order of this machine, which the file states.
SWIFTGS_API void write_pfm(const std::filesystem::path& path, const Frame& frame);

/// Writes float channels R, G and B, and the frame's other planes: A, Z (depth), depth.squared, depth.first,
/// depth.median, normal.X to normal.Z, features.0 and up, and as unsigned integers id.gaussian and id.median.
/// Throws `Unavailable` in a build without OpenEXR.
SWIFTGS_API void write_exr(const std::filesystem::path& path, const Frame& frame);

/// Writes planes in host memory, of any `PixelFormat` and any pitch. The alpha of RGBA is
/// its last channel, by which colours are multiplied; a PNG gets straight colours. The alpha of RGB is the
/// plane `alpha`. A PNG is opaque if it was drawn before a `background` that is not black, or as RGB `over`
/// an image. The occluder is not read. Throws as for a frame, and `InvalidArgument` as `validate(const
/// FrameView&)`.
SWIFTGS_API void write_png(const std::filesystem::path& path, const FrameView& view,
                           vec3 background = vec3(0));

/// The bytes of the file that `write_png` writes of a view.
SWIFTGS_API std::vector<std::byte> encode_png(const FrameView& view, vec3 background = vec3(0));

/// Writes a view as `write_png` does. Colours are as they lie in memory, premultiplied ones too.
SWIFTGS_API void write_pfm(const std::filesystem::path& path, const FrameView& view);

/// Writes all planes of a view, as `write_pfm` does; A is the alpha of its colours.
SWIFTGS_API void write_exr(const std::filesystem::path& path, const FrameView& view);

}  // namespace swiftgs
