// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The contribution of each Gaussian to a set of images: its blending weight, alpha times transmittance,
/// summed over all pixels of all views. This needs no derivatives, and colours only where one might not be
/// finite. A view costs one frame's projection, sort and blending.
///
/// Sums are integers: weights are added in parts of 2^-31, so that the bits do not depend on the order of
/// additions, the number of threads or the run. A weight of 2^-8 or more is a whole number of parts. A
/// smaller one is cut to a whole number, and loses less than 2^-31.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include <swiftgs/bounds/ellipse.hpp>
#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/backend.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/stages.hpp>
#include <swiftgs/frame/stored_scenes.hpp>
#include <swiftgs/functor/blend.hpp>
#include <swiftgs/functor/stage_table.hpp>
#include <swiftgs/lens/view.hpp>
#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/sort/early.hpp>

namespace swiftgs {

/// Parts of a weight of 1.
inline constexpr float contribution_parts = 2147483648.0f;

/// Largest number of pixels in a sum, of all views together. A pixel adds at most 2^31 parts to one Gaussian,
/// because no weight is above 1, so fewer than 2^33 pixels keep every sum below 2^64.
inline constexpr std::uint64_t max_contribution_pixels = (std::uint64_t(1) << 33) - 1;

/// Whole parts of `weight`, which is 0 to 1. Only the cut rounds: scaling by a power of 2 is exact.
SWIFTGS_HD inline std::uint32_t weight_parts(float weight) {
  return std::uint32_t(weight * contribution_parts);
}

/// The weight of a sum of parts. @units{pixels}
constexpr double weight_of_parts(std::uint64_t parts) { return double(parts) / double(contribution_parts); }

/// Input of the weights of one view. All pointers are to memory that the backend can reach.
struct ContributionJob {
  /// Splats, lists and a view whose frame has a size and no planes. Colours tell only which splats are
  /// colourless.
  RasterJob raster;
  std::uint64_t* sums;  ///< @shape{Gaussians} parts, added to
};

namespace detail {
/// Whether a sum of a few dozen such numbers could leave the range of float.
constexpr bool is_extreme(double value) { return !(value >= -1e36 && value <= 1e36); }

inline bool some_is_extreme(const float* values, std::size_t count) {
  bool extreme = false;
  for (std::size_t i = 0; i < count; ++i) extreme |= is_extreme(values[i]);
  return extreme;
}
}  // namespace detail

/// Whether a Gaussian of `scene` may have a colour that is not finite in a view from within 1e36 of the
/// origin. Basis functions are below 1.2, so harmonics up to 1e36 sum up to less than 1e38.
inline bool colours_may_overflow(const Scene& scene) {
  const auto extreme = [](const auto& array, std::size_t width) {
    const auto* values = reinterpret_cast<const float*>(array.data());
    return detail::some_is_extreme(values, width * array.size());
  };
  return extreme(scene.sh0, 3) || extreme(scene.sh_rest, 1) || extreme(scene.means, 3);
}

/// Sets a sum to 0.
struct SWIFTGS_API ClearSums {
  std::uint64_t* sums;
  SWIFTGS_HD void operator()(std::size_t i) const { sums[i] = 0; }
};

/// Sets `count` sums to 0. Backends without functors overload this.
template <FunctorBackend B>
void clear_sums(B& b, std::uint64_t* sums, std::size_t count) {
  b.for_each(count, ClearSums{sums});
}

/// Blends one raster block, pixel by pixel, on a host, and adds the weights to their Gaussians, with one
/// atomic addition for each splat and raster block.
struct AddRasterBlockContributions {
  ContributionJob job;
  RasterBlocks blocks;

  void operator()(std::size_t block) const {
    const RasterJob& raster = job.raster;
    const RasterBlockOfView here(raster.views, blocks, block);
    if (here.empty()) return;
    const TileRange range = here.list(raster);
    if (range.begin == range.end) return;
    Pixels pixels(here);
    const bool some_colourless = raster.colours.some_colourless();
    for (std::uint32_t at = range.begin; at < range.end && pixels.live > 0; ++at) {
      const std::uint32_t id = raster.lists.ids[at];
      if (some_colourless && is_colourless(raster.colours.each[id])) continue;
      const std::uint64_t parts = pixels.blend(raster.splats.shapes[id], here.view.rules);
      if (parts == 0) continue;
      std::atomic_ref<std::uint64_t> sum(job.sums[raster.splats.gaussians[id]]);
      sum.fetch_add(parts, std::memory_order_relaxed);
    }
  }

 private:
  /// The pixels of a raster block that lie in the image.
  struct Pixels {
    vec2 first_centre;
    int columns, rows;
    int live;  ///< pixels that have not stopped
    float transmittances[raster_block_side * raster_block_side];
    bool stopped[raster_block_side * raster_block_side] = {};

    explicit Pixels(const RasterBlockOfView& here)
        : first_centre(here.first_centre), columns(here.columns), rows(here.rows), live(columns * rows) {
      for (float& transmittance : transmittances) transmittance = 1;
    }

    /// Parts of a splat's weight in all pixels, by the arithmetic and the rules of `BlendRasterBlock`.
    std::uint64_t blend(const SplatShape& shape, const BlendRules& rules) {
      AxisSharedThreshold<FloatCholesky>::Kernel kernel(shape, first_centre, rules);
      std::uint64_t parts = 0;
      for (int row = 0; row < rows; ++row) {
        const float y = first_centre.y + float(row);
        if (!row_touched(shape, first_centre.x, y)) continue;
        kernel.start_row(y);
        for (int column = 0; column < columns; ++column) {
          const int pixel = row * raster_block_side + column;
          if (stopped[pixel]) continue;
          const float alpha = kernel.alpha(column);
          if (alpha == 0) continue;
          float& transmittance = transmittances[pixel];
          const float next = dimmed(transmittance, alpha);
          if (next < rules.stop_below) {
            stopped[pixel] = true, --live;
            continue;
          }
          parts += weight_parts(alpha * transmittance);
          transmittance = next;
        }
      }
      return parts;
    }
  };
};

/// Adds the weights of all raster blocks, on hosts. A device overloads this. Throws as `raster_blocks_of`.
template <FunctorBackend B>
requires(bool(B::reaches_host_memory)) void add_contributions(B& b, const ContributionJob& job) {
  const RasterBlocks blocks = raster_blocks_of(job.raster);
  b.for_each(blocks.size(), AddRasterBlockContributions{job, blocks});
}

/// Sums the weights of the Gaussians of a scene, or of placed scenes, over views that are added one by one.
/// It uses exact float terms, exact bounds, and the conventions' rules of alpha and stop, so
/// `AxisSharedThreshold<FloatCholesky>` blends with the same weights.
///
/// Stages and memory are a renderer's. Frames do not draw Gaussians whose colour is not finite. To leave
/// these Gaussians out too, it evaluates colours, but not for a scene alone with numbers below 1e36.
template <BackendPolicy B>
class Contributions {
 public:
  /// Uploads `scene` to `backend`. Throws as `upload` does, and `CapacityError` beyond 2^32 - 1 Gaussians.
  explicit Contributions(std::shared_ptr<const Scene> scene, B backend = B())
      : Contributions(std::move(backend)) {
    own_.emplace(stages_.backend().upload(scene));
    colours_may_overflow_ = colours_may_overflow(*scene);
    begin(*own_);
  }

  /// Sums of placed scenes. The uploaded scenes outlive this object, which keeps their placing of now.
  /// Gaussians are numbered over all scenes, see `placed_index`. Throws `InvalidArgument` as `validate` does
  /// for each scene, and `CapacityError` beyond 2^32 - 1 Gaussians.
  explicit Contributions(const PlacedScenes& scenes, B backend = B()) : Contributions(std::move(backend)) {
    for (const PlacedScene& placed : scenes.each()) validate(placed);
    begin(scenes);
  }

  /// Adds the weights in one view. Throws `InvalidArgument` for an invalid camera or conventions, and
  /// `CapacityError` for more intersections than a frame may have or more pixels than
  /// `max_contribution_pixels`. If it throws, it has added nothing.
  void add(const Camera& camera, const Conventions& conventions) {
    const View view = make_view(camera, conventions, {.width = camera.width, .height = camera.height});
    const std::uint64_t pixels = pixels_ + std::uint64_t(camera.width) * std::uint64_t(camera.height);
    if (pixels > max_contribution_pixels)
      throw CapacityError("pixels of all views", pixels, max_contribution_pixels);

    const FramePlan plan = plan_frame(stages_.backend(), scenes_, {&view, 1}, plan_memory_,
                                      [](const StoredScenes&, Span<const View> views) { return views; });
    const bool shaded = colours_may_overflow_ || centre_is_extreme(view.camera);
    const auto add = [&](const RasterJob& job) { add_contributions(stages_.backend(), {job, sums_.data()}); };
    NoHooks none;
    stages_.run(plan, shaded, none, add);
    pixels_ = pixels;
  }

  /// Parts of the weight of each Gaussian so far; `weight_of_parts` converts them to pixels.
  /// @shape{Gaussians}
  std::vector<std::uint64_t> sums() const {
    std::vector<std::uint64_t> sums(sums_.size());
    stages_.backend().download(sums_.span(), sums.data());
    return sums;
  }

  /// Number of splats in the last added view: a Gaussian has one in each part of a panorama that shows it.
  std::size_t visible() const { return stages_.splats().count; }

 private:
  explicit Contributions(B backend)
      : stages_(std::move(backend), {bounds_stages<B, Ellipse>(), {}, common_stages<B>()},
                std::make_unique<SortStageOf<B, EarlySort, Ellipse>>()) {
    use_memory_of(stages_.backend(), sums_, plan_memory_);
  }

  /// Sets all sums to 0.
  void begin(const PlacedScenes& scenes) {
    check_ready(stages_.backend());
    scenes_.assign(scenes.each().begin(), scenes.each().end());
    const std::size_t most = std::numeric_limits<std::uint32_t>::max();
    std::size_t n = 0;
    for (const PlacedScene& placed : scenes_) n += placed.size();
    if (n > most) throw CapacityError("Gaussians", n, most);
    sums_.reset(n);
    clear_sums(stages_.backend(), sums_.data(), n);
  }

  static bool centre_is_extreme(const ViewConstants& camera) {
    const double* centre = camera.centre;
    return detail::is_extreme(centre[0]) || detail::is_extreme(centre[1]) || detail::is_extreme(centre[2]);
  }

  Stages<B> stages_;
  std::optional<typename B::SceneOn> own_;  ///< of the first constructor
  std::vector<PlacedScene> scenes_;
  bool colours_may_overflow_ = true;  ///< unknown of placed scenes, so assumed
  PlanMemory<B> plan_memory_;
  typename B::template Buffer<std::uint64_t> sums_;
  std::uint64_t pixels_ = 0;
};

}  // namespace swiftgs
