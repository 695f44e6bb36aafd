// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <vector>

#include <swiftgs/drivers/resident_frames.hpp>
#include <swiftgs/frame.hpp>
#include <swiftgs/mpi/ranks.hpp>
#include <swiftgs/mpi/staging.hpp>
#include <swiftgs/mpi/strips.hpp>

namespace swiftgs {

/// The part of a view that a rank has drawn, in memory of its backend.
struct DrawnStrip {
  ViewStrip view_strip;
  FrameView frame{};
};

/// Memory for the view strips that a rank keeps, float colours with the outputs that were asked for, and
/// their way to rank 0.
template <class B>
class StripFrames {
  static std::size_t count_of(const ViewStrip& view_strip) {
    return std::size_t(view_strip.rows) * std::size_t(view_strip.width);
  }

  /// Where the pixels of a view strip arrive: in the image, or beside it if they are not all of its rows.
  class Landing {
   public:
    /// `image` is a plane of a frame, `pixel` its bytes a pixel.
    Landing(int from, void* image, int width, std::size_t pixel, const ViewStrip& view_strip)
        : from_(from),
          bytes_(pixel * count_of(view_strip)),
          first_(static_cast<std::byte*>(image) +
                 pixel * (std::size_t(view_strip.first_row) * std::size_t(width) +
                          std::size_t(view_strip.first_column))),
          row_(pixel * std::size_t(view_strip.width)),
          pitch_(pixel * std::size_t(width)) {
      if (row_ != pitch_) beside_.resize(bytes_);
    }

    int from() const { return from_; }  ///< rank
    std::size_t bytes() const { return bytes_; }
    void* data() { return beside_.empty() ? first_ : beside_.data(); }
    /// Once all have arrived.
    void settle() {
      for (std::size_t from = 0, to = 0; from < beside_.size(); from += row_, to += pitch_)
        std::copy_n(beside_.data() + from, row_, first_ + to);
    }

   private:
    int from_;
    std::size_t bytes_;
    std::byte* first_;
    std::size_t row_, pitch_;
    std::vector<std::byte> beside_;
  };

 public:
  /// Gives each view strip memory, until the next call.
  void keep(B& b, const Outputs& outputs, std::vector<DrawnStrip>& drawn) {
    std::size_t pixels = 0;
    for (const DrawnStrip& each : drawn) pixels += count_of(each.view_strip);
    outputs_ = outputs;
    planes_.reset(outputs, pixels);
    for_each_plane([&](std::size_t, auto& plane, auto& staged) { staged.reserve(b, plane.span()); }, planes_,
                   to_send_);
    std::size_t before = 0;
    for (DrawnStrip& each : drawn) {
      each.frame = {.width = each.view_strip.width,
                    .height = each.view_strip.rows,
                    .feature_channels = outputs.features};
      planes_.point(each.frame, before);
      before += each.frame.pixels();
    }
  }

  /// Brings what was drawn to the host: to `frames`, which were prepared, on rank 0, and to where `collect`
  /// sends it from on the others.
  void to_host(B& b, const Ranks& ranks, const std::vector<DrawnStrip>& drawn, Span<Frame> frames) {
    if constexpr (!B::reaches_host_memory) {
      if (ranks.rank() == 0) {
        std::size_t before = 0;
        for (const DrawnStrip& each : drawn) {
          const std::size_t pixels = count_of(each.view_strip);
          Frame& frame = frames[each.view_strip.view];
          for_each_plane(
              [&]<class T>(std::size_t channels, const auto& from, std::vector<T>& to) {
                if (to.empty()) return;
                Landing landing(ranks.rank(), to.data(), frame.width, channels * sizeof(T), each.view_strip);
                b.download(Span<const T>{from.data() + channels * before, channels * pixels},
                           static_cast<T*>(landing.data()));
                landing.settle();
              },
              planes_, frame);
          before += pixels;
        }
      } else {
        for_each_plane(
            [&](std::size_t, const auto& from, auto& staged) { staged.to_host(b, 0, from.size()); }, planes_,
            to_send_);
      }
    }
  }

  /// Takes the memory that `collect` needs on rank 0, whose `frames` were prepared.
  void expect(const std::vector<Strip>& strips, Span<Frame> frames) {
    landings_.clear();
    for (std::size_t r = 1; r < strips.size(); ++r)
      for (const ViewStrip& view_strip : strips[r].view_strips) {
        Frame& frame = frames[view_strip.view];
        for_each_plane(
            [&](std::size_t channels, auto& to) {
              if (!to.empty())
                landings_.emplace_back(int(r), to.data(), frame.width, channels * sizeof to[0], view_strip);
            },
            frame);
      }
  }

  /// Sends the view strips of all ranks to the frames that rank 0 expects. Collective.
  void collect(const Ranks& ranks, const std::vector<Strip>& strips) {
    Exchange exchange(ranks);
    if (ranks.rank() == 0) {
      for (Landing& landing : landings_) exchange.receive(landing.from(), landing.data(), landing.bytes());
    } else {
      std::size_t before = 0;
      for (const ViewStrip& view_strip : strips[std::size_t(ranks.rank())].view_strips) {
        const std::size_t pixels = count_of(view_strip);
        for_each_plane(
            [&](std::size_t channels, bool wanted, auto& staged) {
              if (wanted)
                exchange.send(0, staged.seen() + channels * before,
                              channels * pixels * sizeof *staged.seen());
            },
            outputs_, to_send_);
        before += pixels;
      }
    }
    exchange.wait();
    for (Landing& landing : landings_) landing.settle();
    landings_.clear();
  }

  static auto buffers(auto& self) { return std::tie(self.planes_); }

 private:
  Outputs outputs_;  ///< that `planes_` hold
  FramePlanes<B> planes_;
  PerPlane<Staging<B, float>, Staging<B, std::uint32_t>> to_send_;
  std::vector<Landing> landings_;  ///< on rank 0, of what others send
};

}  // namespace swiftgs
