// SPDX-License-Identifier: Apache-2.0

// A plane whose pixels are copied to an image or from it.
layout(push_constant, scalar) uniform Push {
  Plane plane;
  uint width, height, format;
};

RasterView as_view() {
  RasterView view;
  view.colour = plane;
  view.format = format;
  return view;
}
