// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "json_entry.hpp"
#include "scene_building.hpp"
#include "scene_format.hpp"
#include "sog_content.hpp"

namespace swiftgs::io {
namespace {

using nlohmann::json;

/// A SOG of its own, and what of it is read.
struct Chunk {
  std::string name;
  std::vector<SogRange> ranges{};
  bool whole = false;  ///< instead of the ranges
};

/// `lod-meta.json`: a tree. For each level of detail a leaf names a chunk and a range of its Gaussians.
/// Levels are alternatives; a leaf without a level shows nothing at that level.
class LodMeta {
 public:
  explicit LodMeta(const Source& source)
      : source_(source),
        value_(parse_json(source)),
        root_(source_, value_, 0, "lod-meta.json of a streamed SOG") {}

  /// Throws `FormatError` that says how many levels there are unless `level` is one of them.
  int levels(int level) const {
    const double levels = root_.number("lodLevels");
    if (!(levels >= 1 && levels <= 1000)) fail("lodLevels", "1 to 1000 levels of detail");
    if (level < 0 || level >= levels)
      fail("lodLevels", "level " + std::to_string(level) + " of detail, found " +
                            std::to_string(int(levels)) + " levels, 0 to " + std::to_string(int(levels) - 1));
    return int(levels);
  }

  /// The chunks that `level` needs, in the order of the file.
  std::vector<Chunk> chunks(int level) const {
    const json& names = root_.member("filenames");
    if (!names.is_array()) fail("filenames", "an array of files");
    std::map<std::size_t, Chunk> used;
    const std::string key = std::to_string(level);
    std::vector<const json*> nodes{&root_.member("tree")};
    while (!nodes.empty()) {
      const json& node = *nodes.back();
      nodes.pop_back();
      if (!node.is_object()) fail("tree", "nodes that are objects");
      if (const auto lods = node.find("lods"); lods != node.end() && lods->is_object())
        if (const auto lod = lods->find(key); lod != lods->end()) {
          const std::size_t file = whole(*lod, "file");
          if (file >= names.size()) fail("tree", "a 'file' below " + std::to_string(names.size()));
          Chunk& chunk = used.try_emplace(file, Chunk{file_name(names[file], "filenames")}).first->second;
          chunk.ranges.push_back({whole(*lod, "offset"), whole(*lod, "count"), 0});
        }
      if (const auto children = node.find("children"); children != node.end() && children->is_array())
        for (const json& child : *children) nodes.push_back(&child);
    }
    std::vector<Chunk> chunks;
    for (auto& [file, chunk] : used) chunks.push_back(std::move(chunk));
    expect_different(chunks);
    return chunks;
  }

  bool has_environment() const { return root_.has("environment"); }
  Chunk environment() const {
    return {.name = file_name(root_.member("environment"), "environment"), .whole = true};
  }

  [[noreturn]] void fail(const char* member, const std::string& expected) const {
    const std::string_view text = source_.text();
    source_.fail(offset_of_member(text, text.find('{'), member), expected);
  }

 private:
  std::size_t whole(const json& lod, const char* key) const {
    const auto found = lod.find(key);
    if (found == lod.end() || !found->is_number_unsigned())
      fail("tree", std::string("levels with a whole number '") + key + "'");
    return found->get<std::size_t>();
  }

  std::string file_name(const json& name, const char* member) const {
    if (!name.is_string() || !stays_inside(name.get<std::string>()))
      fail(member, "names of files in the same folder or below it");
    return name.get<std::string>();
  }

  /// A chunk that is named again and again would take more memory than the files warrant.
  void expect_different(const std::vector<Chunk>& chunks) const {
    std::set<std::filesystem::path> names;
    for (const Chunk& chunk : chunks)
      if (!names.insert(std::filesystem::path(chunk.name).lexically_normal()).second)
        fail("filenames", "different files, found '" + chunk.name + "' again");
  }

  const Source& source_;
  json value_;
  JsonEntry root_;
};

/// Sorts and joins the ranges, and says where each goes, from `to` on. Returns where they end.
std::size_t place_ranges(const LodMeta& meta, Chunk& chunk, std::size_t count, std::size_t to) {
  if (chunk.whole) chunk.ranges = {{0, count, 0}};
  std::sort(chunk.ranges.begin(), chunk.ranges.end(),
            [](const SogRange& a, const SogRange& b) { return a.first < b.first; });
  std::vector<SogRange> joined;
  for (const SogRange& range : chunk.ranges) {
    const std::size_t end = joined.empty() ? 0 : joined.back().first + joined.back().count;
    if (range.first < end || range.first > count || range.count > count - range.first)
      meta.fail("tree", "ranges of '" + chunk.name + "' that lie in its " + std::to_string(count) +
                            " Gaussians and do not overlap, found " + std::to_string(range.count) + " from " +
                            std::to_string(range.first) + " on");
    if (!joined.empty() && range.first == end)
      joined.back().count += range.count;
    else
      joined.push_back({range.first, range.count, to});
    to += range.count;
  }
  chunk.ranges = std::move(joined);
  return to;
}

/// The scene's size, from the descriptions of all chunks: their images are not decoded.
struct Extent {
  std::size_t count = 0;
  std::size_t unused = 0;  ///< Gaussians of the chunks that are in no range
  std::uint64_t bytes = 0;
  int sh_degree = 0;
  OriginChoice origin{};
};

Extent measure(const LodMeta& meta, const SogFiles& open, std::vector<Chunk>& chunks,
               const ProgressMeter& progress) {
  Extent extent;
  CountedFiles counted;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    progress.report(double(i) / double(chunks.size()));
    const SogFile file = open(chunks[i].name);
    const SogContent sog = open_sog(file, files_beside(chunks[i].name, open), counted);
    const std::size_t end = place_ranges(meta, chunks[i], sog.meta.count, extent.count);
    extent.unused += sog.meta.count - (end - extent.count);
    extent.count = end;
    extent.bytes += sog.stored;
    extent.sh_degree = std::max(extent.sh_degree, sog.sh_degree);
    add_box(sog, extent.origin);
  }
  return extent;
}

void decode_chunk(const SogFiles& open, const Chunk& chunk, const ProgressMeter& progress, Scene& scene,
                  SogFindings& findings) {
  const SogFile file = open(chunk.name);
  CountedFiles counted;
  SogContent sog = open_sog(file, files_beside(chunk.name, open), counted);
  const bool changed = sog.sh_degree > scene.sh_degree ||
                       chunk.ranges.back().first + chunk.ranges.back().count > sog.meta.count;
  if (changed) file.source.fail(0, "a file that does not change while it is read");
  const SogPixels pixels = decode_images(sog, progress.step(0, 0.5));
  const Progress none;
  const ProgressMeter silent(none, file.source.name);
  for (const SogRange& range : chunk.ranges)
    findings.add(sog.meta, decode_gaussians(sog, pixels, range, silent, scene));
  progress.report(1);
}

bool is_lod_meta(std::string_view text, std::string_view name) {
  return has_sog_keys(text, name, "\"lodLevels\"", "\"filenames\"");
}

SceneFile read_lod_meta(const Source& source, const SceneReadOptions& options) {
  return read_streamed_sog(source, files_beside(source), options);
}

}  // namespace

SceneFile read_streamed_sog(const Source& source, const SogFiles& open, const SceneReadOptions& options) {
  const ProgressMeter progress(options.progress, source.name);
  const LodMeta meta(source);
  const int levels = meta.levels(options.level);
  std::vector<Chunk> chunks = meta.chunks(options.level);
  if (meta.has_environment()) chunks.push_back(meta.environment());

  SceneFile file;
  const Extent extent = measure(meta, open, chunks, progress.step(0, 0.1));
  allocate(file.scene, extent.count, extent.sh_degree);
  file.scene.origin = extent.origin.origin();
  file.format = "streamed SOG, level " + std::to_string(options.level) + " of " + std::to_string(levels);
  file.bytes = extent.bytes;
  file.stored = extent.count;
  SogFindings findings;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    const auto part = [&](std::size_t chunk) { return 0.1 + 0.9 * double(chunk) / double(chunks.size()); };
    decode_chunk(open, chunks[i], progress.step(part(i), part(i + 1)), file.scene, findings);
  }
  if (levels > 1)
    file.notes.push_back("Of " + std::to_string(levels) +
                         " levels of detail, alternatives of each other, level " +
                         std::to_string(options.level) + " was read.");
  if (extent.unused > 0)
    file.notes.push_back(std::to_string(extent.unused) +
                         " Gaussians of the level's chunks are in no leaf of the tree, and were left out.");
  if (meta.has_environment())
    file.notes.push_back("The " + std::to_string(chunks.back().ranges.front().count) +
                         " Gaussians of the environment, which all levels share, were read too.");
  findings.finish(file);
  return file;
}

constinit const SceneFormat streamed_sog_format{.name = "a streamed SOG",
                                                .names = {"lod-meta.json"},
                                                .looks_so = is_lod_meta,
                                                .read = read_lod_meta,
                                                .place_in_capture = 4};

}  // namespace swiftgs::io
