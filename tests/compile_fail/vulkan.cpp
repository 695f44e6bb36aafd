// SPDX-License-Identifier: Apache-2.0
// expected vulkan_own_bounds: bounds: expected some of the library's on the backend Vulkan
// expected vulkan_own_raster: rasterizer: expected one of the library's on the backend Vulkan
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/vulkan.hpp>

#ifdef vulkan_own_bounds
struct Bounds : swiftgs::Ellipse {};
#else
using Bounds = swiftgs::Ellipse;
#endif
#ifdef vulkan_own_raster
struct Raster : swiftgs::PerPixel {};
#else
using Raster = swiftgs::PerPixel;
#endif

inline void draw() { swiftgs::Renderer<swiftgs::Vulkan, swiftgs::EarlySort, Raster, Bounds> renderer; }
