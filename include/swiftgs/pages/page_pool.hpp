// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Pages in the memory of a backend: paged scenes drawn within a budget.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/pages/cut.hpp>
#include <swiftgs/pages/cut_meter.hpp>
#include <swiftgs/pages/motion.hpp>
#include <swiftgs/pages/page_loader.hpp>
#include <swiftgs/pages/page_plan.hpp>
#include <swiftgs/pages/paged_scene.hpp>

namespace swiftgs {

struct PagePoolOptions {
  std::size_t bytes = 2'000'000'000;        ///< of all pages in the backend's memory @units{bytes}
  std::size_t upload_per_frame = 16 << 20;  ///< a frame uploads one page at least @units{bytes}
  std::size_t waiting = 64 << 20;           ///< of pages that were read and not uploaded @units{bytes}
  /// Frames for which the pool expects cameras to go on as they do, and brings pages. Reserves an eighth of
  /// the memory that roots leave; 0: reserves none.
  int ahead = 10;
  /// Memory of the host in which a thread of the pool measures `Cut::estimated_db`, by one processor and by
  /// pages that it reads for itself; 0: none does. More memory measures sooner. @units{bytes}
  std::size_t estimate = 0;
  int threads = 1;          ///< of the pool, which read pages; 1 or more
  PageExecutor executor{};  ///< reads pages in their place
};

/// Pages of placed scenes in the memory of backend `B`, which outlives the pool; `B` may be `AnyRenderer`,
/// which draws a cut by `show(cut.scenes())`. Threads read pages; `cut` uploads them and lists what to draw.
/// A page is drawn in place of its children until all children that show are there, so a frame has no holes.
///
/// Memory of a page is given back when no cut has it. Use a pool from one thread at a time. The destructor
/// waits for the pages that are being read, and with `estimate` for the part of a view that is being drawn.
template <class B>
class PagePool {
 public:
  /// Reads and uploads the roots, which stay. Throws `InvalidArgument` if `bytes` or `estimate` does not hold
  /// them, for placings that are not valid and for no pages, and what `PagedScene::read` throws.
  ///
  /// With an `uploader`, another of the same kind as `backend` which the program does not use meanwhile,
  /// threads of the pool upload the pages that they read, and `cut` only adopts them. Pages that wait for
  /// that count to `bytes`. The uploader outlives the pool and its cuts.
  PagePool(B& backend, std::vector<PlacedPages> placed, const PagePoolOptions& options = {},
           B* uploader = nullptr)
      : backend_(backend),
        options_(options),
        used_(std::make_shared<std::atomic<std::size_t>>(0)),
        most_bytes_(options.bytes - (uploader ? most_waiting(placed, options) : 0)),
        plan_(std::move(placed), most_bytes_, options.ahead > 0),
        motion_(options.ahead),
        loader_(plan_.files(), options.waiting, options.threads, options.executor, upload_by(uploader)) {
    if (options.estimate != 0 && options.estimate < plan_.root_bytes())
      detail::refuse("estimate: ", options.estimate, " bytes, expected ", plan_.root_bytes(),
                     " or more for the roots of all scenes");
    for (std::uint32_t file = 0; file < plan_.files().size(); ++file) {
      const detail::PageKey root{file, plan_.files()[file].root()};
      upload({root, plan_.files()[file].read(root.page)});
    }
    if (options.estimate != 0) meter_ = std::make_unique<detail::CutMeter>(plan_.placed(), options.estimate);
  }
  PagePool(B& backend, const PagedScene& pages, const PagePoolOptions& options = {}, B* uploader = nullptr)
      : PagePool(backend, std::vector<PlacedPages>{{pages}}, options, uploader) {}

  /// Places scenes of the pool anew, in place of all placings before; pages stay in memory. Throws
  /// `InvalidArgument`, and changes nothing, for placings that are not valid and for other scenes.
  void place(std::vector<PlacedPages> placed) {
    plan_.place(std::move(placed));
    if (meter_) meter_->place(plan_.placed());
  }

  /// The pages to draw for all views of a frame, which show all placed scenes. Uploads at most
  /// `upload_per_frame` pages that were read, and asks for missing ones. Then prefetches the pages of views
  /// `ahead`; if `ahead` is empty, of the views that the cameras reach by moving on as since the last cut.
  /// Waits for no file, thread or device, except where an upload or a release of memory does. The pages drawn
  /// depend on the views, the goal and the pages in memory alone. Throws `InvalidArgument` for a goal that is
  /// not valid, and what `upload` of the backend throws.
  Cut cut(Span<const View> views, const CutGoal& goal = {}, Span<const View> ahead = {}) {
    bool stuck = false;
    const std::vector<View> expected = motion_.ahead(views);
    return cut(views, goal, ahead.empty() ? Span<const View>{expected.data(), expected.size()} : ahead,
               options_.upload_per_frame, stuck);
  }

  /// Completes `cut`. Returns when all pages are there, except pages that fail again and pages that do not
  /// fit beside those of other cuts; `estimated_db` then is that of its views. Returns early, with an
  /// incomplete cut, when `stops()`, called after each page, is true. Releases the pages that `cut` kept, so
  /// nothing may draw its earlier scenes any more. Throws as `cut`; waiting again then continues.
  void wait(Cut& cut, const std::function<bool()>& stops = {}) {
    Cut asked;
    asked.views_ = cut.views_, asked.goal_ = cut.goal_;
    note_loaded(), failures_.clear();  // pages that failed before are tried again
    for (;;) {
      bool stuck = false;
      cut = asked;  // gives back memory
      cut = this->cut({asked.views_.data(), asked.views_.size()}, asked.goal_, {}, options_.bytes, stuck);
      if (stuck || cut.is_settled()) break;
      loader_.wait();
      if (stops && stops()) return;
    }
    if (meter_) cut.estimated_db_ = meter_->wait();
  }

  /// Of pages that are uploaded, those included that only cuts still have. @units{bytes}
  std::size_t bytes() const { return *used_; }
  std::size_t resident() const { return resident_.size(); }  ///< pages
  /// Pages that were uploaded so far, and their bytes, as often as they were.
  std::uint64_t uploads() const { return uploads_; }
  std::uint64_t uploaded_bytes() const { return uploaded_bytes_; }
  /// As `Cut::estimated_db`, by now. @units{dB}
  double estimated_db() const {
    return meter_ ? meter_->decibels() : std::numeric_limits<double>::quiet_NaN();
  }

 private:
  using SceneOn = decltype(std::declval<B&>().upload(std::declval<Scene>()));

  /// A page in the backend's memory.
  struct Resident {
    SceneOn scene;
    std::vector<std::uint32_t> ids;
    PagedScene file;  ///< which has its row
    std::size_t bytes;
    std::shared_ptr<std::atomic<std::size_t>> used;
    ~Resident() { *used -= bytes; }
  };

  Cut cut(Span<const View> views, const CutGoal& goal, Span<const View> ahead, std::size_t most_uploaded,
          bool& stuck) {
    note_loaded();
    const detail::PagePlan::Wanted wanted = plan_.choose(views, goal, ahead);
    Cut cut;
    cut.wanted_ = wanted.splats, cut.pixels_ = wanted.pixels;
    cut.views_.assign(views.begin(), views.end()), cut.goal_ = goal;
    loader_.request(bring(wanted, most_uploaded, cut, stuck));
    draw(cut);
    if (meter_) meter_->request(views, reached(goal, wanted), wanted.error);
    cut.estimated_db_ = estimated_db();
    return cut;
  }

  /// The goal that has such a cut without budgets: levels fade up to the same error.
  static CutGoal reached(const CutGoal& goal, const detail::PagePlan::Wanted& wanted) {
    const double faded = goal.pixels * (1 + goal.blend);
    return {.pixels = wanted.pixels, .blend = faded > wanted.pixels ? faded / wanted.pixels - 1 : 0};
  }

  static detail::PageUpload upload_by(B* uploader) {
    if (!uploader) return {};
    return [uploader](Scene scene) { return std::make_shared<SceneOn>(uploader->upload(std::move(scene))); };
  }

  /// Bytes of pages that threads uploaded and no cut has adopted, at most.
  static std::size_t most_waiting(const std::vector<PlacedPages>& placed, const PagePoolOptions& options) {
    std::size_t largest = 0;
    for (const PlacedPages& each : placed)
      for (const Page& page : each.pages.pages()) largest = std::max(largest, detail::resident_bytes(page));
    const std::size_t readers =
        options.executor ? detail::most_jobs : std::size_t(std::max(options.threads, 0));
    return std::min(options.waiting + readers * largest, options.bytes);
  }

  void note_loaded() {
    ++cuts_;
    for (detail::LoadedPage& page : loader_.take()) {
      if (page.failure.empty()) {
        failures_.erase(page.key);
        waiting_[page.key] = std::move(page);
        continue;
      }
      Failure& failure = failures_[page.key];
      failure.reason = std::move(page.failure);
      // A page that fails often is tried less and less often, and leaves room for other pages.
      failure.try_again = cuts_ + (std::uint64_t(8) << std::min(failure.times++, 10));
    }
  }

  /// Uploads missing pages that were read, parents before children, and returns what to ask for. Pages
  /// below one that fails have to wait for it. Sets `stuck` if memory has no room for one.
  std::vector<detail::PageKey> bring(const detail::PagePlan::Wanted& wanted, std::size_t most_uploaded,
                                     Cut& cut, bool& stuck) {
    std::map<detail::PageKey, detail::LoadedPage> read;
    read.swap(waiting_);
    std::set<detail::PageKey> blocked;
    std::vector<detail::PageKey> asked;
    std::set<detail::PageKey> lacked;
    std::size_t uploaded = 0;
    bool full = false;
    for (std::size_t i = 0; i < wanted.missing.size(); ++i) {
      const detail::PageKey key = wanted.missing[i];
      const bool now = i < wanted.now;  // rather than ahead
      const bool waits = blocked.contains(plan_.parent_of(key));
      const auto failure = failures_.find(key);
      const bool fails = failure != failures_.end();
      if (fails && now) cut.failed_.push_back({scene_of(key), key.page, failure->second.reason});
      if (waits || fails) blocked.insert(key), cut.blocked_ += now;
      bool lacks = true;
      if (const auto page = read.find(key); page != read.end() && !waits) {
        const std::size_t bytes = detail::resident_bytes(plan_.row(key));
        full = full || (uploaded != 0 && uploaded + bytes > most_uploaded);
        if (!full && plan_.is_resident(plan_.parent_of(key)) && !(stuck = !make_room(bytes))) {
          upload(std::move(page->second));
          uploaded += bytes, lacks = false;
        } else {
          full = full || stuck;
          waiting_.insert(read.extract(page));
        }
      } else if (!waits && (!fails || cuts_ >= failure->second.try_again)) {
        asked.push_back(key);
      }
      if (lacks && now) lacked.insert(key), ++cut.missing_, cut.late_ += lacked_.contains(key);
    }
    lacked_.swap(lacked);
    loader_.keep(waiting_bytes());
    return asked;
  }

  std::size_t waiting_bytes() const {
    std::size_t bytes = 0;
    for (const auto& page : waiting_) bytes += plan_.row(page.first).bytes;
    return bytes;
  }

  bool make_room(std::size_t bytes) {
    const auto is_held = [&](detail::PageKey key) { return resident_.at(key).use_count() > 1; };
    detail::PageKey victim;
    while (*used_ + bytes > most_bytes_) {
      if (!plan_.find_victim(victim, is_held)) return false;
      plan_.set_resident(victim, false);
      resident_.erase(victim);
    }
    return true;
  }

  void upload(detail::LoadedPage page) {
    const std::size_t bytes = detail::resident_bytes(plan_.row(page.key));
    SceneOn scene = page.uploaded ? std::move(*std::static_pointer_cast<SceneOn>(page.uploaded))
                                  : backend_.upload(std::move(page.content.scene));
    *used_ += bytes, uploaded_bytes_ += bytes, ++uploads_;
    resident_[page.key] = std::shared_ptr<const Resident>(new Resident{
        std::move(scene), std::move(page.content.ids), plan_.files()[page.key.file], bytes, used_});
    plan_.set_resident(page.key, true);
  }

  void draw(Cut& cut) const {
    for (const detail::PagePlan::Drawn& drawn : plan_.drawn()) {
      const PlacedPages& placed = plan_.placed()[drawn.scene];
      const detail::PageKey key{plan_.file_of(drawn.scene), drawn.page};
      const auto& page = resident_.at(key);
      cut.scenes_.push_back({page->scene.view(), placed.world_from_scene, placed.opacity * drawn.opacity,
                             placed.clip, placed.tint});
      cut.drawn_.push_back({drawn.scene, drawn.page, &plan_.row(key), &page->ids, page});
      cut.splats_ += page->scene.view().size();
    }
  }

  /// The first placed scene of a page.
  std::size_t scene_of(detail::PageKey key) const {
    std::size_t scene = 0;
    while (plan_.file_of(scene) != key.file) ++scene;
    return scene;
  }

  struct Failure {
    std::string reason;
    int times = 0;
    std::uint64_t try_again = 0;  ///< cut that may ask for it
  };

  B& backend_;
  PagePoolOptions options_;
  std::shared_ptr<std::atomic<std::size_t>> used_;
  std::size_t most_bytes_;  ///< of resident pages
  detail::PagePlan plan_;
  detail::Motion motion_;
  detail::PageLoader loader_;
  std::unique_ptr<detail::CutMeter> meter_;  ///< null: nobody asks
  std::map<detail::PageKey, detail::LoadedPage> waiting_;
  std::map<detail::PageKey, std::shared_ptr<const Resident>> resident_;
  std::map<detail::PageKey, Failure> failures_;
  std::set<detail::PageKey> lacked_;  ///< by the last cut
  std::uint64_t cuts_ = 0, uploads_ = 0, uploaded_bytes_ = 0;
};

}  // namespace swiftgs
