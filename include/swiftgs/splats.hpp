// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <tuple>

#include <swiftgs/count.hpp>
#include <swiftgs/math.hpp>
#include <swiftgs/span.hpp>
#include <swiftgs/tiles.hpp>

namespace swiftgs {

/// Where a projected Gaussian is and how far it reaches.
///
/// | mean.x mean.y l0 l1 | l2 opacity cutoff half_width |      32 bytes, two 16-byte loads
///
/// The precision matrix is kept as its Cholesky factor in base-2 units, because every other representation of
/// it follows without cancellation: at d = pixel - mean the base-2 exponent is s(d) = (l0 dx + l1 dy)^2 + (l2
/// dy)^2, and alpha = opacity 2^-s. A pixel keeps the splat where s <= cutoff = log2(opacity / alpha_min).
struct alignas(32) SplatShape {
  vec2 mean{0};          ///< @units{pixels}, the first pixel's centre is (0.5, 0.5)
  float l0 = 0;          ///< > 0 @units{1/pixels}
  float l1 = 0;          ///< @units{1/pixels}
  float l2 = 0;          ///< > 0 @units{1/pixels}
  float opacity = 0;     ///< after anti-aliasing compensation
  float cutoff = 0;      ///< largest s that is kept, 0 or more for a visible splat
  float half_width = 0;  ///< half the width of the ellipse s = cutoff @units{pixels}
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

/// Storage of one frame's splats on backend `B`.
template <class B>
struct Splats {
  typename B::template Buffer<SplatShape> shapes;
  typename B::template Buffer<float> depths;
  typename B::template Buffer<std::uint32_t> gaussians;
  typename B::template Buffer<std::uint16_t> of_view;  ///< empty if there is one view
  std::size_t count = 0;
  std::size_t visible = 0;  ///< more than `count` where the capacity did not suffice

  /// Makes room for so many splats of so many views, and keeps the splats.
  void resize(std::size_t splats, std::size_t views) {
    shapes.resize(splats), depths.resize(splats), gaussians.resize(splats);
    of_view.resize(views > 1 ? splats : 0);
  }
  /// Makes room as `resize` does, but keeps no splats.
  void reset(std::size_t splats, std::size_t views) {
    shapes.reset(splats), depths.reset(splats), gaussians.reset(splats);
    of_view.reset(views > 1 ? splats : 0);
  }
  void set_count(std::size_t splats) { count = visible = splats; }
  SplatsView view() const {
    return {{shapes.data(), count},
            {depths.data(), count},
            {gaussians.data(), count},
            of_view.size() != 0 ? of_view.data() : nullptr};
  }
  void reserve(B&, const Reservation& reserved) {
    const std::size_t splats = reserved.capacity.splats;
    shapes.reset_exactly(splats), depths.reset_exactly(splats), gaussians.reset_exactly(splats);
    of_view.reset_exactly(reserved.views > 1 ? splats : 0);
  }
  static auto buffers(auto& self) { return std::tie(self.shapes, self.depths, self.gaussians, self.of_view); }
};

/// Key that orders depths as integers: the bits of a positive float ascend with its value, and its sign bit
/// is zero.
SWIFTGS_HD inline std::uint32_t depth_key(float depth) { return __builtin_bit_cast(std::uint32_t, depth); }
inline constexpr int depth_key_bits = 31;

}  // namespace swiftgs
