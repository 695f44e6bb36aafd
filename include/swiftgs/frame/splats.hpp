// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/frame/math.hpp>
#include <swiftgs/frame/span.hpp>
#include <swiftgs/frame/tiles.hpp>

namespace swiftgs {

/// What a splat contributes, in one 16-byte load.
struct alignas(16) SplatColour {
  vec3 rgb{0};      ///< in the scene's own values, 0 or more
  float depth = 0;  ///< of the splat; 0 if the splat is colourless
};

/// Whether no pixel shows the splat: the colour of its Gaussian is not finite.
SWIFTGS_HD inline bool is_colourless(const SplatColour& colour) { return !(colour.depth > 0); }

/// Colour of a splat at `depth`, cut below at 0; the splat is colourless if it is not finite.
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
  Span<const SplatColour> each;               ///< @shape{splats}
  const std::uint32_t* colourless = nullptr;  ///< not 0 if a splat is colourless; null: none is

  SWIFTGS_HD bool some_colourless() const { return colourless && *colourless != 0; }
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
  typename B::template Buffer<std::uint32_t> colourless;  ///< one word

  void reserve(B&, const Reservation& reserved) {
    each.reset_exactly(reserved.capacity.splats), colourless.reset_exactly(1);
  }
  static auto buffers(auto& self) { return std::tie(self.each, self.colourless); }
};

/// Where a projected Gaussian is and how far it reaches.
///
/// | mean.x mean.y l0 l1 | l2 opacity cutoff low |      32 bytes, two 16-byte loads
///
/// The precision matrix is kept as its Cholesky factor in base-2 units, because every other representation of
/// it follows without cancellation: at d = pixel - mean the base-2 exponent is s(d) = (l0 dx + l1 dy)^2 + (l2
/// dy)^2, and alpha = opacity 2^-s. A pixel keeps the splat where s <= cutoff = log2(opacity / alpha_min).
///
/// `mean` alone would be off by up to 1e-4 pixels at column 1,500, more than all else that is computed of a
/// splat. `low` holds what rounding it down cuts off, so d is within a unit in its last place.
struct alignas(32) SplatShape {
  vec2 mean{0};           ///< rounded down to float @units{pixels}, the first pixel's centre is (0.5, 0.5)
  float l0 = 0;           ///< > 0 @units{1/pixels}
  float l1 = 0;           ///< @units{1/pixels}
  float l2 = 0;           ///< > 0 @units{1/pixels}
  float opacity = 0;      ///< after anti-aliasing compensation
  float cutoff = 0;       ///< largest s that is kept, 0 or more for a visible splat
  std::uint32_t low = 0;  ///< what `mean` lacks in x; in the upper 16 bits, in y @units{2^-24 pixels}

  /// x less the mean's x. @units{pixels}
  SWIFTGS_HD float right_of_mean(float x) const { return from(mean.x, low, x); }
  /// y less the mean's y. @units{pixels}
  SWIFTGS_HD float below_mean(float y) const { return from(mean.y, low >> 16, y); }
  SWIFTGS_HD vec2 from_mean(vec2 at) const { return vec2(right_of_mean(at.x), below_mean(at.y)); }

  /// Sets the mean: up to column and row 65,536 to 2^-25 pixels, beyond as a float.
  /// `Real` is double, or `FloatPair`.
  template <class Real>
  SWIFTGS_HD void set_mean(const Real& x, const Real& y) {
    low = round_down(x, mean.x), low |= round_down(y, mean.y) << 16;
  }
  /// The mean as it is kept. @units{pixels}
  SWIFTGS_HD Vector2<double> exact_mean() const {
    return {mean.x + double(low_unit) * (low & 0xffff), mean.y + double(low_unit) * (low >> 16)};
  }

  static constexpr float low_unit = 0x1p-24f;

 private:
  /// `at` less the mean whose remainder is the lower half of `low`.
  SWIFTGS_HD static float from(float mean, std::uint32_t low, float at) {
#if defined(__CUDA_ARCH__)
    // The bits 0x4b00 before the remainder make the float 2^23 + remainder: half a pixel more. A conversion
    // would occupy the unit that exponentials need.
    return fmaf(-low_unit, __uint_as_float(__byte_perm(low, 0x4b000000, 0x7610)), (at + 0.5f) - mean);
#else
    return at - mean - low_unit * float(low & 0xffff);
#endif
  }
  /// Sets `mean` to the largest float that is not above x. Returns what it lacks, at most 0xffff.
  template <class Real>
  SWIFTGS_HD static std::uint32_t round_down(const Real& x, float& mean) {
    mean = float(x);
    float lacks = float(x - mean);
    if (lacks < 0) {
      const float below =
          __builtin_bit_cast(float, __builtin_bit_cast(std::int32_t, mean) + (mean > 0 ? -1 : 1));
      lacks += mean - below, mean = below;
    }
    const float units = lacks * (1 / low_unit), most = 0xffff;
    return std::uint32_t(std::rint(!(units <= most) ? most : units));
  }
};

/// Largest variance of a splat, blur included: a Gaussian with a larger one is not drawn. Up to here no
/// product of projection leaves the range of float. @units{pixels^2}
inline constexpr float largest_variance = 1e36f;

/// Visible splats of all views, an element a splat in each array: those of one view in the order of their
/// Gaussians.
struct SplatsView {
  Span<const SplatShape> shapes;
  Span<const float> depths;                ///< what orders them, as `Conventions::order` has it, > 0
  Span<const std::uint32_t> gaussians;     ///< index of each splat's Gaussian in the scene
  const std::uint16_t* of_view = nullptr;  ///< index of each splat's view; null: all are of the first
  const std::uint32_t* exact = nullptr;    ///< as `Count::exact`; null: the arrays hold splats alone

  SWIFTGS_HD std::size_t size() const { return shapes.size; }  ///< at most
  SWIFTGS_HD Count count() const { return {shapes.size, exact}; }
  SWIFTGS_HD std::uint32_t view(std::size_t i) const { return of_view ? of_view[i] : 0; }
};

/// Buffers of one frame's splats on backend `B`, and their number.
template <class B>
struct SplatBuffers {
  typename B::template Buffer<SplatShape> shapes;
  typename B::template Buffer<float> depths;
  typename B::template Buffer<std::uint32_t> gaussians;
  typename B::template Buffer<std::uint16_t> of_view;  ///< empty if there is one view
  std::size_t count = 0;                               ///< at most, if there is `exact`
  const std::uint32_t* exact = nullptr;                ///< as `Count::exact`

  /// Makes room for so many splats by f(buffer, size).
  void make_room(std::size_t splats, std::size_t views, const auto& f) {
    f(shapes, splats), f(depths, splats), f(gaussians, splats), f(of_view, views > 1 ? splats : 0);
  }
  void reset(std::size_t splats, std::size_t views) {
    make_room(splats, views, [](auto& buffer, std::size_t size) { buffer.reset(size); });
  }
  SplatsView view() const {
    const std::uint16_t* const views = of_view.size() != 0 ? of_view.data() : nullptr;
    return {{shapes.data(), count}, {depths.data(), count}, {gaussians.data(), count}, views, exact};
  }
  static auto buffers(auto& self) { return std::tie(self.shapes, self.depths, self.gaussians, self.of_view); }
};

/// Storage of one frame's splats on backend `B`. Backends specialise it.
template <class B>
struct Splats : SplatBuffers<B> {
  std::size_t visible = 0;  ///< more than `count` where the capacity did not suffice

  /// As `reset`, but keeps the splats.
  void resize(std::size_t splats, std::size_t views) {
    this->make_room(splats, views, [](auto& buffer, std::size_t size) { buffer.resize(size); });
  }
  void set_count(std::size_t splats) { this->count = visible = splats; }
  void reserve(B&, const Reservation& reserved) {
    this->make_room(reserved.capacity.splats, reserved.views, [](auto& b, auto n) { b.reset_exactly(n); });
  }
};

/// Key that orders depths as integers: the bits of positive floats ascend with their values.
SWIFTGS_HD inline std::uint32_t depth_key(float depth) { return __builtin_bit_cast(std::uint32_t, depth); }
inline constexpr int depth_key_bits = 31;

}  // namespace swiftgs
