// SPDX-License-Identifier: Apache-2.0

// Streamed SOG: a tree whose leaves have levels of detail, alternatives of each other, in ranges of chunks.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/scene.hpp>

#include "file_pages.hpp"
#include "formats/sog/sog_files.hpp"

namespace swiftgs::pages {
namespace {

using nlohmann::json;

class StreamedSog {
 public:
  explicit StreamedSog(const std::filesystem::path& path) : path_(path), pages_(path), value_(json_of(path)) {
    if (!value_.is_object() || !value_.contains("filenames") || !value_.contains("tree"))
      pages_.fail("lod-meta.json of a streamed SOG, with filenames and a tree");
  }

  PagedScene open() && {
    std::vector<std::uint32_t> coarsest;
    std::vector<const json*> nodes{&value_["tree"]};
    while (!nodes.empty()) {
      const json& node = *nodes.back();
      nodes.pop_back();
      if (!node.is_object()) pages_.fail("nodes that are objects");
      if (const auto children = node.find("children"); children != node.end() && children->is_array())
        for (auto child = children->rbegin(); child != children->rend(); ++child) nodes.push_back(&*child);
      if (const auto lods = node.find("lods"); lods != node.end() && lods->is_object() && !lods->empty())
        add_leaf(node, *lods, coarsest);
    }
    if (coarsest.empty()) pages_.fail("leaves with levels of detail");
    add_environment(coarsest);
    if (coarsest.size() == 1 && coarsest[0] + 1 == pages_.size())
      return std::move(pages_).finish("streamed SOG");
    // The root draws every leaf's coarsest level until the leaves' own pages are in memory.
    std::vector<FilePart> parts;
    for (const std::uint32_t page : coarsest)
      parts.insert(parts.end(), pages_.parts(page).begin(), pages_.parts(page).end());
    const Bounds bounds = pages_.bounds(coarsest[0]);
    pages_.add(std::move(parts), bounds, error_, max_sh_degree, std::move(coarsest));
    return std::move(pages_).finish("streamed SOG");
  }

 private:
  std::size_t whole(const json& lod, const char* key) const {
    const auto found = lod.find(key);
    if (found == lod.end() || !found->is_number_unsigned() || found->get<std::uint64_t>() >> 32 != 0)
      pages_.fail(std::string("levels with a whole number '") + key + "'");
    return found->get<std::size_t>();
  }

  dvec3 corner(const json& node, const char* which) const {
    const auto bound = node.find("bound");
    if (bound == node.end() || !bound->is_object() || !bound->contains(which) ||
        !(*bound)[which].is_array() || (*bound)[which].size() != 3)
      pages_.fail("leaves with a bound of min and max");
    dvec3 corner;
    for (int k = 0; k < 3; ++k) {
      const json& number = (*bound)[which][std::size_t(k)];
      if (!number.is_number()) pages_.fail("numbers in a bound");
      corner[k] = number.get<double>();
    }
    return corner;
  }

  std::filesystem::path beside(const std::string& name) const {
    if (!io::stays_inside(name))
      pages_.fail("names of files in the same folder or below it, found '" + name + "'");
    return path_.parent_path() / name;
  }

  FilePart part_of(const json& lod) const {
    const json& names = value_["filenames"];
    const std::size_t file = whole(lod, "file");
    if (!names.is_array() || file >= names.size() || !names[file].is_string())
      pages_.fail("levels with a 'file' of filenames");
    return {beside(names[file].get<std::string>()).string(), whole(lod, "offset"), whole(lod, "count"), {}};
  }

  /// Adds a page for each level of a leaf, from the finest on, and the coarsest to `coarsest`.
  void add_leaf(const json& node, const json& lods, std::vector<std::uint32_t>& coarsest) {
    Bounds bounds;
    bounds.add(corner(node, "min")), bounds.add(corner(node, "max"));
    std::map<int, FilePart> levels;
    for (const auto& [key, lod] : lods.items()) {
      if (key.empty() || key.size() > 4 || key.find_first_not_of("0123456789") != key.npos ||
          !lod.is_object())
        pages_.fail("levels with numbers for names");
      if (FilePart part = part_of(lod); part.count != 0) levels[std::stoi(key)] = std::move(part);
    }
    std::vector<std::uint32_t> finer;
    for (auto& [level, part] : levels) {
      // The file tells no error: Gaussians that cover surfaces are about so far apart.
      const double error = finer.empty() ? 0 : bounds.longest_side() / std::sqrt(double(part.count));
      if (!finer.empty()) error_ = std::max(error_, error);
      finer = {pages_.add({std::move(part)}, bounds, error, max_sh_degree, std::move(finer))};
    }
    coarsest.insert(coarsest.end(), finer.begin(), finer.end());
  }

  /// Adds the environment, which every level shows, as a leaf of the root.
  void add_environment(std::vector<std::uint32_t>& coarsest) {
    const auto found = value_.find("environment");
    if (found == value_.end() || found->is_null()) return;
    if (!found->is_string()) pages_.fail("the name of a file as environment");
    const std::filesystem::path file = beside(found->get<std::string>());
    const json meta = json_of(file);
    if (!meta.is_object() || !meta.contains("count"))
      pages_.fail("an environment that says how many Gaussians it has");
    const std::size_t count = whole(meta, "count");
    Bounds bounds;
    bounds.add(dvec3(-1e6)), bounds.add(dvec3(1e6));
    if (count != 0)
      coarsest.push_back(pages_.add({{file.string(), 0, count, {}}}, bounds, 0, max_sh_degree, {}));
  }

  std::filesystem::path path_;
  FilePages pages_;
  json value_;
  double error_ = 0;  ///< largest of a coarsest level
};

}  // namespace

PagedScene open_streamed_sog(const std::filesystem::path& path) {
  return with_kinds(path, [&] { return StreamedSog(path).open(); });
}

}  // namespace swiftgs::pages
