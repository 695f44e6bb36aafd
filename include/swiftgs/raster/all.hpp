// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/raster/axis_shared.hpp>
#include <swiftgs/raster/per_pixel.hpp>
#include <swiftgs/raster/split.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs {

/// The exponent representations of the library: `AllRasters` has both axis-shared rasterizers of each.
using AllExponents = TypeList<HalfSplit, FloatSplit, FloatCholesky>;

namespace detail {
template <class... Others, class... Exponent>
TypeList<Others..., AxisShared<Exponent>..., AxisSharedThreshold<Exponent>...> with_axis_shared(
    TypeList<Others...>, TypeList<Exponent...>);
}

/// The rasterizers of the library. Every backend and the table of renderers have these.
using AllRasters = decltype(detail::with_axis_shared(TypeList<PerPixel>(), AllExponents()));

}  // namespace swiftgs
