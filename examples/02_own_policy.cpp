// SPDX-License-Identifier: Apache-2.0

// Policies of your own. A rasterizer that draws every Gaussian as a flat ellipse of one standard deviation,
// as viewers do to show how a scene is built, and bounds that list just the tiles that such an ellipse
// touches. Neither needs to know the backend: both run on any, on Vulkan by the same in GLSL.
#include <cmath>
#include <cstddef>
#include <iostream>
#include <string_view>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/metrics.hpp>
#include <swiftgs/swiftgs.hpp>
#if __has_include(<one_sigma_shaders.hpp>)
#include <flat_ellipses_shaders.hpp>
#include <one_sigma_shaders.hpp>

#include <swiftgs/vulkan.hpp>
#define HAS_SHADERS
#endif

using namespace swiftgs;

/// The base-2 exponent s of a splat at one standard deviation: exp(-1/2) = 2^-s.
constexpr float one_sigma = 0.72134752044448170368f;

/// Raster policy: a name and a kernel, the arithmetic of one splat in one tile. SWIFTGS_HD lets device
/// backends compile it too.
struct FlatEllipses {
  static constexpr std::string_view name = "flat-ellipses";

  class Kernel {
   public:
    /// `first_centre` is the centre of the raster block's first pixel @units{pixels}.
    SWIFTGS_HD Kernel(const SplatShape& shape, vec2 first_centre, BlendRules rules)
        : terms_(shape, first_centre),
          height_(shape.opacity < rules.alpha_max ? shape.opacity : rules.alpha_max),
          first_x_(first_centre.x) {}

    /// Called once a row, with the height of its centres; `alpha` follows for the columns of that row.
    SWIFTGS_HD void start_row(float y) { row_ = terms_.y_term(y); }

    /// What the splat covers of a pixel, from 0, which skips it, to `alpha_max`.
    SWIFTGS_HD float alpha(int column) const {
      const float s = FloatCholesky::exponent(terms_.x_term(first_x_ + float(column)), row_);
      return s > one_sigma ? 0.0f : height_;
    }

   private:
    FloatCholesky terms_;
    float height_, first_x_;
    FloatCholesky::Y row_{};
  };
};
// The concept names the member that is wrong or missing, where the mistake is.
static_assert(RasterPolicy<FlatEllipses>);

/// Bounds policy: the tiles of the ellipse of one standard deviation. An existing policy does the geometry;
/// it is only told of a smaller splat.
struct OneSigma {
  static constexpr std::string_view name = "one-sigma";
  static constexpr bool conservative = false;  // for rasterizers that draw whole Gaussians

  SWIFTGS_HD Ellipse::Tiles tiles(const SplatShape& shape, TileGrid grid) const {
    return Ellipse().tiles(shrunk(shape), grid);
  }

 private:
  SWIFTGS_HD static SplatShape shrunk(const SplatShape& shape) {
    SplatShape small = shape;
    if (shape.cutoff <= one_sigma) return small;
    small.cutoff = one_sigma;
    return small;
  }
};
static_assert(BoundsPolicy<OneSigma>);

#ifdef HAS_SHADERS
template <>
inline constexpr const auto* swiftgs::vulkan::shaders<FlatEllipses> = &flat_ellipses_shaders;
template <>
inline constexpr const auto* swiftgs::vulkan::shaders<OneSigma> = &one_sigma_shaders;
#endif

/// Renders with the policies above on backend `B`; says what it took.
template <class B>
Frame render(const Scene& scene, const Camera& camera) {
  Renderer<B, EarlySort, FlatEllipses, OneSigma> renderer;
  RenderSettings settings;
  settings.count = true;
  const Frame frame = renderer.render(renderer.backend().upload(scene), camera, settings);
  const Statistics statistics = renderer.statistics();
  std::cout << renderer.name << ": " << statistics.intersections << " intersections, "
            << statistics.raster.contributing_pairs << " contributions\n";
  return frame;
}

int main() {
  const Scene scene = make_builtin_scene(20'000);
  const Camera camera = builtin_camera(320, 180);
  const Frame serial = render<Serial>(scene, camera), cpu = render<Cpu>(scene, camera);

  // The backends project with different instructions, so a pixel on the rim of an ellipse may fall on either
  // side of it; the images agree otherwise.
  const double psnr_db = psnr(serial.colour, cpu.colour);
  std::cout << "serial and cpu agree within " << psnr_db << " dB\n";
#ifdef HAS_SHADERS
  if (Vulkan::usable()) {
    const double on_gpu_db = psnr(serial.colour, render<Vulkan>(scene, camera).colour);
    std::cout << "serial and vulkan agree within " << on_gpu_db << " dB\n";
    if (!(on_gpu_db > 50)) return 1;
  }
#endif
  return psnr_db > 50 ? 0 : 1;
}
