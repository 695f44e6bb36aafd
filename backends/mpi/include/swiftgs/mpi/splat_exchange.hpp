// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <swiftgs/backend.hpp>
#include <swiftgs/colours.hpp>
#include <swiftgs/error.hpp>
#include <swiftgs/footprint.hpp>
#include <swiftgs/mpi/bands.hpp>
#include <swiftgs/mpi/packing.hpp>
#include <swiftgs/mpi/ranks.hpp>
#include <swiftgs/mpi/staging.hpp>
#include <swiftgs/shade_stage.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/tiles.hpp>
#include <swiftgs/view.hpp>

namespace swiftgs {

/// Brings each rank the splats that its band may show, those of all ranks one behind the other: since parts
/// of a scene follow its order, splats of a view come in the order of their Gaussians, and equal depths are
/// sorted as in one process.
template <class B>
class SplatExchange {
 public:
  /// Whether messages go by a `DirectLink`.
  void set_direct(bool direct) { direct_ = direct; }

  /// Sorts out which splats go to which rank, and waits for their number. `splats` holds `count`, and may
  /// have room for more. Not collective. Throws `CapacityError`.
  template <class Bounds>
  void list(B& b, const Splats<B>& splats, std::size_t count, const Footprints<B, Bounds>& footprints,
            const Views& views, const BandCuts& cuts) {
    const std::size_t ranks = cuts.size() - 1;
    begins_.assign(ranks + 1, 0);
    if (count == 0) return;
    rank_of_row_.clear();
    for (std::size_t r = 0; r < ranks; ++r) rank_of_row_.resize(cuts[r + 1], std::uint16_t(r));
    store(b, rank_of_row_, packed_.rank_of_row);
    grids_.clear();
    for (const View& view : views) grids_.push_back(view.grid);
    store(b, grids_, packed_.grids);

    const std::size_t parts = (count + packed_at_once - 1) / packed_at_once;
    packed_.places.reset(ranks * parts), packed_.begins.reset(ranks);
    std::uint32_t* const places = packed_.places.data();
    const BandsOfSplat<Bounds> bands{splats.view(), footprints.view().each, packed_.grids.data(), Bounds{},
                                     packed_.rank_of_row.data()};
    b.for_each(parts, CountForBands<Bounds>{bands, count, parts, int(ranks), places});
    const std::uint64_t all = b.exclusive_scan(Span{places, ranks * parts});
    require_fits("splats for all bands", all);
    b.for_each(ranks, PickWords{places, parts, packed_.begins.data()});
    picked_.resize(ranks);
    b.download(Span<const std::uint32_t>{packed_.begins.data(), ranks}, picked_.data());
    for (std::size_t r = 0; r < ranks; ++r) begins_[r] = picked_[r];
    begins_[ranks] = all;
    packed_.ids.reset(std::size_t(all));
    b.for_each(parts, ListForBands<Bounds>{bands, count, parts, places, packed_.ids.data()});
  }

  /// Splats for each rank begin here, in the order of the ranks.
  Span<const std::uint64_t> begins() const { return {begins_.data(), begins_.size()}; }
  std::uint64_t count_for(int rank) const {
    return begins_[std::size_t(rank) + 1] - begins_[std::size_t(rank)];
  }

  /// Takes the memory for `counts[r]` splats from each rank r. Not collective. Throws `CapacityError`.
  void make_room(B& b, const Ranks& ranks, const std::vector<Band>& bands, Span<const std::uint64_t> counts) {
    to_begins_.assign(1, 0);
    for (const std::uint64_t count : counts) to_begins_.push_back(to_begins_.back() + count);
    require_fits("splats of a band", to_begins_.back());
    const auto in = std::size_t(to_begins_.back()), out = std::size_t(begins_.back());
    bool any_views = false;
    for (const Band& band : bands) any_views = any_views || band.views.size() > 1;
    const std::size_t views = bands[std::size_t(ranks.rank())].views.size();
    try {
      if constexpr (requires { joined_.reset(in, views); })
        joined_.reset(in, views);
      else
        joined_.shapes.reset(in), joined_.depths.reset(in), joined_.of_view.reset(views > 1 ? in : 0);
      joined_colours_.each.reset(in), joined_colours_.hidden.reset(1);
      packed_.shapes.reset(out), packed_.depths.reset(out), packed_.colours.reset(out);
      packed_.of_view.reset(any_views ? out : 0);
      const auto stage = [&](auto& both, auto& sent, auto& received) {
        both.packed.reserve(b, sent.span(), direct_), both.joined.reserve(b, received.span(), direct_);
      };
      stage(shapes_, packed_.shapes, joined_.shapes), stage(depths_, packed_.depths, joined_.depths);
      stage(of_view_, packed_.of_view, joined_.of_view);
      stage(colours_, packed_.colours, joined_colours_.each);
    } catch (const std::bad_alloc&) {
      throw std::runtime_error("out of memory for " + std::to_string(in) + " splats of a band and " +
                               std::to_string(out) + " to send");
    }
    joined_.count = in;
    if constexpr (requires { joined_.visible; }) joined_.visible = in;
    if constexpr (requires { joined_.exact; }) joined_.exact = nullptr, joined_.pending = {};
  }

  /// Copies shapes, depths and views to where `send_shapes` finds them.
  void pack_shapes(B& b, const Ranks& ranks, const Splats<B>& splats, const std::vector<Band>& bands) {
    const SplatsView from = splats.view();
    for (std::size_t r = 0; r < bands.size(); ++r) {
      const std::size_t begin = begins_[r], count = begins_[r + 1] - begins_[r];
      if (count == 0) continue;
      const bool own = int(r) == ranks.rank(), views = bands[r].views.size() > 1;
      const std::size_t at = own ? std::size_t(to_begins_[r]) : begin;
      auto& shapes = own ? joined_.shapes : packed_.shapes;
      auto& depths = own ? joined_.depths : packed_.depths;
      auto& of_view = own ? joined_.of_view : packed_.of_view;
      b.for_each(count,
                 PackShapes{from, packed_.ids.data() + begin, bands[r].pieces.front().view,
                            shapes.data() + at, depths.data() + at, views ? of_view.data() + at : nullptr});
    }
    for_others(ranks, begins_, [&](std::size_t begin, std::size_t end) {
      shapes_.packed.to_host(b, begin, end), depths_.packed.to_host(b, begin, end);
      if (packed_.of_view.size() != 0) of_view_.packed.to_host(b, begin, end);
    });
  }
  void send_shapes(Exchange& exchange, const Ranks& ranks, const std::vector<Band>& bands) {
    send(exchange, shapes_), send(exchange, depths_);
    for (int step = 1; step < ranks.size(); ++step) {
      const int to = (ranks.rank() + step) % ranks.size();
      const int from = (ranks.rank() + ranks.size() - step) % ranks.size();
      if (joined_.of_view.size() != 0)
        exchange.receive(from, of_view_.joined.seen() + to_begins_[std::size_t(from)],
                         std::size_t(to_begins_[std::size_t(from) + 1] - to_begins_[std::size_t(from)]) * 2);
      if (bands[std::size_t(to)].views.size() > 1)
        exchange.send(to, of_view_.packed.seen() + begins_[std::size_t(to)], std::size_t(count_for(to)) * 2);
    }
    exchange.begin();
  }
  void shapes_arrived(B& b, const Ranks& ranks) {
    for_others(ranks, to_begins_, [&](std::size_t begin, std::size_t end) {
      shapes_.joined.from_host(b, begin, end), depths_.joined.from_host(b, begin, end);
      if (joined_.of_view.size() != 0) of_view_.joined.from_host(b, begin, end);
    });
  }

  /// The same for colours.
  void pack_colours(B& b, const Ranks& ranks, const ColoursView& colours) {
    const std::size_t own = std::size_t(ranks.rank());
    const auto pack = [&](std::size_t begin, std::size_t end, SplatColour* to) {
      if (begin < end)
        b.for_each(end - begin, PackColours{colours.each.data, packed_.ids.data() + begin, to});
    };
    pack(begins_[own], begins_[own + 1], joined_colours_.each.data() + to_begins_[own]);
    for_others(ranks, begins_, [&](std::size_t begin, std::size_t end) {
      pack(begin, end, packed_.colours.data() + begin);
      colours_.packed.to_host(b, begin, end);
    });
  }
  void send_colours(Exchange& exchange) { send(exchange, colours_), exchange.begin(); }
  void colours_arrived(B& b, const Ranks& ranks) {
    for_others(ranks, to_begins_,
               [&](std::size_t begin, std::size_t end) { colours_.joined.from_host(b, begin, end); });
    b.for_each(1, ClearWord{joined_colours_.hidden.data()});
    b.for_each(joined_.count, NoteHidden{joined_colours_.each.data(), joined_colours_.hidden.data()});
  }

  Splats<B>& joined() { return joined_; }
  ColoursView colours() const {
    return {{joined_colours_.each.data(), joined_.count}, joined_colours_.hidden.data()};
  }

  static auto buffers(auto& self) {
    return std::tie(self.packed_, self.joined_, self.joined_colours_, self.shapes_, self.depths_,
                    self.of_view_, self.colours_);
  }

 private:
  /// An array that is sent and the one that it is received into.
  template <class T>
  struct Both {
    Staging<B, T> packed, joined;
    static auto buffers(auto& self) { return std::tie(self.packed, self.joined); }
  };

  template <class T>
  static void store(B& b, const std::vector<T>& from, typename B::template Buffer<T>& to) {
    to.reset(from.size());
    copy_from_host(b, from.data(), to.data(), from.size() * sizeof(T));
  }
  static void require_fits(const char* what, std::uint64_t count) {
    constexpr std::uint64_t most = std::numeric_limits<std::uint32_t>::max();
    if (count > most) throw CapacityError(what, count, most);
  }
  /// f(begin, end) for what lies before and behind this rank's own part.
  template <class F>
  static void for_others(const Ranks& ranks, const std::vector<std::uint64_t>& begins, const F& f) {
    const std::size_t own = std::size_t(ranks.rank());
    if (begins[own] != 0) f(std::size_t(0), std::size_t(begins[own]));
    if (begins[own + 1] != begins.back()) f(std::size_t(begins[own + 1]), std::size_t(begins.back()));
  }
  template <class T>
  void send(Exchange& exchange, Both<T>& both) {
    exchange.all_to_all(both.packed.seen(), begins(), both.joined.seen(),
                        {to_begins_.data(), to_begins_.size()}, sizeof(T));
  }

  PackedSplats<B> packed_;
  Splats<B> joined_;
  Colours<B> joined_colours_;
  Both<SplatShape> shapes_;
  Both<float> depths_;
  Both<std::uint16_t> of_view_;
  Both<SplatColour> colours_;
  std::vector<std::uint16_t> rank_of_row_;
  std::vector<TileGrid> grids_;
  std::vector<std::uint32_t> picked_;
  std::vector<std::uint64_t> begins_, to_begins_;
  bool direct_ = false;
};

}  // namespace swiftgs
