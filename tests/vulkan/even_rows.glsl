// SPDX-License-Identifier: Apache-2.0

// `EvenRows` of the tests.
SplatTiles own_tiles(Shape s, TileGrid grid) {
  SplatTiles t = tiles_of(opacity_box, s, grid);
  t.full = false;
  return t;
}
TileRun own_row(SplatTiles t, Shape s, TileGrid grid, int row) { return row % 2 != 0 ? tile_run(0, 0) : t.columns; }
