// SPDX-License-Identifier: Apache-2.0
#include "file_pages.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <system_error>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/edit/select.hpp>
#include <swiftgs/edit/transform.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/io/scene_file.hpp>

namespace swiftgs::pages {
namespace {

/// Scenes of files. The last ones stay, since several pages are of one file.
class FileCache {
 public:
  std::shared_ptr<const Scene> read(const std::string& file) {
    {
      const std::lock_guard lock(mutex_);
      const auto known =
          std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.file == file; });
      if (known != kept_.end()) {
        std::rotate(kept_.begin(), known, known + 1);
        return kept_.front().scene;
      }
    }
    SceneFile found = read_scene(file);
    // Pages name Gaussians by their numbers in the file.
    if (found.left_out.total() != 0)
      throw FormatError(file, 0, "Gaussians with finite numbers and rotations");
    auto scene = std::make_shared<const Scene>(std::move(found.scene));
    const std::lock_guard lock(mutex_);
    kept_.insert(kept_.begin(), {file, scene});
    if (kept_.size() > most) kept_.pop_back();
    return scene;
  }

 private:
  static constexpr std::size_t most = 8;
  struct Kept {
    std::string file;
    std::shared_ptr<const Scene> scene;
  };
  std::mutex mutex_;
  std::vector<Kept> kept_;  ///< the latest first
};

/// What a page reads, with what all pages have in common.
struct Reader {
  std::vector<std::vector<FilePart>> parts;
  std::vector<std::uint32_t> counts;
  dvec3 origin;
  FileCache cache;

  PageContent read(std::uint32_t page) {
    PageContent content;
    Scene& all = content.scene;
    all.origin = origin;
    for (const FilePart& part : parts[page]) {
      const std::shared_ptr<const Scene> file = cache.read(part.file);
      const bool whole = part.first == FilePart::all;
      if (!whole && part.first + part.count > file->size())
        throw FormatError(part.file, 0, std::to_string(part.first + part.count) + " Gaussians or more");
      std::vector<std::uint32_t> range(whole ? file->size() : part.count);
      std::iota(range.begin(), range.end(), std::uint32_t(whole ? 0 : part.first));
      Scene scene = subset(*file, range);
      stretch(scene, part.world_from_file, origin);
      append(all, scene);
    }
    if (all.size() == 0 || all.size() > counts[page])
      throw FormatError(parts[page][0].file, 0, "1 to " + std::to_string(counts[page]) + " Gaussians");
    return content;
  }
};

}  // namespace

void Bounds::add(const dvec3& point) {
  for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], point[k]), high[k] = std::max(high[k], point[k]);
}

double Bounds::longest_side() const {
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z, 0.0});
}

void FilePages::fail(const std::string& expected) const { throw FormatError(path_.string(), 0, expected); }

nlohmann::json FilePages::parse(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw FileError({errno != 0 ? errno : EIO, std::generic_category()}, path.string());
  try {
    return nlohmann::json::parse(file);
  } catch (const nlohmann::json::exception&) {
    throw FormatError(path.string(), 0, "valid JSON");
  }
}

std::filesystem::path FilePages::beside(const std::filesystem::path& path, const std::string& name) const {
  const std::filesystem::path normal = std::filesystem::path(name).lexically_normal();
  if (normal.empty() || normal.is_absolute() || *normal.begin() == ".." || name.find("://") != name.npos)
    fail("names of files in the same folder or below it, found '" + name + "'");
  return path.parent_path() / normal;
}

std::uint32_t FilePages::add(std::vector<FilePart> parts, const Bounds& bounds, double error, int sh_degree,
                             std::vector<std::uint32_t> children) {
  Page page;
  std::uint64_t count = 0;
  for (const FilePart& part : parts) count += part.count;
  if (count == 0 || count > std::numeric_limits<std::uint32_t>::max())
    fail("1 to 2^32 - 1 Gaussians in a page");
  if (!(bounds.longest_side() < 1e15) || !(error >= 0 && error < 1e30))
    fail("finite bounds and errors of 0 or more");
  page.count = std::uint32_t(count), page.sh_degree = std::uint8_t(sh_degree);
  page.bytes = count * (14 * sizeof(float) + padded_row(HarmonicFormat::floats, sh_degree));
  if (!children.empty()) page.left = children.front(), page.errors.fill(float(error));
  if (children.empty()) page.first = state_.gaussians, state_.gaussians += count;
  state_.first_child.push_back(std::uint32_t(state_.children.size()));
  state_.children.insert(state_.children.end(), children.begin(), children.end());
  state_.pages.push_back(page);
  state_.page_size = std::max(state_.page_size, page.count);
  state_.sh_degree = std::max(state_.sh_degree, sh_degree);
  Bounds all = bounds;
  for (const std::uint32_t child : children) all.add(bounds_[child]);
  parts_.push_back(std::move(parts)), bounds_.push_back(all);
  return std::uint32_t(size() - 1);
}

PagedScene FilePages::finish(const char* format) && {
  if (size() == 0) fail("Gaussians");
  if (state_.gaussians > std::numeric_limits<std::uint32_t>::max()) fail("fewer than 2^32 Gaussians");
  state_.first_child.push_back(std::uint32_t(state_.children.size()));
  const Bounds& all = bounds_.back();
  const dvec3 middle = 0.5 * (all.low + all.high);
  // Floats of positions on the earth are off by half a metre.
  if (std::sqrt(detail::dot(middle, middle)) > 1e4) state_.origin = middle;
  const auto reader = std::make_shared<Reader>();
  reader->origin = state_.origin;
  for (std::size_t i = 0; i < size(); ++i) {
    Page& page = state_.pages[i];
    for (int k = 0; k < 3; ++k) {
      page.bounds.low[k] = float(bounds_[i].low[k] - state_.origin[k]);
      page.bounds.high[k] = float(bounds_[i].high[k] - state_.origin[k]);
    }
    // A box around ellipsoids is at least as long as their longest axis, over the root of 3.
    page.bounds.size = float(0.5 * std::sqrt(3.0) * bounds_[i].longest_side());
    page.bounds.opacity = 1;
    reader->counts.push_back(page.count);
  }
  reader->parts = std::move(parts_);
  state_.name = path_.string(), state_.format = format;
  state_.model = reader->cache.read(reader->parts.back()[0].file)->model;
  state_.read = [reader](std::uint32_t page) { return reader->read(page); };
  return PagedScene(std::move(state_));
}

}  // namespace swiftgs::pages
