// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <new>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <swiftgs/api.hpp>
#include <swiftgs/colours.hpp>
#include <swiftgs/mpi/ranks.hpp>
#include <swiftgs/mpi/shares.hpp>
#include <swiftgs/mpi/staging.hpp>
#include <swiftgs/mpi/strips.hpp>
#include <swiftgs/shade_stage.hpp>
#include <swiftgs/splats.hpp>
#include <swiftgs/type_list.hpp>

namespace swiftgs {

/// Copies the splats that a rank sends to itself.
struct SWIFTGS_API KeepShapes {
  const SplatShape* shapes;
  const float* depths;
  const std::uint16_t* of_view;  ///< null if the strip shows one view
  SplatShape* to_shapes;
  float* to_depths;
  std::uint16_t* to_of_view;

  SWIFTGS_HD void operator()(std::size_t i) const {
    to_shapes[i] = shapes[i], to_depths[i] = depths[i];
    if (of_view) to_of_view[i] = of_view[i];
  }
};

/// Counts views from the first of a strip on.
struct SWIFTGS_API CountViewsFrom {
  std::uint16_t first;
  std::uint16_t* of_view;
  SWIFTGS_HD void operator()(std::size_t i) const { of_view[i] = std::uint16_t(of_view[i] - first); }
};

/// Joins a rank's own colours to those that have arrived, and notes whether a splat is hidden.
struct SWIFTGS_API JoinColours {
  Span<const SplatColour> own;
  std::size_t at;  ///< where they are joined
  SplatColour* joined;
  std::uint32_t* hidden;

  SWIFTGS_HD void operator()(std::size_t i) const {
    if (i >= at && i - at < own.size) joined[i] = own[i - at];
    if (!is_hidden(joined[i])) return;
#if defined(__CUDA_ARCH__)
    *hidden = 1;
#else
    std::atomic_ref<std::uint32_t>(*hidden).store(1, std::memory_order_relaxed);
#endif
  }
};

/// The loops of an exchange: a device's compiler must see them.
using ExchangeLoops = TypeList<KeepShapes, CountViewsFrom, JoinColours, ClearWord>;

/// Brings each rank the splats that its strip may show, rank after rank. Parts of a scene follow its order,
/// so splats of a view are in the order of their Gaussians, and equal depths sort as in one process.
template <class B>
class SplatExchange {
 public:
  /// Whether messages go by a `DirectLink`.
  void set_direct(bool direct) { direct_ = direct; }

  /// Takes the memory for `counts[r]` splats from each rank r, to join them to what this rank keeps of its
  /// `shares`, and that for the `colours` of the shares. Not collective. Throws `CapacityError`.
  void prepare_strips(B& b, const Ranks& ranks, const std::vector<Strip>& strips, Shares<B>& shares,
                      Colours<B>& colours, Span<const std::uint64_t> counts) {
    own_ = std::size_t(ranks.rank());
    from_ = {shares.begins.data(), shares.begins.size()};
    to_begins_.assign(1, 0);
    for (const std::uint64_t count : counts) to_begins_.push_back(to_begins_.back() + count);
    require_indices("splats of a strip", to_begins_.back());
    const auto in = std::size_t(to_begins_.back()), out = std::size_t(from_[from_.size - 1]);
    const std::size_t views = strips[own_].views.size();
    has_views_ = shares.splats.of_view.size() != 0;
    try {
      joined_.reset(in, views);
      joined_colours_.each.reset(in), joined_colours_.hidden.reset(1);
      colours.each.reset(out), colours.hidden.reset(1);
      const auto stage = [&](auto& both, auto& sent, auto& received) {
        both.packed.reserve(b, {sent.data(), sent.size() == 0 ? 0 : out}, direct_);
        both.joined.reserve(b, received.span(), direct_);
      };
      stage(shapes_, shares.splats.shapes, joined_.shapes);
      stage(depths_, shares.splats.depths, joined_.depths);
      stage(of_view_, shares.splats.of_view, joined_.of_view);
      stage(colours_, colours.each, joined_colours_.each);
    } catch (const std::bad_alloc&) {
      throw std::runtime_error("out of memory for " + std::to_string(in) + " splats of a strip and " +
                               std::to_string(out) + " to send");
    }
    joined_.set_count(in);
  }

  /// Copies the shapes, depths and views of other ranks to where `send_shapes` finds them.
  void stage_shapes(B& b) {
    for_others(from_, [&](std::size_t first, std::size_t last) {
      shapes_.packed.to_host(b, first, last), depths_.packed.to_host(b, first, last);
      if (has_views_) of_view_.packed.to_host(b, first, last);
    });
  }
  void send_shapes(Exchange& exchange, const std::vector<Strip>& strips) {
    send(exchange, shapes_), send(exchange, depths_);
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
  /// Copies those that this rank keeps to where they are joined.
  void keep_shapes(B& b, const SplatsView& shares) {
    const std::size_t begin = from_[own_], count = from_[own_ + 1] - begin, at = to_begins_[own_];
    const bool views = joined_.of_view.size() != 0;
    if (count != 0)
      b.for_each(count,
                 KeepShapes{shares.shapes.data + begin, shares.depths.data + begin,
                            views ? shares.of_view + begin : nullptr, joined_.shapes.data() + at,
                            joined_.depths.data() + at, views ? joined_.of_view.data() + at : nullptr});
  }
  /// After the messages, and after `keep_shapes`.
  void shapes_arrived(B& b, const Strip& strip) {
    for_others(to_begins(), [&](std::size_t begin, std::size_t end) {
      shapes_.joined.from_host(b, begin, end), depths_.joined.from_host(b, begin, end);
      if (joined_.of_view.size() != 0) of_view_.joined.from_host(b, begin, end);
    });
    if (joined_.of_view.size() != 0 && strip.first_view != 0)
      b.for_each(joined_.count, CountViewsFrom{std::uint16_t(strip.first_view), joined_.of_view.data()});
  }

  /// The same for colours, which are kept when all are there. A link begins with them when the caller says
  /// so.
  void stage_colours(B& b) {
    for_others(from_, [&](std::size_t first, std::size_t last) { colours_.packed.to_host(b, first, last); });
  }
  void send_colours(Exchange& exchange) { send(exchange, colours_); }
  void colours_arrived(B& b, const Colours<B>& colours) {
    for_others(to_begins(),
               [&](std::size_t begin, std::size_t end) { colours_.joined.from_host(b, begin, end); });
    const std::size_t begin = from_[own_], count = from_[own_ + 1] - begin;
    b.for_each(1, ClearWord{joined_colours_.hidden.data()});
    b.for_each(joined_colours_.each.size(), JoinColours{{colours.each.data() + begin, count},
                                                        std::size_t(to_begins_[own_]),
                                                        joined_colours_.each.data(),
                                                        joined_colours_.hidden.data()});
  }

  Splats<B>& joined() { return joined_; }
  ColoursView colours() const { return {joined_colours_.each.span(), joined_colours_.hidden.data()}; }

  static auto buffers(auto& self) {
    return std::tie(self.joined_, self.joined_colours_, self.shapes_, self.depths_, self.of_view_,
                    self.colours_);
  }

 private:
  /// An array that is sent and the one that it is received into.
  template <class T>
  struct Both {
    Staging<B, T> packed, joined;
    static auto buffers(auto& self) { return std::tie(self.packed, self.joined); }
  };

  Span<const std::uint64_t> to_begins() const { return {to_begins_.data(), to_begins_.size()}; }

  /// f(begin, end) for what lies before and behind this rank's own part.
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
  Both<SplatShape> shapes_;
  Both<float> depths_;
  Both<std::uint16_t> of_view_;
  Both<SplatColour> colours_;
  std::size_t own_ = 0;                      ///< this rank
  Span<const std::uint64_t> from_{};         ///< `Shares::begins`
  std::vector<std::uint64_t> to_begins_;     ///< of what each rank sends, where it is joined
  bool direct_ = false, has_views_ = false;  ///< whether the frame has several views
};

}  // namespace swiftgs
