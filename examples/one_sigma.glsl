// SPDX-License-Identifier: Apache-2.0

// `OneSigma` for the backend Vulkan.
Shape own_ellipse(Shape shape) {
  shape.cutoff = min(shape.cutoff, 0.72134752);
  return shape;
}
SplatTiles own_tiles(Shape s, TileGrid grid) { return tiles_of(ellipse, own_ellipse(s), grid); }
TileRun own_row(SplatTiles t, Shape s, TileGrid grid, int row) {
  return tiles_of_row(ellipse, t, own_ellipse(s), grid, row);
}
