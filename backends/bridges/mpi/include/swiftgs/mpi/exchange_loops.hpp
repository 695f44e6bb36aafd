// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What backends do for an exchange of splats between ranks, beside the messages.

#include <atomic>
#include <cstddef>
#include <cstdint>

#include <swiftgs/frame/api.hpp>
#include <swiftgs/frame/splats.hpp>
#include <swiftgs/functor/shade_stage.hpp>
#include <swiftgs/plane/attributes.hpp>
#include <swiftgs/tools/policy_lists.hpp>

namespace swiftgs {

/// Turns indices of Gaussians in a rank's part into those in the whole scene.
struct SWIFTGS_API NumberGaussians {
  const std::uint32_t* gaussians;
  std::uint32_t before;  ///< Gaussians of lower ranks
  std::uint32_t* to;
  SWIFTGS_HD void operator()(std::size_t i) const { to[i] = before + gaussians[i]; }
};

/// Copies the splats that a rank sends to itself.
struct SWIFTGS_API KeepShapes {
  const SplatShape* shapes;
  const float* depths;
  const std::uint32_t* gaussians;  ///< null if no view asks for indices
  const std::uint16_t* of_view;    ///< null if the strip shows one view
  SplatShape* to_shapes;
  float* to_depths;
  std::uint32_t* to_gaussians;
  std::uint16_t* to_of_view;

  SWIFTGS_HD void operator()(std::size_t i) const {
    to_shapes[i] = shapes[i], to_depths[i] = depths[i];
    if (gaussians) to_gaussians[i] = gaussians[i];
    if (of_view) to_of_view[i] = of_view[i];
  }
};

/// Counts views from the first of a strip on.
struct SWIFTGS_API CountViewsFrom {
  std::uint16_t first;
  std::uint16_t* of_view;
  SWIFTGS_HD void operator()(std::size_t i) const { of_view[i] = std::uint16_t(of_view[i] - first); }
};

/// Joins a rank's own colours to the colours that have arrived, and notes whether a colour is not finite.
struct SWIFTGS_API JoinColours {
  Span<const SplatColour> own;
  std::size_t at;  ///< where they are joined
  SplatColour* joined;
  std::uint32_t* colourless;

  SWIFTGS_HD void operator()(std::size_t i) const {
    if (i >= at && i - at < own.size) joined[i] = own[i - at];
    if (!is_colourless(joined[i])) return;
#if defined(__CUDA_ARCH__)
    *colourless = 1;
#else
    std::atomic_ref<std::uint32_t>(*colourless).store(1, std::memory_order_relaxed);
#endif
  }
};

/// Joins a rank's own attributes to the attributes that have arrived.
struct SWIFTGS_API JoinAttributes {
  AttributesView own;  ///< from the rank's own splats on
  std::size_t count;   ///< of the rank's own splats
  std::size_t at;      ///< where they are joined
  AttributeRow* joined;
  AttributeRow* first_row;  ///< where the first row is kept beside; null: nowhere

  SWIFTGS_HD void operator()(std::size_t i) const {
    if (i >= at && i - at < count)
      for (unsigned r = 0; r < own.rows; ++r) joined[i * own.rows + r] = own.row(r, i - at);
    if (first_row) first_row[i] = joined[i * own.rows];
  }
};

/// The loops of an exchange: a device's compiler must see them.
using ExchangeLoops =
    TypeList<NumberGaussians, KeepShapes, CountViewsFrom, JoinColours, JoinAttributes, ClearWord>;

}  // namespace swiftgs
