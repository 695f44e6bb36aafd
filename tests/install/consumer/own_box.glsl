// SPDX-License-Identifier: Apache-2.0

// `OwnBox` of main.cpp.
SplatTiles own_tiles(Shape s, TileGrid grid) { return tiles_of(opacity_box, s, grid); }
TileRun own_row(SplatTiles t, Shape s, TileGrid grid, int row) { return t.columns; }
