// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/placed_scene.hpp>
#include <swiftgs/frame/placing.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/pages/paged_scene.hpp>

namespace swiftgs {

/// A paged scene in a frame, as `PlacedScene` places another. One file may be placed often: its pages are in
/// memory once.
struct PlacedPages {
  PagedScene pages;
  Similarity world_from_scene{};
  float opacity = 1;
  Clip clip{};
  Tint tint{};
};

/// What a cut should be like.
struct CutGoal {
  /// Largest error of a page that is drawn; 0 draws leaves alone. @units{pixels}
  double pixels = 1;
  /// Lets a page fade into its children while its error rises from `pixels` to (1 + `blend`) times `pixels`,
  /// so that levels do not change at once as a camera moves. Pages that err by up to as much then still show.
  /// 0 or more; 0: pages change at once.
  double blend = 0;
  /// Most Gaussians and nodes of a complete cut. The largest errors are mended first. Roots show in any case.
  std::uint64_t splats = std::numeric_limits<std::uint64_t>::max();
};

/// A page of a placed scene that could not be read. Its parent is drawn, and it is tried again later.
struct PageFailure {
  std::size_t scene;  ///< index of the placed pages
  std::uint32_t page;
  std::string reason;
};

/// What a number of a frame names.
struct NamedNode {
  std::size_t scene = 0;  ///< index of the placed pages
  std::uint32_t page = 0;
  bool is_gaussian = true;  ///< rather than a node that stands for several
  /// Number of the Gaussian in the source, or of the node in its page.
  std::uint32_t number = 0;
};

/// Pages that a frame draws, each a placed scene. It keeps them in memory: let go of it when the frame is
/// drawn. A cut without holes shows every Gaussian of the views or a node that stands for it.
class Cut {
 public:
  /// For `render_into`. Add your own behind them.
  const std::vector<PlacedScene>& scenes() const { return scenes_; }

  std::uint64_t splats() const { return splats_; }  ///< Gaussians and nodes of `scenes`
  std::uint64_t wanted() const { return wanted_; }  ///< at most, once all pages are there
  std::size_t missing() const { return missing_; }  ///< pages that are not in memory yet
  std::size_t late() const { return late_; }        ///< of these, pages that the cut before lacked too
  double pixels() const { return pixels_; }         ///< error that the budgets allow when nothing is missing
  /// PSNR beside the scene of the last complete cut that the pool measured: of its pages alone in front of
  /// the views' `background`, without other scenes and images below, of colours before conversion, at 50,000
  /// pixels of a view or more, evenly. In a walk it lags by seconds. NaN before the first, of panoramas,
  /// where a page could not be read, and without `PagePoolOptions::estimate` or where that is too small.
  /// @units{dB}
  double estimated_db() const { return estimated_db_; }
  const std::vector<PageFailure>& failed() const { return failed_; }
  /// Whether nothing is missing but pages that fail, and those below them.
  bool is_settled() const { return missing_ == blocked_; }

  /// What ids and picks of a frame of `scenes` mean. Throws `InvalidArgument` if none has the number.
  NamedNode named(std::uint32_t number) const {
    const PlacedIndex at = placed_index(scenes_, number);
    const Drawn& drawn = drawn_[at.scene];
    const auto i = std::uint32_t(at.gaussian);
    if (!drawn.row->is_leaf()) return {drawn.scene, drawn.page, false, i};
    const std::vector<std::uint32_t>& ids = *drawn.ids;
    return {drawn.scene, drawn.page, true, ids.empty() ? std::uint32_t(drawn.row->first) + i : ids[i]};
  }

 private:
  template <class B>
  friend class PagePool;

  struct Drawn {
    std::size_t scene;
    std::uint32_t page;
    const Page* row;
    const std::vector<std::uint32_t>* ids;
    std::shared_ptr<const void> kept;  ///< the page, with what `row` and `ids` point to
  };

  std::vector<PlacedScene> scenes_;
  std::vector<Drawn> drawn_;
  std::vector<PageFailure> failed_;
  std::uint64_t splats_ = 0, wanted_ = 0;
  std::size_t missing_ = 0, late_ = 0;
  std::size_t blocked_ = 0;  ///< missing pages that fail, and those below them
  double pixels_ = 0, estimated_db_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<View> views_;  ///< what it was made for
  CutGoal goal_;
};

}  // namespace swiftgs
