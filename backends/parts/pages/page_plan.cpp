// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/view_constants.hpp>
#include <swiftgs/pages/page_plan.hpp>
#include <swiftgs/project/chunks.hpp>

namespace swiftgs::detail {

/// A page that may be replaced by its children.
struct PagePlan::Candidate {
  double error;  ///< @units{pixels}
  std::size_t scene;
  std::uint32_t page;

  /// The largest error comes first; ties are for the first page, so that frames do not depend on chance.
  bool operator<(const Candidate& other) const {
    return error != other.error ? error < other.error
                                : std::pair(scene, page) > std::pair(other.scene, other.page);
  }
};

/// The cameras of a frame as a placed scene sees them.
class PagePlan::Eyes {
 public:
  Eyes(const PlacedPages& placed, Span<const View> views) {
    PlacedScene like{{}, placed.world_from_scene, placed.opacity, placed.clip, placed.tint};
    like.scene.model = placed.pages.model();
    eyes_.reserve(views.size);
    for (const View& view : views) eyes_.push_back(eye(view.camera, like));
    for (const ViewConstants& each : eyes_) cullers_.emplace_back(each);
  }

  /// Whether some view may show the page. Its error is then the largest in any. @units{pixels}
  bool shows(const Page& page, double& error) const {
    error = 0;
    bool shown = false;
    for (std::size_t i = 0; i < eyes_.size(); ++i) {
      if (cullers_[i].culls(page.bounds)) continue;
      shown = true;
      if (page.is_leaf()) break;
      const double pixel = pixel_at(eyes_[i], page.bounds);
      error = std::max(error, page.error_at(pixel) / pixel);
    }
    return shown;
  }

 private:
  /// Size of a pixel at the nearest point of a box. @units{scene}
  static double pixel_at(const ViewConstants& v, const ChunkBounds& box) {
    const double focal = std::max(v.fx, v.fy);
    if (traits_of(v.lens.model).parallel_rays) return 1 / focal;
    double squares = 0;
    for (int k = 0; k < 3; ++k) {
      const double outside =
          std::max({double(box.low[k]) - v.centre[k], v.centre[k] - double(box.high[k]), 0.0});
      squares += outside * outside;
    }
    const double nearest = std::max(double(v.near_plane), 1e-6) / v.depth_scale;
    return std::max(std::sqrt(squares), nearest) / focal;
  }

  std::vector<ViewConstants> eyes_;
  std::vector<ChunkCuller> cullers_;
};

PagePlan::PagePlan(std::vector<PlacedPages> placed, std::size_t most_bytes, bool keeps_ahead)
    : most_bytes_(most_bytes) {
  if (placed.empty()) throw InvalidArgument("page pool: no pages, expected one paged scene or more");
  for (const PlacedPages& each : placed)
    if (std::find(files_.begin(), files_.end(), each.pages) == files_.end()) files_.push_back(each.pages);
  for (const PagedScene& file : files_) {
    std::vector<PageState>& states = states_.emplace_back(file.pages().size);
    for (std::uint32_t i = 0; i < states.size(); ++i)
      for (const std::uint32_t child : file.children(i)) states[child].parent = i;
    root_bytes_ += resident_bytes(file.pages()[file.root()]);
  }
  if (root_bytes_ > most_bytes_)
    refuse("page pool: ", most_bytes_, " bytes besides pages that threads upload, expected ", root_bytes_,
           " or more for the roots of all scenes");
  if (keeps_ahead) ahead_bytes_ = (most_bytes_ - root_bytes_) / 8;
  place(std::move(placed));
}

void PagePlan::place(std::vector<PlacedPages> placed) {
  std::vector<std::uint32_t> file_of;
  for (const PlacedPages& each : placed) {
    validate_placing(each.world_from_scene, each.opacity, each.clip, each.tint);
    const auto known = std::find(files_.begin(), files_.end(), each.pages);
    if (known == files_.end())
      refuse("page pool: ", each.pages.name(), " is placed, expected scenes that the pool was made for");
    file_of.push_back(std::uint32_t(known - files_.begin()));
  }
  placed_ = std::move(placed), file_of_ = std::move(file_of);
  seen_.clear();
  for (const PlacedPages& each : placed_) seen_.emplace_back(each.pages.pages().size);
}

PagePlan::Wanted PagePlan::choose(Span<const View> views, const CutGoal& goal, Span<const View> ahead) {
  if (!(goal.pixels >= 0)) refuse("cut: an error of ", goal.pixels, " pixels, expected 0 or more");
  if (!(goal.blend >= 0)) refuse("cut: a blend of ", goal.blend, ", expected 0 or more");
  for (const Span<const View> each : {views, ahead})
    for (const View& view : each)
      if (view.shows.first != 0 || view.shows.count != ShownScenes().count)
        throw InvalidArgument("cut: a view of some scenes, expected views that show all");
  ++frame_;
  for (std::uint32_t file = 0; file < files_.size(); ++file) use({file, files_[file].root()});
  // Without memory of their own, pages that come into view would be late in every frame.
  std::size_t bytes = root_bytes_ + ahead_bytes_;
  Wanted wanted = grow(views, goal, true, bytes);
  bytes -= ahead_bytes_;
  wanted.now = wanted.missing.size();
  CutGoal finer = goal;
  finer.pixels *= 0.95;  // cameras do not go on quite so
  const std::size_t together = std::max<std::size_t>(views.size, 1);
  for (std::size_t first = 0; first < ahead.size; first += together) {
    const Span<const View> next{ahead.data + first, std::min(together, ahead.size - first)};
    const Wanted later = grow(next, finer, false, bytes);
    wanted.missing.insert(wanted.missing.end(), later.missing.begin(), later.missing.end());
  }
  return wanted;
}

PagePlan::Wanted PagePlan::grow(Span<const View> views, const CutGoal& goal, bool draws, std::size_t& bytes) {
  Wanted wanted;
  std::vector<Eyes> eyes;
  std::priority_queue<Candidate> candidates;
  for (std::size_t scene = 0; scene < placed_.size(); ++scene) {
    const PageKey root{file_of_[scene], files_[file_of_[scene]].root()};
    eyes.emplace_back(placed_[scene], views);
    double error = 0;
    if (!eyes.back().shows(row(root), error)) continue;
    if (draws) seen_[scene][root.page].shown = frame_;
    wanted.splats += row(root).count;
    candidates.push({error, scene, root.page});
  }

  std::vector<Candidate> shown;  // children of the next
  while (!candidates.empty()) {
    const Candidate next = candidates.top();
    candidates.pop();
    const std::uint32_t file = file_of_[next.scene];
    const Page& page = row({file, next.page});
    if (page.is_leaf()) continue;
    // As are all others. But for goal 0: nodes of Gaussians in one place err by 0.
    if (goal.pixels > 0 && next.error <= goal.pixels) {
      wanted.error = std::max(wanted.error, std::optional(next.error));
      break;
    }
    // How much of a fading page still shows, 0 to 1.
    const double left = goal.blend > 0 && goal.pixels > 0
                            ? std::max(0.0, 1 - (next.error / goal.pixels - 1) / goal.blend)
                            : 0;
    std::uint64_t splats = wanted.splats - (left > 0 ? 0 : page.count);
    std::size_t more = 0;
    shown.clear();
    for (const std::uint32_t number : files_[file].children(next.page)) {
      const PageKey child{file, number};
      Candidate candidate{0, next.scene, number};
      if (!eyes[next.scene].shows(row(child), candidate.error)) continue;
      shown.push_back(candidate);
      splats += row(child).count;
      if (!is_wanted(child)) more += resident_bytes(row(child));
    }
    if (splats > goal.splats || bytes + more > most_bytes_) {
      wanted.pixels = next.error;
      wanted.error = std::max(wanted.error, std::optional(next.error));
      break;
    }
    if (draws) seen_[next.scene][next.page].refined = frame_, seen_[next.scene][next.page].left = float(left);
    if (left > 0) wanted.error = std::max(wanted.error, std::optional(next.error));
    wanted.splats = splats, bytes += more;
    for (const Candidate& each : shown) {
      const PageKey child{file, each.page};
      if (draws) seen_[next.scene][child.page].shown = frame_;
      if (!is_wanted(child) && !is_resident(child)) wanted.missing.push_back(child);
      use(child);
      candidates.push(each);
    }
  }
  wanted.pixels = std::max(wanted.pixels, goal.pixels);
  return wanted;
}

void PagePlan::draw(const Drawn& page, std::vector<Drawn>& to) const {
  const std::vector<Seen>& seen = seen_[page.scene];
  const Seen& own = seen[page.page];
  const std::uint32_t file = file_of_[page.scene];
  const Span<const std::uint32_t> children = files_[file].children(page.page);
  const auto shows = [&](std::uint32_t child) { return seen[child].shown == frame_; };
  const auto is_ready = [&](std::uint32_t child) { return !shows(child) || is_resident({file, child}); };
  if (own.refined != frame_ || !std::all_of(children.begin(), children.end(), is_ready))
    return to.push_back(page);
  // Show one of the two levels fully: through two half transparent ones the background would show.
  const float children_show = std::min(1.0f, 2 * (1 - own.left));
  if (own.left > 0) to.push_back({page.scene, page.page, page.opacity * std::min(1.0f, 2 * own.left)});
  if (children_show == 0) return;
  for (const std::uint32_t child : children)
    if (shows(child)) draw({page.scene, child, page.opacity * children_show}, to);
}

std::vector<PagePlan::Drawn> PagePlan::drawn() const {
  std::vector<Drawn> all;
  for (std::size_t scene = 0; scene < placed_.size(); ++scene) {
    const std::uint32_t root = placed_[scene].pages.root();
    if (seen_[scene][root].shown == frame_) draw({scene, root, 1}, all);
  }
  return all;
}

void PagePlan::use(PageKey key) {
  PageState& page = state(key);
  if (page.used != frame_ && page.resident && page.parent != Page::none)
    by_use_.splice(by_use_.end(), by_use_, page.place);
  page.used = frame_;
}

void PagePlan::set_resident(PageKey key, bool resident) {
  PageState& page = state(key);
  const bool is_root = page.parent == Page::none;
  if (resident && !is_root) page.place = by_use_.insert(by_use_.end(), key);  // may throw
  page.resident = resident;
  if (is_root) return;
  state(parent_of(key)).children += resident ? 1 : -1;
  if (!resident) by_use_.erase(page.place);
}

bool PagePlan::find_victim(PageKey& victim, const std::function<bool(PageKey)>& is_held) const {
  for (const PageKey& key : by_use_) {
    if (is_wanted(key)) return false;  // and so are all behind it
    if (state(key).children != 0 || is_held(key)) continue;
    victim = key;
    return true;
  }
  return false;
}

}  // namespace swiftgs::detail
