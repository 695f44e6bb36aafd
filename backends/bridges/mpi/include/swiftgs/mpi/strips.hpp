// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who draws what. The tiles of all views of a frame lie in one tile atlas (`FrameTiles`), one view
/// below the other. A strip is consecutive rows of it. Each rank draws one strip.

#include <cstdint>
#include <vector>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/views.hpp>

namespace swiftgs {

/// Rank r draws rows [cuts[r], cuts[r + 1]) of the tile atlas. If there are fewer rows than ranks, the last
/// ranks draw none.
using StripCuts = std::vector<std::uint32_t>;

/// Shares out the rows of a tile atlas by what they cost in the frames before. Counts in integers, so that
/// all ranks find the same cuts.
class SWIFTGS_API StripPlan {
 public:
  StripPlan(std::uint32_t rows, int ranks);

  std::uint32_t rows() const { return std::uint32_t(costs_.size()); }
  const StripCuts& cuts() const { return cuts_; }

  /// Learns how long each rank's strip took, and moves the cuts where the slowest rank took a twentieth
  /// longer than the mean. @units{nanoseconds}
  void learn(Span<const std::uint64_t> taken);

 private:
  std::vector<std::uint64_t> costs_;  ///< of each row; the mean of what was learnt, recent frames first
  StripCuts cuts_;
};

/// A part of one view that lies in a strip; of a panorama, one in each part that it is drawn in.
struct ViewStrip {
  std::uint32_t view = 0;               ///< index
  int first_row = 0, first_column = 0;  ///< of the view's frame @units{pixels}
  int rows = 0, width = 0;              ///< @units{pixels}

  /// The part of the view's frame that the strip covers.
  FrameView pixels_of(const FrameView& frame) const {
    return frame.part(first_column, first_row, width, rows);
  }
};

/// The view strips of a strip, as views. Their frames have no memory.
struct Strip {
  std::uint32_t first_view = 0;  ///< the view that the first view strip is a part of
  std::vector<ViewStrip> view_strips;
  std::vector<View> views;
};

/// Rows [begin, end) of the tile atlas of `views`, whose tiles are numbered.
SWIFTGS_API Strip strip_of(Span<const View> views, std::uint32_t begin, std::uint32_t end);

}  // namespace swiftgs
