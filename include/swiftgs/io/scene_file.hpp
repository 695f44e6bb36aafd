// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Files of scenes: reading and writing with progress, and rendering models as text, in files and
/// on the command line: `antialiased=yes,blur=0.1`.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/tools/scene_part.hpp>

namespace swiftgs {

/// A reader or writer calls it several times a second with the part that is done: from 0 to 1, never less
/// than before. Return false to cancel. It is called in the thread that called the reader or writer.
using Progress = std::function<bool(double part)>;

/// A `Progress` returned false. Nothing was read; the file to write is as it was before. The message ends
/// with `remains`, what else is left.
class SWIFTGS_API Cancelled : public detail::ErrorAs<std::runtime_error> {
 public:
  explicit Cancelled(const std::string& file, const std::string& remains = {})
      : ErrorAs(ErrorCode::cancelled, file + ": cancelled" + remains) {}
};

/// What of `model` is not as a scene has it that says nothing; empty if nothing is.
SWIFTGS_API std::string text_of(const RenderingModel& model);

/// `model` changed by such a text: settings with commas between, of `antialiased` (yes, no), `blur`
/// (@units{pixels^2}, 0 or more), `order` (depth, distance), `colours` (srgb, linear) and `kernel`
/// (ellipsoid, disk). Throws `InvalidArgument` that names the first setting that is none of these.
SWIFTGS_API RenderingModel model_from(std::string_view text, RenderingModel model = {});

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
  int level = 0;  ///< of detail, in a streamed SOG: 0 is the finest; 0 or more for any file
  Progress progress{};
  /// Reads these Gaussians alone: no other bytes of a binary PLY, compressed or not, and of a `.splat`, and
  /// none after the part of a text PLY. An SPZ is unpacked as a whole, and the part is decoded.
  ScenePart part{};
};

/// Gaussians that readers and writers leave out, counted by the first of these reasons that holds. Frames of
/// arrays that hold them are as `SceneView` says.
struct LeftOut {
  /// A number is NaN or infinite, in the file or once it is a float: as a position beyond 3.4e38 is, or the
  /// exponential of a log-scale above 88.7. A scale of 0 and an opacity of 0 or 1 are legal, whatever
  /// infinity the file writes them as.
  std::uint64_t not_finite = 0;
  /// The quaternion is all zeros, as in rows that a program reserved and never filled, or is encoded in a way
  /// that the format does not define. A quaternion of any other length is a rotation.
  std::uint64_t no_rotation = 0;

  std::uint64_t total() const { return not_finite + no_rotation; }
  LeftOut& operator+=(const LeftOut& other) {
    not_finite += other.not_finite, no_rotation += other.no_rotation;
    return *this;
  }
};

/// A scene and what reading it brought up.
struct SceneFile {
  Scene scene;
  std::string format;               ///< such as "INRIA PLY (binary_little_endian)" or "SPZ version 2"
  std::uint64_t bytes = 0;          ///< of the file, and of those that it names and were read
  std::uint64_t stored = 0;         ///< Gaussians in the file, or in the part of it that was asked for
  LeftOut left_out{};               ///< those of them that the scene lacks
  std::uint64_t signs_dropped = 0;  ///< Gaussians of scales below 0, which are taken without their sign
  /// Parts of the file that the scene lacks or has otherwise, a sentence each. If only a part of the file was
  /// read, see `left_out` and `signs_dropped` for Gaussians.
  std::vector<std::string> notes;
  /// Of the photograph that the scene was made of, where the file has it: @units{pixels}, and world units of
  /// the scene.
  std::optional<Camera> camera{};
};

/// Reads a scene of any format that docs/formats.md lists. The content decides which; `.splat` files begin
/// with nothing of their own and go by their name's ending. A text glTF names files in its folder. `path` may
/// also be the folder of a capture, in which `find_capture` finds the file.
///
/// Gaussians that are not finite or have no rotation are left out and counted, as `LeftOut` says. Other
/// numbers are taken at any size: linear scales below 0 without their sign, linear opacities clamped to 0 to
/// 1, both noted. SH coefficients above degree 3 are left out and noted. Positions that a format holds finer
/// than float get an origin where `OriginChoice` sees a need, which is noted; parts of a file get the same
/// one. The file must not change while it is read. Memory is bounded by the file's size: docs/formats.md has
/// the factor of each format.
///
/// Throws `FormatError`, `Cancelled`, `FileError` if a file cannot be read, what `find_capture`
/// throws, and `InvalidArgument` for a part of a file whose format has to be read as a whole.
SWIFTGS_API SceneFile read_scene(const std::filesystem::path& path, const SceneReadOptions& options = {});

/// `read_scene(path, options).scene`.
SWIFTGS_API Scene load_scene(const std::filesystem::path& path, const SceneReadOptions& options = {});

/// The same from memory; `name` stands for the file in error messages. A file that names other files cannot
/// be read so.
SWIFTGS_API SceneFile read_scene(std::span<const std::byte> bytes, const std::string& name,
                                 const SceneReadOptions& options = {});

/// Names of the files that `read_scene` takes, as a sentence lists them: ".ply, .compressed.ply, ... or
/// .ksplat".
SWIFTGS_API std::string readable_scenes();

/// The same of the files that `write_scene` makes.
SWIFTGS_API std::string writable_scenes();

struct SceneWriteOptions {
  std::string ending{};  ///< names the format, as `.ply` does; empty: the file's own name does
  int spz_version = 4;   ///< of an SPZ file to write; 3 is for programs of before 2026
  /// Of an SPZ file to write: `specified` is RUB, and other axes are stated in the file. `rdf` and `raw` are
  /// for programs that read positions as they are stored.
  SpzFrame spz_frame = SpzFrame::specified;
  Progress progress{};
};

/// Largest differences between the scene and the written file, by rounding and clamping, measured on the
/// file. An INRIA PLY holds floats and loses nothing.
struct LargestLosses {
  double position = 0;        ///< distance of a mean from where it was @units{world}
  std::size_t gaussian = 0;   ///< number of that Gaussian in the scene
  std::size_t displaced = 0;  ///< Gaussians that moved farther than their longest scale; of opacity 1/255 up
  double scale = 1;           ///< factor between a scale above 0 and what it became, at least 1
  double opacity = 0;
  double colour = 0;  ///< of a channel by band 0, of which 1 is full
};

/// "positions by 0.00012 units, scales by a factor of 1.03, opacities by 0.002, colours by 0.005": those that
/// are not as before; empty if all are.
SWIFTGS_API std::string text_of(const LargestLosses& losses);

/// What a file holds of a scene. A format may hold fewer bands, or less of the scene's model.
struct WrittenScene {
  std::string format;       ///< as `SceneFile::format`
  std::uint64_t bytes = 0;  ///< of the file
  std::size_t gaussians = 0;
  std::size_t added = 0;  ///< of them; of opacity 0, to fill chunks of a compressed PLY
  int sh_degree = 0;
  RenderingModel model{};
  LargestLosses losses{};
  std::vector<std::string> notes{};  ///< what was left out or changed, with counts, a sentence each
};

/// Writes a scene in the format that an ending names, in upper or lower case. docs/formats.md says what each
/// format rounds and in which order it has the Gaussians; none holds features.
///
/// All formats treat numbers that a file cannot hold alike, and `WrittenScene::notes` counts them:
/// - A Gaussian is left out for the reasons of `LeftOut`, for which `read_scene` leaves it out, too.
/// - An opacity outside 0 to 1 is clamped.
/// - A scale below 0 loses its sign, which no frame shows. A scale of 0 is legal.
/// - Any other number beyond the range of the format is clamped to it.
///
/// Of a scene with an origin a `.ply` holds positions in the world, as doubles; the other formats hold them
/// relative to the origin, which `WrittenScene::notes` names.
///
/// The new file takes the place of an old one when it is whole. Throws `InvalidArgument` as `validate`
/// does, for an ending that it does not know, and for a scene or an option that the format does not allow,
/// `Cancelled`, or `FileError` if the file cannot be written.
SWIFTGS_API WrittenScene write_scene(const std::filesystem::path& path, const Scene& scene,
                                     const SceneWriteOptions& options = {});

/// Throws `InvalidArgument` as `write_scene` does for an ending that it does not know, before hours are
/// spent on the scene.
SWIFTGS_API void require_scene_ending(const std::filesystem::path& path,
                                      const SceneWriteOptions& options = {});

}  // namespace swiftgs
