// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <optional>
#include <vector>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/views.hpp>
#include <swiftgs/pages/cut.hpp>
#include <swiftgs/pages/page_loader.hpp>
#include <swiftgs/pages/paged_scene.hpp>

namespace swiftgs::detail {

/// Memory that a page takes once it is uploaded, without what pads its arrays. @units{bytes}
inline std::size_t resident_bytes(const Page& page) {
  return page.bytes + (page.count + chunk_size - 1) / chunk_size * sizeof(ChunkBounds);
}

/// Decides which pages a frame wants, which pages it draws, and which pages leave memory first. Keeps track
/// of the resident pages. The parent of a resident page is always resident.
class SWIFTGS_API PagePlan {
 public:
  /// An eighth of the memory that roots leave is for views ahead alone if it `keeps_ahead`.
  PagePlan(std::vector<PlacedPages> placed, std::size_t most_bytes, bool keeps_ahead);

  /// Throws as `validate_placing`, and `InvalidArgument` for scenes that it was not made with. Changes
  /// nothing then.
  void place(std::vector<PlacedPages> placed);

  const std::vector<PlacedPages>& placed() const { return placed_; }
  const std::vector<PagedScene>& files() const { return files_; }  ///< each once
  std::uint32_t file_of(std::size_t scene) const { return file_of_[scene]; }
  std::size_t root_bytes() const { return root_bytes_; }  ///< of the roots of all files @units{bytes}
  const Page& row(PageKey key) const { return files_[key.file].pages()[key.page]; }

  struct Wanted {
    std::uint64_t splats = 0;
    double pixels = 0;
    std::optional<double> error;   ///< largest of a page to draw that has children; none: all are leaves
    std::vector<PageKey> missing;  ///< coarse before fine; those of views ahead last
    std::size_t now = 0;           ///< of `missing`, those of the frame
  };
  /// Chooses the pages of a frame: the largest error is mended first, until all are at most the goal's, or
  /// the next would exceed the budget of splats or memory. Then the same for views ahead, in the memory that
  /// is left.
  Wanted choose(Span<const View> views, const CutGoal& goal, Span<const View> ahead);

  struct Drawn {
    std::size_t scene;
    std::uint32_t page;
    float opacity;  ///< 1 but of pages that fade
  };
  /// The pages to draw for the choice, in the order of leaves: of a page that lacks a child that shows,
  /// itself.
  std::vector<Drawn> drawn() const;

  bool is_wanted(PageKey key) const { return state(key).used == frame_; }
  bool is_resident(PageKey key) const { return state(key).resident; }
  PageKey parent_of(PageKey key) const { return {key.file, state(key).parent}; }  ///< not of a root
  void set_resident(PageKey key, bool resident);
  /// The page that was not wanted for the longest time, of those without resident children. Passes over pages
  /// that a cut holds: forgetting them would free nothing. False: none.
  bool find_victim(PageKey& victim, const std::function<bool(PageKey)>& is_held) const;

 private:
  struct PageState {
    std::uint64_t used = 0;  ///< last frame that wanted it
    std::uint32_t parent = Page::none;
    bool resident = false;
    int children = 0;                    ///< that are resident
    std::list<PageKey>::iterator place;  ///< in `by_use_`, of a resident page
  };
  /// A page of a placed scene, as the last frame saw it.
  struct Seen {
    std::uint64_t refined = 0;  ///< frame that chose its children
    float left = 0;             ///< how much of the page shows beside its children in that frame, 0 to 1
    std::uint64_t shown = 0;    ///< frame in which a view may show it
  };
  struct Candidate;
  class Eyes;

  void use(PageKey key);
  PageState& state(PageKey key) { return states_[key.file][key.page]; }
  const PageState& state(PageKey key) const { return states_[key.file][key.page]; }
  /// Chooses pages for `views` and adds their bytes to `bytes`. `draws`: the frame shows them.
  Wanted grow(Span<const View> views, const CutGoal& goal, bool draws, std::size_t& bytes);
  void draw(const Drawn& page, std::vector<Drawn>& to) const;

  std::vector<PlacedPages> placed_;
  std::size_t most_bytes_, root_bytes_ = 0;
  std::size_t ahead_bytes_ = 0;  ///< for views ahead alone
  std::vector<PagedScene> files_;
  std::vector<std::uint32_t> file_of_;
  std::vector<std::vector<PageState>> states_;  ///< of each file
  std::vector<std::vector<Seen>> seen_;         ///< of each placed scene
  std::list<PageKey> by_use_;                   ///< resident pages but roots, the longest not wanted first
  std::uint64_t frame_ = 0;
};

}  // namespace swiftgs::detail
