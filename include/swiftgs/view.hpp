// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <swiftgs/camera.hpp>
#include <swiftgs/conventions.hpp>
#include <swiftgs/count.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/round_to_nearest.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/view_constants.hpp>

namespace swiftgs {

/// The thresholds of blending, from `Conventions`.
struct BlendRules {
  float alpha_min = 0;       ///< less alpha is skipped
  float alpha_max = 0;       ///< more is cut
  float stop_below = 0;      ///< a pixel ends before the splat that would bring its transmittance below this
  float log2_alpha_min = 0;  ///< for `Cpu`
  float log2_relative_min = 0;  ///< log2(alpha_min / alpha_max), for `Cuda`

  static BlendRules from(const Conventions& c) {
    const float stop = c.stop + 0.0f;  // never -0: backends look at its sign
    return {c.alpha_min, c.alpha_max, c.stop_at_equal ? std::nextafter(stop, 1.0f) : stop,
            std::log2(c.alpha_min), float(std::log2(double(c.alpha_min) / double(c.alpha_max)))};
  }
};

/// One image of a frame, or a rectangle of one: from where, by which rules, and where to.
struct View {
  ViewConstants camera{};
  BlendRules rules{};
  vec3 background{0};  ///< RGB in the scene's own values
  TileGrid grid{};     ///< covers `frame`
  FrameView frame{};

  /// Pixel of the image that is the first of `frame`.
  SWIFTGS_HD int left() const { return grid.columns.begin * grid.side; }
  SWIFTGS_HD int top() const { return grid.rows.begin * grid.side; }
};

namespace detail {
[[noreturn]] inline void refuse(const char* what, std::size_t found, const std::string& expected) {
  throw std::invalid_argument(std::string(what) + " is " + std::to_string(found) + ", expected " + expected);
}
}  // namespace detail

/// Where a frame that shows a part of an image begins in it. A multiple of `default_tile_side`, so that the
/// part has the bits of the whole image. @units{pixels}
struct FirstPixel {
  int x = 0, y = 0;
};

/// A view through `camera` into `frame`, with tiles of the usual side. A frame smaller than the camera's
/// image shows the part of it that begins at `first`; the parts of several views make up one image, bit for
/// bit. Rounds to nearest. Throws as `view_constants`, and `std::invalid_argument` if the frame does not lie
/// within the image.
inline View make_view(const Camera& camera, const Conventions& conventions, const FrameView& frame,
                      vec3 background = vec3(0), FirstPixel first = {}) {
  const RoundToNearest scope;
  View view{view_constants(camera, conventions), BlendRules::from(conventions), background, {}, frame};
  const auto run = [](const char* name, int begin, int size, int whole) {
    const int side = default_tile_side;
    if (begin < 0 || begin % side != 0)
      throw std::invalid_argument("view: the first pixel's " + std::string(name) + " is " +
                                  std::to_string(begin) + ", expected a multiple of " + std::to_string(side));
    if (size < 1 || size > whole - begin)
      throw std::invalid_argument("view: the frame has " + std::to_string(size) + " pixels along " + name +
                                  " from " + std::to_string(begin) +
                                  " on, expected 1 or more within the camera's " + std::to_string(whole));
    return TileRun{begin / side, (begin + size + side - 1) / side};
  };
  view.grid.columns = run("x", first.x, frame.width, camera.width);
  view.grid.rows = run("y", first.y, frame.height, camera.height);
  view.grid.stride = std::uint32_t(view.grid.columns.size());
  view.camera.left = float(first.x), view.camera.right = float(first.x + frame.width);
  view.camera.top = float(first.y), view.camera.bottom = float(first.y + frame.height);
  return view;
}

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
/// Throws `std::invalid_argument` if the frame of `view` has no pixels or too many, or if its tiles do not
/// cover it.
inline void check_tiles(const View& view) {
  const auto side_fits = [](int side) { return side > 0 && side <= max_image_side; };
  if (!side_fits(view.frame.width) || !side_fits(view.frame.height))
    throw std::invalid_argument("frame: " + std::to_string(view.frame.width) + " x " +
                                std::to_string(view.frame.height) + " pixels, expected 1 to " +
                                std::to_string(max_image_side) + " a side");
  const TileGrid& grid = view.grid;
  if (grid.side < raster_block_side || (grid.side & (grid.side - 1)) != 0)
    refuse("tiles: the side", std::size_t(grid.side),
           "a power of two of at least " + std::to_string(raster_block_side) + " pixels");
  const TileGrid needed = TileGrid::covering(view.frame.width, view.frame.height, grid.side);
  const auto check_run = [](const char* name, TileRun found, TileRun expected) {
    const std::string of = std::string("tiles: the ");
    if (found.size() != expected.size())
      refuse((of + "number of " + name).c_str(), std::size_t(found.size()), std::to_string(expected.size()));
    if (found.begin < 0)
      throw std::invalid_argument(of + "first of the " + name + " is " + std::to_string(found.begin) +
                                  ", expected 0 or more");
  };
  check_run("columns", grid.columns, needed.columns);
  check_run("rows", grid.rows, needed.rows);
}

/// The tiles of all views. Throws as the constructor of `Views`.
inline FrameTiles frame_tiles(Span<const View> views) {
  if (views.size < 1 || views.size > max_views)
    refuse("frame: the number of views", views.size, "1 to " + std::to_string(max_views));
  for (const View& view : views) check_tiles(view);
  FrameTiles tiles{.columns = views[0].grid.stride, .rows = 0, .side = views[0].grid.side};
  std::uint64_t rows = 0;
  for (const View& view : views) {
    const TileGrid& grid = view.grid;
    if (grid.side != tiles.side)
      refuse("tiles: the side", std::size_t(grid.side),
             "that of the first view, " + std::to_string(tiles.side));
    const std::uint64_t first = rows * tiles.columns;
    if (grid.stride != tiles.columns || grid.stride < std::uint32_t(grid.columns.size()) ||
        grid.first != first)
      throw std::invalid_argument("tiles: those of a view are numbered from " + std::to_string(grid.first) +
                                  " on in rows of " + std::to_string(grid.stride) + ", expected " +
                                  std::to_string(first) + " and " + std::to_string(tiles.columns) +
                                  "; number_tiles numbers them");
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

  Views() = default;
  /// Throws `std::invalid_argument` if there are no or too many views, if the frame of one has no pixels or
  /// too many, if its tiles do not cover it, or if tiles are not numbered as `number_tiles` does; and
  /// `CapacityError` beyond `max_frame_tiles`.
  Views(Span<const View> views, const View* stored_views = nullptr)
      : each(views), stored(stored_views), tiles(detail::frame_tiles(views)) {}
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

/// A renderer's own copy of the views of a frame.
template <class B>
struct ViewStorage {
  std::vector<View> each;

  static std::tuple<> buffers(auto&) { return {}; }  ///< none in the backend's own memory
};

/// How loops of a device read views.
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

/// A raster block of a view.
struct RasterBlockPlace {
  std::uint32_t view;  ///< index
  int x, y;            ///< its first pixel in the view's frame
};

/// The raster blocks of all views. They are numbered as tiles are, but are smaller where tiles are larger.
struct RasterBlocks {
  std::uint32_t columns, rows;
  std::uint32_t of_tile;  ///< a side

  SWIFTGS_HD explicit RasterBlocks(const FrameTiles& tiles)
      : columns(tiles.columns * std::uint32_t(tiles.side / raster_block_side)),
        rows(tiles.rows * std::uint32_t(tiles.side / raster_block_side)),
        of_tile(std::uint32_t(tiles.side / raster_block_side)) {}
  SWIFTGS_HD std::size_t size() const { return std::size_t(columns) * rows; }

  /// Where the raster block in this column and row lies. It may lie outside of the view's frame.
  SWIFTGS_HD RasterBlockPlace place(const View* views, std::uint32_t count, std::uint32_t column,
                                    std::uint32_t row) const {
    const std::uint32_t tiles = columns / of_tile;
    const std::uint32_t view = count == 1 ? 0 : view_of_tile(views, count, row / of_tile * tiles);
    const std::uint32_t first_row = count == 1 ? 0 : views[view].grid.first / tiles * of_tile;
    return {view, int(column) * raster_block_side, int(row - first_row) * raster_block_side};
  }
};

}  // namespace swiftgs
