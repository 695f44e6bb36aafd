// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The views of one frame, the numbers of their tiles, and the renderer's copy of the views.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/frame_view.hpp>
#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/rendering_model.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/tiles.hpp>
#include <swiftgs/frame/view_constants.hpp>

namespace swiftgs {

/// The thresholds of blending, from `Conventions`.
struct BlendRules {
  float alpha_min = 0;   ///< less alpha is skipped
  float alpha_max = 0;   ///< more is cut
  float stop_below = 0;  ///< a pixel ends before the splat that would bring its transmittance below this
  float log2_alpha_min = 0;
  float log2_relative_min = 0;  ///< log2(alpha_min / alpha_max)
  float first_below = 0;        ///< the first splat that shows takes the transmittance below this

  bool operator==(const BlendRules&) const = default;
};

/// The placed scenes that a view shows: by default all of its frame.
struct ShownScenes {
  std::uint32_t first = 0, count = 0xffffffff;

  bool operator==(const ShownScenes&) const = default;
};

/// One image of a frame, or a rectangle of one: from where, by which rules, and where to.
struct View {
  ViewConstants camera{};
  BlendRules rules{};
  vec3 background{0};  ///< as `RenderSettings::background`
  TileGrid grid{};     ///< covers `frame`
  FrameView frame{};
  ShownScenes shows{};
  // As of `Conventions`: `PlannedViews` take what is left to the scenes from them.
  bool order_of_scenes = false, colours_of_scenes = false;
  Request request{};  ///< `asked`, in a planned frame
  ColourSpace colours = ColourSpace::srgb;
  int panorama_part = 0;  ///< as of its camera: a frame draws a view that spans several parts as several

  bool operator==(const View&) const = default;

  /// The outputs that `frame` has memory for; `request` if it has no memory yet.
  Request asked() const {
    const Request of_memory = frame.request();
    return of_memory == Request() ? request : of_memory;
  }

  /// Pixel of the image that is the first of `frame`.
  SWIFTGS_HD int left() const { return grid.columns.begin * grid.side; }
  SWIFTGS_HD int top() const { return grid.rows.begin * grid.side; }
};

/// Most views that one frame may have.
inline constexpr std::size_t max_views = std::size_t(1) << 16;

/// Numbers the tiles of all views, one grid below the other.
inline void number_tiles(Span<View> views) {
  std::uint32_t columns = 0, rows = 0;
  for (const View& view : views) columns = std::max(columns, std::uint32_t(view.grid.columns.size()));
  for (View& view : views) {
    view.grid.first = rows * columns, view.grid.stride = columns;
    rows += std::uint32_t(view.grid.rows.size());
  }
}

namespace detail {
/// Throws `InvalidArgument` if the frame of `view` has no pixels or too many, or if its tiles do not
/// cover it.
inline void check_tiles(const View& view) {
  const auto side_fits = [](int side) { return side > 0 && side <= max_image_side; };
  if (!side_fits(view.frame.width) || !side_fits(view.frame.height))
    refuse("frame: ", view.frame.width, " x ", view.frame.height, " pixels, expected 1 to ", max_image_side,
           " a side");
  const TileGrid& grid = view.grid;
  if (grid.side < raster_block_side || (grid.side & (grid.side - 1)) != 0)
    refuse("tiles: the side is ", grid.side, ", expected a power of two of at least ", raster_block_side,
           " pixels");
  const TileGrid needed = TileGrid::covering(view.frame.width, view.frame.height, grid.side);
  const auto check_run = [](const char* name, TileRun found, TileRun expected) {
    if (found.size() != expected.size())
      refuse("tiles: the number of ", name, " is ", found.size(), ", expected ", expected.size());
    if (found.begin < 0)
      refuse("tiles: the first of the ", name, " is ", found.begin, ", expected 0 or more");
  };
  check_run("columns", grid.columns, needed.columns);
  check_run("rows", grid.rows, needed.rows);
}

/// The tiles of all views. Throws as the constructor of `Views`.
inline FrameTiles frame_tiles(Span<const View> views) {
  if (views.size < 1 || views.size > max_views)
    refuse("frame: the number of views is ", views.size, ", expected 1 to ", max_views);
  for (const View& view : views) check_tiles(view);
  FrameTiles tiles{.columns = views[0].grid.stride, .rows = 0, .side = views[0].grid.side};
  std::uint64_t rows = 0;
  for (const View& view : views) {
    const TileGrid& grid = view.grid;
    if (grid.side != tiles.side)
      refuse("tiles: the side is ", grid.side, ", expected that of the first view, ", tiles.side);
    const std::uint64_t first = rows * tiles.columns;
    if (grid.stride != tiles.columns || grid.stride < std::uint32_t(grid.columns.size()) ||
        grid.first != first)
      refuse("tiles: those of a view are numbered from ", grid.first, " on in rows of ", grid.stride,
             ", expected ", first, " and ", tiles.columns, "; number_tiles numbers them");
    rows += std::uint64_t(grid.rows.size());
    if (rows * tiles.columns > max_frame_tiles)
      throw CapacityError("tiles in one frame", rows * tiles.columns, max_frame_tiles);
  }
  tiles.rows = std::uint32_t(rows);
  return tiles;
}
}  // namespace detail

/// The views of a frame, checked and numbered.
struct Views {
  Span<const View> each;         ///< in the host's memory
  const View* stored = nullptr;  ///< the same where a device's loops read them; null: handed to each loop
  FrameTiles tiles;              ///< of all views
  bool through_lens = false;     ///< some view is

  Views() = default;
  /// Throws `InvalidArgument` for no or too many views, a frame of no or too many pixels, tiles that do
  /// not cover it, or tiles that `number_tiles` did not number; and `CapacityError` beyond `max_frame_tiles`.
  Views(Span<const View> views, const View* stored_views = nullptr)
      : each(views),
        stored(stored_views),
        tiles(detail::frame_tiles(views)),
        through_lens(std::any_of(views.begin(), views.end(),
                                 [](const View& view) { return view.camera.through_lens; })) {}
  Views(const View* first, std::size_t count) : Views(Span<const View>{first, count}) {}

  const View& operator[](std::size_t i) const { return each[i]; }

  /// Where loops of the backend read them.
  SWIFTGS_HD const View* reachable() const { return stored ? stored : each.data; }

  const View* begin() const { return each.begin(); }
  const View* end() const { return each.end(); }
  std::size_t size() const { return each.size; }
};

/// Index of the view that tile number `tile` belongs to.
SWIFTGS_HD inline std::uint32_t view_of_tile(const View* views, std::uint32_t count, std::uint32_t tile) {
  std::uint32_t low = 0;
  for (std::uint32_t high = count; high - low > 1;) {
    const std::uint32_t middle = (low + high) / 2;
    if (views[middle].grid.first <= tile)
      low = middle;
    else
      high = middle;
  }
  return low;
}

/// Index of the view that part `i` was cut from.
inline std::uint32_t owner_of(Span<const std::uint32_t> owners, std::size_t i) {
  return owners.empty() ? std::uint32_t(i) : owners[i];
}

/// Views as a frame draws them: a panorama that spans several parts is several, side by side in its memory.
class PanoramaParts {
 public:
  /// `views` where none is cut; else copies, which hold until the next call. Throws `InvalidArgument`
  /// where tiles of a panorama do not cover it or are no divisor of its parts.
  Span<const View> of(Span<const View> views) {
    owners_.clear(), parts_.clear();
    if (std::none_of(views.begin(), views.end(), is_cut)) return views;
    for (std::uint32_t owner = 0; owner < views.size; ++owner) {
      const View& view = views[owner];
      if (!is_cut(view)) {
        parts_.push_back(view), owners_.push_back(owner);
        continue;
      }
      const int width = view.panorama_part, end = view.left() + view.frame.width;
      detail::check_tiles(view);
      if (width % view.grid.side != 0)
        detail::refuse("tiles: the side is ", view.grid.side, ", expected a divisor of the ", width,
                       " columns of a panorama's part");
      for (int begin = view.left(), next; begin < end; begin = next) {
        next = std::min((begin / width + 1) * width, end);
        parts_.push_back(columns_of(view, begin, next)), owners_.push_back(owner);
      }
    }
    return {parts_.data(), parts_.size()};
  }

  /// Indices of the views that the parts were cut from; none where no view is cut.
  Span<const std::uint32_t> owners() const { return {owners_.data(), owners_.size()}; }

 private:
  static bool is_cut(const View& view) {
    const int width = view.panorama_part;
    if (width == 0 || view.grid.side < 1) return false;  // `Views` refuses the latter
    return view.left() / width != (view.left() + view.frame.width - 1) / width;
  }

  static View columns_of(View view, int begin, int end) {
    view.frame = view.frame.part(begin - view.left(), 0, end - begin, view.frame.height);
    view.camera.panorama_middle = (begin / view.panorama_part + 0.5) * view.panorama_part;
    view.camera.left = float(begin), view.camera.right = float(end);
    const int side = view.grid.side;
    view.grid.columns = {begin / side, (end + side - 1) / side};
    return view;
  }

  std::vector<View> parts_;
  std::vector<std::uint32_t> owners_;
};

/// A renderer's own copy of the views of a frame.
template <class B>
struct ViewStorage {
  std::vector<View> each;

  static std::tuple<> buffers(auto&) { return {}; }  ///< none in the backend's own memory
};

/// How loops of a device read views and placed scenes.
enum class ViewAccess {
  any,     ///< as is quickest
  stored,  ///< from memory of the device, which recorded frames read again
};

/// Copies `views` and numbers their tiles. What it returns holds until the next call. Throws as `Views`.
/// Backends that do not reach the host's memory overload this.
template <class B>
Views store_views(B&, Span<const View> views, ViewStorage<B>& storage, ViewAccess = ViewAccess::any) {
  storage.each.assign(views.begin(), views.end());
  number_tiles({storage.each.data(), storage.each.size()});
  return Views(storage.each.data(), storage.each.size());
}

}  // namespace swiftgs
