// SPDX-License-Identifier: Apache-2.0
// clang-format off
// expected raster_without_name: rasterizer: expected .static constexpr std::string_view name
// expected raster_without_kernel: rasterizer: expected a type .Kernel., or a function rasterize
// expected raster_kernel_of_the_shape_alone: rasterizer: expected .Kernel\(const SplatShape&, vec2 first_centre, BlendRules\)
// expected raster_kernel_without_row: rasterizer: expected .void Kernel::start_row\(float y\)
// expected raster_kernel_with_alpha_in_double: rasterizer: expected .Kernel::alpha\(int column\). that returns a float
// clang-format on
#include <swiftgs/swiftgs.hpp>

struct Flat {
#ifndef raster_without_name
  static constexpr std::string_view name = "flat";
#endif
#ifndef raster_without_kernel
  struct Kernel {
#ifdef raster_kernel_of_the_shape_alone
    explicit Kernel(const swiftgs::SplatShape&) {}
#else
    Kernel(const swiftgs::SplatShape&, swiftgs::vec2, swiftgs::BlendRules) {}
#endif
#ifndef raster_kernel_without_row
    void start_row(float) {}
#endif
#ifdef raster_kernel_with_alpha_in_double
    double alpha(int) const { return 0.5; }
#else
    float alpha(int) const { return 0.5f; }
#endif
  };
#endif
};

using Refused = swiftgs::Renderer<swiftgs::Serial, swiftgs::EarlySort, Flat, swiftgs::Ellipse>;
constexpr auto name = Refused::name;
