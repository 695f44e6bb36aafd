// SPDX-License-Identifier: Apache-2.0
#include "file_pages.hpp"

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>

#include <swiftgs/edit/origin.hpp>
#include <swiftgs/edit/select.hpp>
#include <swiftgs/edit/transform.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/harmonics.hpp>
#include <swiftgs/io/scene_file.hpp>

#include "json_entry.hpp"
#include "mapped_file.hpp"
#include "page_file.hpp"

namespace swiftgs::pages {
namespace {

/// Most files or ranges that all pages together read: a small file may name another many times.
constexpr std::size_t most_parts = 1 << 22;
constexpr std::uint64_t most_gaussians = std::numeric_limits<std::uint32_t>::max();

std::size_t bytes_of(const Scene& scene) {
  std::size_t bytes = 0;
  for_each_array(
      [&](const char*, std::size_t, const auto& values) { bytes += values.size() * sizeof values[0]; },
      scene);
  return bytes;
}

using SharedScene = std::shared_ptr<const Scene>;

/// Scenes of files. The last ones stay, since several pages are of one file.
class FileCache {
 public:
  /// Threads that need a file while another decodes it wait for that one.
  SharedScene read(const std::string& file) {
    std::unique_lock lock(mutex_);
    const auto known =
        std::find_if(kept_.begin(), kept_.end(), [&](const Kept& k) { return k.file == file; });
    if (known != kept_.end()) {
      std::rotate(kept_.begin(), known, known + 1);
      return kept_.front().scene;
    }
    if (const auto decoding = decoding_.find(file); decoding != decoding_.end()) {
      const std::shared_future<SharedScene> scene = decoding->second;
      lock.unlock();
      return scene.get();
    }
    std::packaged_task<SharedScene()> decode([&] { return decoded(file); });
    const std::shared_future<SharedScene> scene = decode.get_future().share();
    decoding_.emplace(file, scene);
    lock.unlock();
    decode();
    lock.lock();
    decoding_.erase(file);
    keep(file, scene.get());  // throws what `decoded` threw
    return scene.get();
  }

 private:
  static SharedScene decoded(const std::string& file) {
    SceneFile found = read_scene(file);
    // Pages name Gaussians by their numbers in the file.
    if (found.left_out.total() != 0)
      throw FormatError(file, 0, "Gaussians with finite numbers and rotations");
    return std::make_shared<const Scene>(std::move(found.scene));
  }

  void keep(const std::string& file, const SharedScene& scene) {
    kept_.insert(kept_.begin(), {file, scene});
    for (bytes_ += bytes_of(*scene); bytes_ > most_bytes && kept_.size() > 1; kept_.pop_back())
      bytes_ -= bytes_of(*kept_.back().scene);
  }

  static constexpr std::size_t most_bytes = 256 << 20;  ///< but for one scene that is larger
  struct Kept {
    std::string file;
    SharedScene scene;
  };
  std::mutex mutex_;
  std::vector<Kept> kept_;  ///< the latest first
  std::size_t bytes_ = 0;   ///< of these
  std::map<std::string, std::shared_future<SharedScene>> decoding_;
};

/// What a page reads, with what all pages have in common.
struct Reader {
  std::vector<std::vector<FilePart>> parts;
  std::vector<std::uint32_t> counts;
  dvec3 origin;
  RenderingModel model;
  FileCache cache;

  PageContent read(std::uint32_t page) {
    PageContent content;
    Scene& all = content.scene;
    all.origin = origin;
    for (const FilePart& part : parts[page]) {
      const SharedScene file = cache.read(part.file);
      if (file->model != model) throw FormatError(part.file, 0, "the rendering model of the first file");
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
  constexpr double endless = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const bool is_number = !std::isnan(point[k]);
    low[k] = std::min(low[k], is_number ? point[k] : -endless);
    high[k] = std::max(high[k], is_number ? point[k] : endless);
  }
}

double Bounds::longest_side() const {
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z, 0.0});
}

void FilePages::fail(const std::string& expected) const { throw FormatError(path_.string(), 0, expected); }

nlohmann::json json_of(const std::filesystem::path& path) {
  const io::MappedFile file(path);
  return io::parse_json({file.bytes(), path.string()});
}

std::uint32_t FilePages::add(std::vector<FilePart> parts, const Bounds& bounds, double error, int sh_degree,
                             std::vector<std::uint32_t> children) {
  Page page;
  std::uint64_t count = 0;
  for (const FilePart& part : parts) {
    if (part.count > most_gaussians - count) fail("fewer than 2^32 Gaussians in a page");
    count += part.count;
  }
  if (count == 0) fail("pages with Gaussians");
  if (children.empty() && count > most_gaussians - state_.gaussians) fail("fewer than 2^32 Gaussians");
  parts_in_all_ += parts.size();
  if (parts_in_all_ > most_parts) fail("pages of at most " + std::to_string(most_parts) + " files or ranges");
  int below = 0;
  for (const std::uint32_t child : children) below = std::max(below, levels_[child]);
  if (below > most_levels) fail("at most " + std::to_string(most_levels) + " levels of pages in each other");
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
  parts_.push_back(std::move(parts)), bounds_.push_back(all), levels_.push_back(1 + below);
  return std::uint32_t(size() - 1);
}

PagedScene FilePages::finish(const char* format) && {
  if (size() == 0) fail("Gaussians");
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
  state_.model = reader->model = reader->cache.read(reader->parts.back()[0].file)->model;
  state_.read = [reader](std::uint32_t page) { return reader->read(page); };
  return PagedScene(std::move(state_));
}

}  // namespace swiftgs::pages
