// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <swiftgs/error.hpp>
#include <swiftgs/frame/passes.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/mpi/exchange_loops.hpp>
#include <swiftgs/mpi/offers.hpp>
#include <swiftgs/mpi/ranks.hpp>
#include <swiftgs/mpi/shares.hpp>
#include <swiftgs/mpi/staging.hpp>
#include <swiftgs/mpi/strips.hpp>

namespace swiftgs {

/// Brings each rank the splats that its strip may show, rank after rank. Parts of a scene follow its order,
/// so splats of a view are in the order of their Gaussians, and equal depths sort as in one process.
template <class B>
class SplatExchange {
 public:
  /// `direct`: whether messages go by a `DirectLink`.
  void set_ranks(const Ranks& ranks, bool direct) { own_ = std::size_t(ranks.rank()), direct_ = direct; }

  /// Takes the memory for the splats that each rank offers, to join them to what this rank keeps of its
  /// `shares`, and that for the `colours` of the shares and the attributes of `passes`. Not collective.
  /// Throws `CapacityError`.
  void prepare_strips(B& b, const std::vector<Strip>& strips, Shares<B>& shares, Colours<B>& colours,
                      Span<const Offer> offers, const RasterPasses& passes) {
    passes_ = passes;
    from_ = {shares.begins.data(), shares.begins.size()};
    to_begins_.assign(1, 0);
    std::uint64_t gaussians = 0;
    for (std::size_t r = 0; r < offers.size; ++r) {
      if (r == own_) gaussians_before_ = std::uint32_t(gaussians);
      gaussians += offers[r].gaussians;
      to_begins_.push_back(to_begins_.back() + offers[r].splats);
    }
    require_indices("splats of a strip", to_begins_.back());
    require_indices("Gaussians of all parts", gaussians);
    has_gaussians_ = gaussians != 0;
    const std::size_t in = received(), out = sent();
    const std::size_t views = strips[own_].views.size();
    has_views_ = shares.splats.of_view.size() != 0;
    try {
      joined_.reset(in, views);
      joined_colours_.each.reset(in), joined_colours_.colourless.reset(1);
      colours.each.reset(out), colours.colourless.reset(1);
      if (has_gaussians_) numbered_.reset(out);
      const auto stage = [&](auto& both, auto& packed, auto& joined) {
        both.packed.reserve(b, {packed.data(), packed.size() == 0 ? 0 : out}, direct_);
        both.joined.reserve(b, joined.span(), direct_);
      };
      stage(shapes_, shares.splats.shapes, joined_.shapes);
      stage(depths_, shares.splats.depths, joined_.depths);
      if (has_gaussians_) stage(gaussians_, numbered_, joined_.gaussians);
      stage(of_view_, shares.splats.of_view, joined_.of_view);
      stage(colours_, colours.each, joined_colours_.each);
      const unsigned rows = passes[0].rows;
      attribute_rows_.reset(rows * out);
      joined_attribute_rows_.reset(passes.kept_rows() * in);
      attributes_.packed.reserve(b, attribute_rows_.span(), direct_);
      attributes_.joined.reserve(b, {joined_attribute_rows_.data(), rows * in}, direct_);
    } catch (const std::bad_alloc&) {
      throw detail::ErrorAs<std::runtime_error>(
          ErrorCode::out_of_memory, "out of memory for " + std::to_string(in) + " splats of a strip and " +
                                        std::to_string(out) + " to send");
    }
    joined_.set_count(in);
  }

  /// Copies what other ranks need of the `shares`, colours aside, to where `send_shapes` finds it.
  void stage_shapes(B& b, const SplatsView& shares) {
    if (has_gaussians_)
      b.for_each(numbered_.size(),
                 NumberGaussians{shares.gaussians.data, gaussians_before_, numbered_.data()});
    for_others(from_, [&](std::size_t first, std::size_t last) {
      shapes_.packed.to_host(b, first, last), depths_.packed.to_host(b, first, last);
      if (has_gaussians_) gaussians_.packed.to_host(b, first, last);
      if (has_views_) of_view_.packed.to_host(b, first, last);
    });
  }
  void send_shapes(Exchange& exchange, const std::vector<Strip>& strips) {
    send(exchange, shapes_), send(exchange, depths_);
    if (has_gaussians_) send(exchange, gaussians_);
    const std::size_t ranks = from_.size - 1;
    const auto bytes = [](Span<const std::uint64_t> begins, std::size_t r) {
      return std::size_t(begins[r + 1] - begins[r]) * sizeof(std::uint16_t);
    };
    for (std::size_t step = 1; step < ranks; ++step) {
      const std::size_t to = (own_ + step) % ranks, from = (own_ + ranks - step) % ranks;
      if (joined_.of_view.size() != 0)
        exchange.receive(int(from), of_view_.joined.seen() + to_begins_[from], bytes(to_begins(), from));
      if (strips[to].views.size() > 1)
        exchange.send(int(to), of_view_.packed.seen() + from_[to], bytes(from_, to));
    }
    exchange.begin();
  }
  /// Copies the shapes that this rank keeps to the joined ones.
  void keep_shapes(B& b, const SplatsView& shares) {
    const std::size_t begin = from_[own_], count = from_[own_ + 1] - begin, at = to_begins_[own_];
    const bool views = joined_.of_view.size() != 0;
    if (count != 0)
      b.for_each(count, KeepShapes{shares.shapes.data + begin, shares.depths.data + begin,
                                   has_gaussians_ ? numbered_.data() + begin : nullptr,
                                   views ? shares.of_view + begin : nullptr, joined_.shapes.data() + at,
                                   joined_.depths.data() + at, joined_.gaussians.data() + at,
                                   views ? joined_.of_view.data() + at : nullptr});
  }
  /// After the messages, and after `keep_shapes`.
  void shapes_arrived(B& b, const Strip& strip) {
    for_others(to_begins(), [&](std::size_t begin, std::size_t end) {
      shapes_.joined.from_host(b, begin, end), depths_.joined.from_host(b, begin, end);
      if (has_gaussians_) gaussians_.joined.from_host(b, begin, end);
      if (joined_.of_view.size() != 0) of_view_.joined.from_host(b, begin, end);
    });
    if (joined_.of_view.size() != 0 && strip.first_view != 0)
      b.for_each(joined_.count, CountViewsFrom{std::uint16_t(strip.first_view), joined_.of_view.data()});
  }

  /// Stages colours likewise. They are kept when all have arrived; a link begins with them when the caller
  /// says so.
  void stage_colours(B& b) {
    for_others(from_, [&](std::size_t first, std::size_t last) { colours_.packed.to_host(b, first, last); });
  }
  void send_colours(Exchange& exchange) { send(exchange, colours_); }
  void colours_arrived(B& b, const Colours<B>& colours) {
    for_others(to_begins(),
               [&](std::size_t begin, std::size_t end) { colours_.joined.from_host(b, begin, end); });
    const std::size_t begin = from_[own_], count = from_[own_ + 1] - begin;
    b.for_each(1, ClearWord{joined_colours_.colourless.data()});
    b.for_each(joined_colours_.each.size(), JoinColours{{colours.each.data() + begin, count},
                                                        std::size_t(to_begins_[own_]),
                                                        joined_colours_.each.data(),
                                                        joined_colours_.colourless.data()});
  }

  /// The attributes of the shares in a pass, for the caller to fill. @shape{splats, rows}
  AttributeRow* attribute_rows() { return attribute_rows_.data(); }
  /// The same for them.
  void stage_attributes(B& b, const RasterPass& pass) {
    for_others(from_, [&](std::size_t begin, std::size_t end) {
      attributes_.packed.to_host(b, begin * pass.rows, end * pass.rows);
    });
  }
  void send_attributes(Exchange& exchange, const RasterPass& pass) {
    if (pass.rows != 0)
      exchange.all_to_all(attributes_.packed.seen(), from_, attributes_.joined.seen(), to_begins(),
                          pass.rows * sizeof(AttributeRow));
  }
  AttributesView attributes_arrived(B& b, const RasterPass& pass) {
    if (pass.rows == 0) return {};
    for_others(to_begins(), [&](std::size_t begin, std::size_t end) {
      attributes_.joined.from_host(b, begin * pass.rows, end * pass.rows);
    });
    const std::size_t begin = from_[own_], count = from_[own_ + 1] - begin;
    AttributeRow* const joined = joined_attribute_rows_.data();
    const bool kept = passes_.size() > 1;  // later rows take the place of the first
    AttributeRow* const first_row = kept ? joined + AttributesView::most_rows * received() : joined;
    b.for_each(received(), JoinAttributes{{attribute_rows_.data() + begin * pass.rows, pass.rows, pass.first},
                                          count,
                                          std::size_t(to_begins_[own_]),
                                          joined,
                                          kept && pass.is_base ? first_row : nullptr});
    return {joined, pass.rows, pass.first, first_row, kept ? 1 : pass.rows};
  }

  Splats<B>& joined() { return joined_; }
  ColoursView colours() const { return {joined_colours_.each.span(), joined_colours_.colourless.data()}; }

  static auto buffers(auto& self) {
    return std::tie(self.joined_, self.joined_colours_, self.numbered_, self.shapes_, self.depths_,
                    self.gaussians_, self.of_view_, self.colours_, self.attribute_rows_,
                    self.joined_attribute_rows_, self.attributes_);
  }

 private:
  /// An array that is sent and the one that it is received into.
  template <class T>
  struct Both {
    Staging<B, T> packed, joined;
    static auto buffers(auto& self) { return std::tie(self.packed, self.joined); }
  };

  /// Numbers of splats in the shares and of joined splats.
  std::size_t sent() const { return std::size_t(from_[from_.size - 1]); }
  std::size_t received() const { return std::size_t(to_begins_.back()); }
  Span<const std::uint64_t> to_begins() const { return {to_begins_.data(), to_begins_.size()}; }

  /// Calls f(begin, end) for the parts before and behind this rank's own.
  template <class F>
  void for_others(Span<const std::uint64_t> begins, const F& f) const {
    const std::uint64_t end = begins[begins.size - 1];
    if (begins[own_] != 0) f(std::size_t(0), std::size_t(begins[own_]));
    if (begins[own_ + 1] != end) f(std::size_t(begins[own_ + 1]), std::size_t(end));
  }
  template <class T>
  void send(Exchange& exchange, Both<T>& both) {
    exchange.all_to_all(both.packed.seen(), from_, both.joined.seen(), to_begins(), sizeof(T));
  }

  Splats<B> joined_;
  Colours<B> joined_colours_;
  typename B::template Buffer<std::uint32_t> numbered_;  ///< Gaussians of the shares, in the whole scene
  Both<SplatShape> shapes_;
  Both<float> depths_;
  Both<std::uint32_t> gaussians_;
  Both<std::uint16_t> of_view_;
  Both<SplatColour> colours_;
  typename B::template Buffer<AttributeRow> attribute_rows_,
      joined_attribute_rows_;  ///< @shape{splats, rows}
  Both<AttributeRow> attributes_;
  RasterPasses passes_;                   ///< of the frame
  std::size_t own_ = 0;                   ///< this rank
  std::uint32_t gaussians_before_ = 0;    ///< of lower ranks
  Span<const std::uint64_t> from_{};      ///< `Shares::begins`
  std::vector<std::uint64_t> to_begins_;  ///< of what each rank sends, where it is joined
  bool direct_ = false;
  bool has_views_ = false;      ///< whether the frame has several views
  bool has_gaussians_ = false;  ///< whether the frame asks for their indices
};

}  // namespace swiftgs
