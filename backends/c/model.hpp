// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <swiftgs/c/scene.h>
#include <swiftgs/c/view.h>
#include <swiftgs/conventions.hpp>

#include "error.hpp"

namespace swiftgs::c {

static_assert(int(SplatOrder::depth) == SWIFTGS_ORDER_DEPTH &&
              int(SplatOrder::distance) == SWIFTGS_ORDER_DISTANCE &&
              int(ColourSpace::srgb) == SWIFTGS_COLOURS_SRGB &&
              int(ColourSpace::linear) == SWIFTGS_COLOURS_LINEAR &&
              int(RenderingModel::Kernel::ellipsoid) == SWIFTGS_KERNEL_ELLIPSOID &&
              int(RenderingModel::Kernel::disk) == SWIFTGS_KERNEL_DISK);

/// Sets the members of a struct that tell of a scene's model.
template <class Struct>
void set_model(Struct& to, const RenderingModel& from) {
  to.antialiased = from.antialiased, to.order = int(from.order), to.colours = int(from.colours);
  to.kernel = int(from.kernel), to.blur = from.blur;
}

/// The same for Gaussians in arrays, where a blur of 0 stands for the usual one and a negative one for none.
inline void set_model(swiftgs_gaussians& to, const RenderingModel& from) {
  set_model<swiftgs_gaussians>(to, from);
  if (from.blur == 0) to.blur = -1;
}

/// The model that `set_model` writes to Gaussians in arrays.
inline RenderingModel model_of(const swiftgs_gaussians& from) {
  require_choice(from.order, 2, "swiftgs_gaussians: order");
  require_choice(from.colours, 2, "swiftgs_gaussians: colours");
  require_choice(from.kernel, 2, "swiftgs_gaussians: kernel");
  RenderingModel model;
  model.antialiased = from.antialiased != 0;
  if (from.blur != 0) model.blur = from.blur < 0 ? 0.0f : from.blur;
  model.order = SplatOrder(from.order), model.colours = ColourSpace(from.colours);
  model.kernel = RenderingModel::Kernel(from.kernel);
  return model;
}

}  // namespace swiftgs::c
