// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/io/scene_file.hpp>

namespace swiftgs {

struct PageBuildOptions {
  std::uint32_t page_size = 16'384;  ///< Gaussians or nodes of a page: a multiple of `chunk_size`
  /// Puts neighbours in space into one page, as an external sort does. Otherwise pages are ranges of the
  /// source, and a frame of all leaves has the bits of the source.
  bool order = false;
  /// Most memory that the builder takes: 12,520 bytes or more for each Gaussian of a page. A scene that
  /// cannot be read in parts, any but a PLY and a `.splat`, takes what its format takes besides, and `order`
  /// four bytes a Gaussian. @units{bytes}
  std::size_t memory = std::size_t(1) << 30;
  std::string model{};      ///< what `model_from` takes, in place of what the sources say
  int threads = 0;          ///< 0: one a processor
  SceneReadOptions read{};  ///< of each source, its `part` and `progress` excepted
  Progress progress{};
};

/// What `build_pages` wrote.
struct BuiltPages {
  std::uint64_t gaussians = 0;
  std::size_t pages = 0, leaves = 0;
  std::size_t resumed = 0;  ///< pages among them that an unfinished build had written
  std::uint64_t bytes = 0;  ///< of the file
  std::vector<std::string> notes{};
};

/// Writes all Gaussians of `sources`, source by source, to the page file `out`, with the origin of the first
/// source. A source is a file that `read_scene` reads, or a page file. Needs 240 bytes of disk a Gaussian
/// beside `out`, twice that with `order`, in unnamed files. The finished file replaces an existing one.
///
/// A build that ends early, by a signal, a full disk or `progress`, leaves `out`.unfinished and
/// `out`.unfinished.steps if it has written a page. The same call then reads the sources again and resumes
/// behind the last complete page; the result has the bytes of an undisturbed build. With other Gaussians or
/// options, or by another version of the library, it starts again and notes that. To give up, delete both.
///
/// Throws `InvalidArgument` for an invalid option, for sources without Gaussians, with features or of several
/// rendering models, while another build writes `out`, and if other files have the names of the two
/// unfinished ones. Throws `CapacityError` beyond 2^32 - 1 Gaussians, `Cancelled`, `FileError` if a write
/// fails, and what `read_scene` throws.
SWIFTGS_API BuiltPages build_pages(const std::vector<std::filesystem::path>& sources,
                                   const std::filesystem::path& out, const PageBuildOptions& options = {});

/// The same of a scene in memory.
SWIFTGS_API BuiltPages build_pages(const Scene& scene, const std::filesystem::path& out,
                                   const PageBuildOptions& options = {});

}  // namespace swiftgs
