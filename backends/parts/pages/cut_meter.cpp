// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
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
/// What is left of the error where pages are finer by so much moves the result by a few tenths.
constexpr double finer = 16;
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
        all_{0, 0, std::max(1, view.frame.width / stride_), std::max(1, view.frame.height / stride_)} {
    view_.shows = {}, view_.request = {}, view_.frame = {};
  }

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

/// Draws cuts and adds up how far they are apart.
class Comparison {
 public:
  Comparison(PagePool<Serial>& pool, Renderer<Serial>& renderer, const CutGoal& goal, const CutGoal& fine)
      : pool_(pool), renderer_(renderer), goal_(goal), fine_(fine) {}

  /// Returns false if a page cannot be read, the pool does not hold those of a tile, or `stops()`.
  template <class Stops>
  bool add(const Samples& samples, const Part& part, const Stops& stops) {
    if (stops()) return false;
    const View chooser = samples.chooser(part);
    Cut cut = pool_.cut({&chooser, 1}, fine_);
    if (cut.pixels() > fine_.pixels) {
      cut = Cut();  // gives back memory
      const bool wide = part.width > part.height;
      if (std::max(part.width, part.height) <= default_tile_side) return false;
      Part first = part, second = part;
      if (wide)
        first.width /= 2, second.left += first.width, second.width -= first.width;
      else
        first.height /= 2, second.top += first.height, second.height -= first.height;
      return add(samples, first, stops) && add(samples, second, stops);
    }
    pool_.wait(cut);
    bool whole = cut.missing() == 0;
    draw(cut, samples, part, expected_);
    cut = Cut();
    cut = pool_.cut({&chooser, 1}, goal_);
    pool_.wait(cut);
    whole = whole && cut.missing() == 0;
    draw(cut, samples, part, found_);
    for (std::size_t i = 0; i < found_.colour.size(); ++i) {
      const double difference = double(found_.colour[i]) - double(expected_.colour[i]);
      squares_ += difference * difference, ++count_;
    }
    return whole;
  }

  double decibels() const { return -10 * std::log10(squares_ / count_); }

 private:
  void draw(const Cut& cut, const Samples& samples, const Part& part, Frame& frame) {
    View view = samples.sampler(part);
    view.frame = prepare(frame, part.width, part.height, {});
    renderer_.render_into(samples.scenes(cut), {&view, 1});
  }

  PagePool<Serial>& pool_;
  Renderer<Serial>& renderer_;
  CutGoal goal_, fine_;
  Frame expected_, found_;
  double squares_ = 0, count_ = 0;
};

bool same(const ViewConstants& a, const ViewConstants& b) {
  return std::equal(std::begin(a.centre), std::end(a.centre), b.centre) &&
         std::equal(&a.rotation[0][0], &a.rotation[0][0] + 9, &b.rotation[0][0]) && a.fx == b.fx &&
         a.fy == b.fy && a.cx == b.cx && a.cy == b.cy;
}

}  // namespace

/// What to measure.
struct MeterRequest {
  std::vector<View> views;
  CutGoal goal;
  double error = 0;
  std::vector<PlacedPages> placed;  ///< anew; none: as before

  bool is_like(Span<const View> others, const CutGoal& other) const {
    return goal.pixels == other.pixels && goal.blend == other.blend &&
           std::equal(views.begin(), views.end(), others.begin(), others.end(),
                      [](const View& a, const View& b) {
                        return same(a.camera, b.camera) && a.frame.width == b.frame.width &&
                               a.frame.height == b.frame.height;
                      });
  }
};

struct CutMeter::State {
  Renderer<Serial> renderer;
  PagePool<Serial> pool;
  mutable std::mutex mutex;
  std::condition_variable changed;
  MeterRequest last;  ///< with scenes that no measurement has placed
  bool is_asked = false, is_busy = false, stop = false;
  double decibels = unknown;
  std::thread thread;

  State(std::vector<PlacedPages> placed, std::size_t bytes)
      : pool(renderer.backend(), std::move(placed), {.bytes = bytes, .ahead = 0}) {}

  bool stops() const {
    const std::lock_guard lock(mutex);
    return stop;
  }

  double measured(MeterRequest request) try {
    if (!request.placed.empty()) pool.place(std::move(request.placed));
    if (request.error == 0) return std::numeric_limits<double>::infinity();  // all are leaves
    Comparison comparison(pool, renderer, request.goal, {.pixels = request.error / finer});
    for (const View& view : request.views) {
      if (view.panorama_part != 0) return unknown;
      const Samples samples(view);
      if (!comparison.add(samples, samples.all(), [this] { return stops(); })) return unknown;
    }
    return comparison.decibels();
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
  state_->last = {{}, {}, 0, std::move(placed)};
  state_->is_asked = false;
}

void CutMeter::request(Span<const View> views, const CutGoal& goal, double error) {
  {
    const std::lock_guard lock(state_->mutex);
    MeterRequest& last = state_->last;
    if (views.empty() || last.is_like(views, goal)) return;
    last.views.assign(views.begin(), views.end()), last.goal = goal, last.error = error;
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
  state_->changed.wait(lock, [&] { return !state_->is_asked && !state_->is_busy; });
  return state_->decibels;
}

}  // namespace swiftgs::detail
