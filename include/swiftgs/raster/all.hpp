// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/raster/per_pixel.hpp>
#include <swiftgs/type_list.hpp>

namespace swiftgs {

/// The rasterizers of the library: every backend, and the table of renderers, has what stands here.
using AllRasters = TypeList<PerPixel, AxisShared<HalfSplit>, AxisShared<FloatSplit>,
                            AxisShared<FloatCholesky>, AxisSharedThreshold<HalfSplit>,
                            AxisSharedThreshold<FloatSplit>, AxisSharedThreshold<FloatCholesky>>;

}  // namespace swiftgs
