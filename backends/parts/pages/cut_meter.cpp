// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <functional>
#include <iterator>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include <swiftgs/frame.hpp>
#include <swiftgs/pages/cut_meter.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/renderer.hpp>
#include <swiftgs/serial.hpp>

namespace swiftgs::detail {
namespace {

/// Pixels of a view that are compared, at least. Errors are so uneven that fewer are off by decibels.
constexpr double sample_count = 50'000;
/// The reference stands for the scene: its pages err by so much less than those of the cut, and by one pixel
/// at most. What is left of the error moves the result by a few tenths.
constexpr double finer_by = 16, most_of_reference = 1;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// A rectangle of an image.
struct Part {
  int left, top, width, height;
};

/// Every `stride`th pixel of a view along both axes: an image of them has their values, since focal lengths,
/// blur and splats shrink alike.
class Samples {
 public:
  explicit Samples(const View& view)
      : view_(view),
        stride_(std::max(1, int(std::sqrt(double(view.frame.pixels()) / sample_count)))),
        all_{0, 0, std::max(1, view.frame.width / stride_), std::max(1, view.frame.height / stride_)} {}

  Part all() const { return all_; }

  /// The view of a part, which chooses its pages.
  View chooser(const Part& part) const {
    View view = view_;
    ViewConstants& c = view.camera;
    c.left = float(view_.left() + stride_ * part.left), c.right = c.left + float(stride_ * part.width);
    c.top = float(view_.top() + stride_ * part.top), c.bottom = c.top + float(stride_ * part.height);
    return view;
  }

  /// The view that draws the samples of a part.
  View sampler(const Part& part) const {
    View view = view_;
    ViewConstants& c = view.camera;
    const double middle = stride_ % 2 == 0 ? 0.5 : 0;  // so that centres of samples are centres of pixels
    c.fx /= stride_, c.fy /= stride_;
    c.cx = (c.cx - view_.left() - middle) / stride_ - part.left;
    c.cy = (c.cy - view_.top() - middle) / stride_ - part.top;
    c.focal_x = float(c.fx), c.focal_y = float(c.fy);
    c.blur = shrunk(c.blur);
    c.set_pairs();
    c.left = c.top = 0;
    c.right = c.width = float(part.width), c.bottom = c.height = float(part.height);
    view.grid = TileGrid::covering(part.width, part.height);
    return view;
  }

  /// What is drawn, with the blur that scenes ask for.
  std::vector<PlacedScene> scenes(const Cut& cut) const {
    std::vector<PlacedScene> scenes = cut.scenes();
    for (PlacedScene& each : scenes) each.scene.model.blur = shrunk(each.scene.model.blur);
    return scenes;
  }

 private:
  float shrunk(float blur) const { return blur / float(stride_ * stride_); }

  View view_;
  int stride_;
  Part all_;
};

/// Draws two cuts of views, a part of a view at a time, and adds up how far they are apart.
class Comparison {
 public:
  Comparison(PagePool<Serial>& pool, Renderer<Serial>& renderer, Span<const View> views, const CutGoal& goal,
             const CutGoal& fine, std::function<bool()> stops)
      : pool_(pool), renderer_(renderer), goal_(goal), fine_(fine), stops_(std::move(stops)) {
    for (const View& view : views) {
      samples_.emplace_back(view);
      choosers_.push_back(samples_.back().chooser(samples_.back().all()));
    }
  }

  /// Compares all views. Returns false if a page cannot be read, the pool does not hold the reference of a
  /// tile or the cut of all views, or `stops()`.
  bool compare() {
    for (std::size_t k = 0; k < samples_.size(); ++k)
      if (!add(k, samples_[k].all())) return false;
    return true;
  }

  bool page_failed() const { return page_failed_; }
  double decibels() const { return -10 * std::log10(squares_ / count_); }

 private:
  bool add(std::size_t k, const Part& part) {
    if (stops_()) return false;
    std::vector<View> choosers{samples_[k].chooser(part)};
    Cut cut = pool_.cut({choosers.data(), 1}, fine_);
    if (cut.pixels() > fine_.pixels) {
      cut = Cut();  // gives back memory
      const bool wide = part.width > part.height;
      if (std::max(part.width, part.height) <= default_tile_side) return false;
      Part first = part, second = part;
      if (wide)
        first.width /= 2, second.left += first.width, second.width -= first.width;
      else
        first.height /= 2, second.top += first.height, second.height -= first.height;
      return add(k, first) && add(k, second);
    }
    if (!draw(cut, k, part, expected_)) return false;
    cut = Cut();
    // The frame has one cut for all views: the error of a page is the largest in any.
    for (std::size_t other = 0; other < choosers_.size(); ++other)
      if (other != k) choosers.push_back(choosers_[other]);
    cut = pool_.cut({choosers.data(), choosers.size()}, goal_);
    if (cut.pixels() > goal_.pixels || !draw(cut, k, part, found_)) return false;
    for (std::size_t i = 0; i < found_.colour.size(); ++i) {
      const double difference = double(found_.colour[i]) - double(expected_.colour[i]);
      squares_ += difference * difference, ++count_;
    }
    return true;
  }

  /// Completes `cut` and draws a part of view `k`. Returns false if pages are missing.
  bool draw(Cut& cut, std::size_t k, const Part& part, Frame& frame) {
    pool_.wait(cut, stops_);
    page_failed_ = !cut.failed().empty();
    if (cut.missing() != 0) return false;
    View view = samples_[k].sampler(part);
    view.frame = prepare(frame, part.width, part.height, {});
    renderer_.render_into(samples_[k].scenes(cut), {&view, 1});
    return true;
  }

  PagePool<Serial>& pool_;
  Renderer<Serial>& renderer_;
  CutGoal goal_, fine_;
  std::function<bool()> stops_;
  std::vector<Samples> samples_;
  std::vector<View> choosers_;  ///< of whole views
  Frame expected_, found_;
  double squares_ = 0, count_ = 0;
  bool page_failed_ = false;
};

/// A view without what an estimate does not depend on: its memory, its request, and the numbers of its tiles.
View without_memory(View view) {
  view.shows = {}, view.request = {};
  view.frame = {.width = view.frame.width, .height = view.frame.height};
  view.grid.first = view.grid.stride = 0;
  return view;
}

}  // namespace

/// What to measure.
struct MeterRequest {
  std::vector<View> views;  ///< as of `without_memory`
  CutGoal goal;
  std::optional<double> error;
  std::vector<PlacedPages> placed;  ///< places the scenes anew; empty: they stay where they are

  bool is_like(Span<const View> others, const CutGoal& other) const {
    return goal.pixels == other.pixels && goal.blend == other.blend &&
           std::equal(views.begin(), views.end(), others.begin(), others.end(),
                      [](const View& a, const View& b) { return a == without_memory(b); });
  }
};

struct CutMeter::State {
  Renderer<Serial> renderer;
  PagePool<Serial> pool;
  mutable std::mutex mutex;
  std::condition_variable changed;
  MeterRequest last;  ///< with scenes that no measurement has placed
  bool is_asked = false, is_busy = false, stop = false;
  bool page_failed = false;  ///< in the last measurement, whose thread has it while `is_busy`
  double decibels = unknown;
  std::thread thread;

  State(std::vector<PlacedPages> placed, std::size_t bytes)
      : pool(renderer.backend(), std::move(placed), {.bytes = bytes, .waiting = bytes / 8, .ahead = 0}) {}

  bool stops() const {
    const std::lock_guard lock(mutex);
    return stop;
  }

  double measured(MeterRequest request) try {
    if (!request.placed.empty()) pool.place(std::move(request.placed));
    page_failed = false;
    if (!request.error) return std::numeric_limits<double>::infinity();
    for (const View& view : request.views)
      if (view.panorama_part != 0) return unknown;
    Comparison comparison(pool, renderer, {request.views.data(), request.views.size()}, request.goal,
                          {.pixels = std::min(*request.error / finer_by, most_of_reference)},
                          [this] { return stops(); });
    const bool whole = comparison.compare();
    page_failed = comparison.page_failed();
    return whole ? comparison.decibels() : unknown;
  } catch (const std::exception&) {
    return unknown;  // as without memory: a number less is no reason to end the program
  }

  void measure_until_stopped() {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [&] { return stop || is_asked; });
      if (stop) return;
      MeterRequest next = last;
      last.placed.clear();
      is_asked = false, is_busy = true;
      lock.unlock();
      const double result = measured(std::move(next));
      lock.lock();
      decibels = result, is_busy = false;
      changed.notify_all();
    }
  }
};

CutMeter::CutMeter(std::vector<PlacedPages> placed, std::size_t bytes)
    : state_(std::make_unique<State>(std::move(placed), bytes)) {
  state_->thread = std::thread([this] { state_->measure_until_stopped(); });
}

CutMeter::~CutMeter() {
  {
    const std::lock_guard lock(state_->mutex);
    state_->stop = true;
  }
  state_->changed.notify_all();
  state_->thread.join();
}

void CutMeter::place(std::vector<PlacedPages> placed) {
  const std::lock_guard lock(state_->mutex);
  state_->last = {{}, {}, {}, std::move(placed)};
  state_->is_asked = false;
}

void CutMeter::request(Span<const View> views, const CutGoal& goal, std::optional<double> error) {
  {
    const std::lock_guard lock(state_->mutex);
    MeterRequest& last = state_->last;
    if (views.empty() || last.is_like(views, goal)) return;
    last.views.clear(), last.goal = goal, last.error = error;
    std::transform(views.begin(), views.end(), std::back_inserter(last.views), without_memory);
    state_->is_asked = true;
  }
  state_->changed.notify_all();
}

double CutMeter::decibels() const {
  const std::lock_guard lock(state_->mutex);
  return state_->decibels;
}

double CutMeter::wait() {
  std::unique_lock lock(state_->mutex);
  const auto is_done = [&] { return !state_->is_asked && !state_->is_busy; };
  if (is_done() && state_->page_failed) {
    state_->is_asked = true;
    state_->changed.notify_all();
  }
  state_->changed.wait(lock, is_done);
  return state_->decibels;
}

}  // namespace swiftgs::detail
