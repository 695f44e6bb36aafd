// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <tuple>

#include <swiftgs/math.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// What a splat contributes, in one 16-byte load.
struct alignas(16) SplatColour {
  vec3 rgb{0};      ///< in the scene's own values, 0 or more
  float depth = 0;  ///< of the splat; 0 if the splat is hidden
};

/// Whether no pixel shows the splat: the colour of its Gaussian is not finite.
SWIFTGS_HD inline bool is_hidden(const SplatColour& colour) { return !(colour.depth > 0); }

/// Colour of a splat at `depth`, cut below at 0. A colour that is not finite hides the splat.
SWIFTGS_HD inline SplatColour splat_colour(vec3 rgb, float depth) {
  const float most = 3.4028234663852886e38f;
  SplatColour colour{vec3(0), depth};
  for (int c = 0; c < 3; ++c) {
    if (!(rgb[c] >= -most && rgb[c] <= most)) return {};
    colour.rgb[c] = rgb[c] > 0 ? rgb[c] : 0.0f;
  }
  return colour;
}

/// Finished colours of a frame's splats. `Shading::finish` gives them; rasterizers take them.
struct ColoursView {
  Span<const SplatColour> each;           ///< @shape{splats}
  const std::uint32_t* hidden = nullptr;  ///< not 0 if a splat is hidden; null: none is

  SWIFTGS_HD bool some_hidden() const { return hidden && *hidden != 0; }
};

/// Colours that `shade` evaluates. A backend specialises this class if its `shade` returns before the colours
/// are evaluated: `finish`, called once, orders later work after the colours and returns them. Without a call
/// of `finish` the destructor orders later work.
template <class B>
class [[nodiscard]] Shading {
 public:
  explicit Shading(const ColoursView& colours) : colours_(colours) {}
  ColoursView finish() { return colours_; }
  /// Stream that evaluates the colours if it is not the backend's own: work that waits for it reads them.
  void* stream() const { return nullptr; }

 private:
  ColoursView colours_;
};

/// Storage of one frame's colours on backend `B`.
template <class B>
struct Colours {
  typename B::template Buffer<SplatColour> each;
  typename B::template Buffer<std::uint32_t> hidden;  ///< one word

  void reserve(B&, const Reservation& reserved) {
    each.reset_exactly(reserved.capacity.splats), hidden.reset_exactly(1);
  }
  static auto buffers(auto& self) { return std::tie(self.each, self.hidden); }
};

}  // namespace swiftgs
