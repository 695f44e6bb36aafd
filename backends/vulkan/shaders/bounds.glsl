// SPDX-License-Identifier: Apache-2.0

// Which tiles a splat may touch, as swiftgs/bounds has it. Each operation is `precise`: kernels that count tiles and
// those that emit them agree. tests/vulkan compiles this file as C++.

// The order of `AllBounds`.
const uint three_sigma_square = 0u, opacity_box = 1u, obb = 2u, ellipse = 3u;

// The layout of `TileGrid`.
struct TileGrid {
  int first_column, end_column, first_row, end_row, side;
  uint first, stride;
};

// Half-open.
struct TileRun {
  int begin, end;
};
FUNCTION TileRun tile_run(int begin, int end) {
  TileRun run;
  run.begin = begin;
  run.end = end;
  return run;
}
FUNCTION bool is_one(TileRun run) { return uint(run.end) - uint(run.begin) == 1u; }
FUNCTION int run_size(TileRun run) { return run.end > run.begin ? run.end - run.begin : 0; }

FUNCTION uint tile_number(TileGrid grid, int column, int row) {
  return grid.first + uint(row - grid.first_row) * grid.stride + uint(column - grid.first_column);
}

// The tiles from `begin` to `end`. Both are rounded down, and limited to what an integer holds.
FUNCTION TileRun whole_tiles(float begin, float end) {
  const float most = 1073741824.0f;
  return tile_run(int(floor(max(min(begin, most), -most))), int(floor(max(min(end, most), -most))));
}

FUNCTION TileRun run_within(TileRun run, int begin, int end) {
  return tile_run(max(min(run.begin, end), begin), max(min(run.end, end), begin));
}

FUNCTION float inverse_of(int side) { return uintBitsToFloat(0x7f000000u - floatBitsToUint(float(side))); }

// Tiles that hold a pixel centre in [low, high]. They may lie outside of the image.
FUNCTION TileRun tiles_between(float low, float high, int side) {
  PRECISE float from = low - 0.5f;
  PRECISE float to = high - 0.5f;
  float first = ceil(from), last = floor(to), inverse_side = inverse_of(side);
  if (!(first <= last && last >= 0.0f)) return tile_run(0, 0);
  PRECISE float first_tile = first * inverse_side;
  PRECISE float last_tile = last * inverse_side;
  PRECISE float end_tile = last_tile + 1.0f;
  return whole_tiles(first_tile, end_tile);
}

// Tiles whose span from first to last pixel centre meets [low, high].
FUNCTION TileRun tiles_meeting(float low, float high, int side) {
  float inverse_side = inverse_of(side);
  PRECISE float from = low - (float(side) - 0.5f);
  PRECISE float to = high - 0.5f;
  PRECISE float first_tile = from * inverse_side;
  PRECISE float last_tile = to * inverse_side;
  PRECISE float end_tile = floor(last_tile) + 1.0f;
  return whole_tiles(ceil(first_tile), end_tile);
}

// Points whose distance along a unit normal is at most `half_length`, on either side of the mean.
struct Slab {
  float half_length, tilt, inverse_x;
};

// What rows of tiles need, and the box of tiles.
struct SplatTiles {
  TileRun columns, rows;
  bool full;  // each row has all columns
  float mean_x, mean_y, slack, height;
  float inverse_l0, steepest;   // of ellipses
  Slab across, with_axis;       // of oriented boxes
  float corner, top;
};

// The box of these tiles within a grid.
FUNCTION SplatTiles box_within(TileRun columns, TileRun rows, TileGrid grid) {
  SplatTiles t;
  t.columns = run_within(columns, grid.first_column, grid.end_column);
  t.rows = run_within(rows, grid.first_row, grid.end_row);
  t.full = false;
  return t;
}

FUNCTION Slab slab_of(Shape s, float x, float y) {
  PRECISE float u = x / s.l0;
  PRECISE float l1u = s.l1 * u;
  PRECISE float below = y - l1u;
  PRECISE float v = below / s.l2;
  PRECISE float uu = u * u;
  PRECISE float vv = v * v;
  PRECISE float squared = uu + vv;
  PRECISE float half_length = sqrt(s.cutoff) * sqrt(squared);
  Slab slab;
  slab.half_length = half_length;
  slab.tilt = x < 0.0f ? -y : y;
  slab.inverse_x = 0.0f;
  PRECISE float inverse_x = 1.0f / abs(x);
  if (abs(x) > 0.01f) slab.inverse_x = inverse_x;
  return slab;
}

// Unit vector along the shorter axis of the ellipse.
FUNCTION vec2 short_axis(Shape s) {
  float largest = max(max(s.l0, abs(s.l1)), s.l2);
  PRECISE float l0 = s.l0 / largest;
  PRECISE float l1 = s.l1 / largest;
  PRECISE float l2 = s.l2 / largest;
  PRECISE float a = l0 * l0;
  PRECISE float b = l1 * l1;
  PRECISE float c = l2 * l2;
  PRECISE float bc = b + c;
  PRECISE float level = a - bc;
  PRECISE float l01 = l0 * l1;
  PRECISE float mixed = 2.0f * l01;
  PRECISE float level_squared = level * level;
  PRECISE float mixed_squared = mixed * mixed;
  PRECISE float squared = level_squared + mixed_squared;
  PRECISE float length = sqrt(squared);
  if (!(length > 0.0f)) return vec2(1.0f, 0.0f);
  PRECISE float cosine = abs(level) / length;
  PRECISE float half_cosine = 0.5f * cosine;
  PRECISE float larger_squared = 0.5f + half_cosine;
  PRECISE float larger = sqrt(larger_squared);
  PRECISE float twice = 2.0f * length;
  PRECISE float below = twice * larger;
  PRECISE float smaller = mixed / below;
  return level >= 0.0f ? vec2(larger, smaller) : vec2(abs(smaller), mixed < 0.0f ? -larger : larger);
}

FUNCTION SplatTiles three_sigma_tiles(Shape s, TileGrid grid) {
  const float k = 0.72134752f;
  PRECISE float slope = s.l1 / s.l2;
  PRECISE float l2l2 = s.l2 * s.l2;
  PRECISE float var_y = k / l2l2;
  PRECISE float slope_squared = slope * slope;
  PRECISE float tilted = 1.0f + slope_squared;
  PRECISE float above = k * tilted;
  PRECISE float l0l0 = s.l0 * s.l0;
  PRECISE float var_x = above / l0l0;
  PRECISE float sum = var_x + var_y;
  PRECISE float mid = 0.5f * sum;
  PRECISE float l0l2 = s.l0 * s.l2;
  PRECISE float root_det = k / l0l2;
  PRECISE float less = mid - root_det;
  PRECISE float more = mid + root_det;
  PRECISE float gap = less * more;
  PRECISE float spread = sqrt(gap > 0.1f ? gap : 0.1f);
  PRECISE float larger = mid + spread;
  PRECISE float three_sigma = 3.0f * sqrt(larger);
  float radius = ceil(three_sigma), inverse_side = inverse_of(grid.side);
  PRECISE float x = s.mean.x - 0.5f;
  PRECISE float y = s.mean.y - 0.5f;
  float rest = float(grid.side - 1);
  PRECISE float left = x - radius;
  PRECISE float right = x + radius;
  PRECISE float right_end = right + rest;
  PRECISE float top = y - radius;
  PRECISE float bottom = y + radius;
  PRECISE float bottom_end = bottom + rest;
  return box_within(whole_tiles(left * inverse_side, right_end * inverse_side),
                    whole_tiles(top * inverse_side, bottom_end * inverse_side), grid);
}

FUNCTION SplatTiles tiles_of(uint bounds, Shape s, TileGrid grid) {
  if (bounds == three_sigma_square) return three_sigma_tiles(s, grid);
  PRECISE float inverse_l0 = 1.0f / s.l0;
  PRECISE float inverse_l2 = 1.0f / s.l2;
  PRECISE float radius = sqrt(s.cutoff);
  PRECISE float height = radius * inverse_l2;
  PRECISE float l1_l0 = s.l1 * inverse_l0;
  PRECISE float tilt = l1_l0 * inverse_l2;
  PRECISE float straight_squared = inverse_l0 * inverse_l0;
  PRECISE float tilt_squared = tilt * tilt;
  PRECISE float width_squared = straight_squared + tilt_squared;
  PRECISE float width = radius * sqrt(width_squared);
  PRECISE float both = width + height;
  PRECISE float part = 1e-4f * both;
  PRECISE float slack = 1e-2f + part;
  PRECISE float x = width + slack;
  PRECISE float y = height + slack;
  PRECISE float left = s.mean.x - x;
  PRECISE float right = s.mean.x + x;
  PRECISE float up = s.mean.y - y;
  PRECISE float down = s.mean.y + y;
  TileRun columns = tiles_meeting(left, right, grid.side), rows = tiles_between(up, down, grid.side);
  SplatTiles t = box_within(columns, rows, grid);
  t.full = is_one(columns) || is_one(rows);
  t.mean_x = s.mean.x;
  t.mean_y = s.mean.y;
  t.slack = slack;
  t.height = height;
  t.inverse_l0 = inverse_l0;
  PRECISE float slope = s.l1 * inverse_l2;
  PRECISE float slope_squared = slope * slope;
  PRECISE float length_squared = 1.0f + slope_squared;
  PRECISE float steep = height * slope;
  PRECISE float level = 1.0f / sqrt(length_squared);
  PRECISE float steepest = steep * level;
  t.steepest = steepest;
  if (bounds == obb) {
    vec2 axis = short_axis(s);
    t.across = slab_of(s, axis.x, axis.y);
    t.with_axis = slab_of(s, -axis.y, axis.x);
    PRECISE float first = t.across.half_length * t.across.tilt;
    PRECISE float second = t.with_axis.half_length * t.with_axis.tilt;
    PRECISE float corner = first + second;
    PRECISE float top = abs(first) + abs(second);
    t.corner = corner;
    t.top = top;
  }
  return t;
}

FUNCTION float limited(float y, float least, float most) { return y < least ? least : y > most ? most : y; }

// x = (u - l1 y) / l0 with u^2 + (l2 y)^2 = cutoff.
FUNCTION float edge_of_ellipse(Shape s, float inverse_l0, float y, float sign) {
  PRECISE float v = s.l2 * y;
  PRECISE float v_squared = v * v;
  PRECISE float rest = s.cutoff - v_squared;
  PRECISE float l1y = s.l1 * y;
  PRECISE float u = sign * sqrt(rest > 0.0f ? rest : 0.0f);
  PRECISE float above = u - l1y;
  PRECISE float x = above * inverse_l0;
  return x;
}

FUNCTION float limit_of_slab(Slab slab, float y) {
  PRECISE float tilted = slab.tilt * y;
  PRECISE float above = slab.half_length - tilted;
  PRECISE float x = above * slab.inverse_x;
  return x;
}

// Largest x of an oriented box from `top` to `bottom`, all from the mean.
FUNCTION float right_of_box(SplatTiles t, float top, float bottom) {
  float y = limited(limited(t.corner, top, bottom), -t.top, t.top), x = 3.402823e38f;
  if (t.across.inverse_x > 0.0f) x = limit_of_slab(t.across, y);
  if (t.with_axis.inverse_x > 0.0f) x = min(x, limit_of_slab(t.with_axis, y));
  return x;
}

// The run of tiles in one row of the box.
FUNCTION TileRun tiles_of_row(uint bounds, SplatTiles t, Shape s, TileGrid grid, int row) {
  if (bounds == three_sigma_square || bounds == opacity_box || t.full) return t.columns;
  PRECISE float centre = float(row * grid.side) + 0.5f;
  PRECISE float from_mean = centre - t.mean_y;
  PRECISE float top = from_mean - t.slack;
  PRECISE float lowest = top + float(grid.side - 1);
  PRECISE float bottom = lowest + 2.0f * t.slack;
  float x, left_x;
  if (bounds == obb) {
    x = right_of_box(t, top, bottom);
    left_x = -right_of_box(t, -bottom, -top);
  } else {
    float right_y = limited(limited(-t.steepest, top, bottom), -t.height, t.height);
    float left_y = limited(limited(t.steepest, top, bottom), -t.height, t.height);
    x = edge_of_ellipse(s, t.inverse_l0, right_y, 1.0f);
    left_x = edge_of_ellipse(s, t.inverse_l0, left_y, -1.0f);
  }
  PRECISE float right_end = t.mean_x + x;
  PRECISE float right = right_end + t.slack;
  PRECISE float left_end = t.mean_x + left_x;
  PRECISE float left = left_end - t.slack;
  return run_within(tiles_meeting(left, right, grid.side), t.columns.begin, t.columns.end);
}

// Bounds of a program's own in place of all above, held to the grid and the box.
#ifdef OWN_BOUNDS
#include "policy.glsl"
SplatTiles own_tiles_within(Shape s, TileGrid grid) {
  SplatTiles t = own_tiles(s, grid);
  t.columns = run_within(t.columns, grid.first_column, grid.end_column);
  t.rows = run_within(t.rows, grid.first_row, grid.end_row);
  return t;
}
TileRun own_row_within(SplatTiles t, Shape s, TileGrid grid, int row) {
  return t.full ? t.columns : run_within(own_row(t, s, grid, row), t.columns.begin, t.columns.end);
}
#define tiles_of(bounds, s, grid) own_tiles_within(s, grid)
#define tiles_of_row(bounds, t, s, grid, row) own_row_within(t, s, grid, row)
#endif

// The layout of `Footprint`: the lower and upper half of its mask, the number of tiles, the first tile.
FUNCTION uvec4 footprint_of(uint bounds, Shape s, TileGrid grid) {
  SplatTiles t = tiles_of(bounds, s, grid);
  uvec4 footprint = uvec4(0u, 0u, 0u, 0u);
  if (run_size(t.columns) == 0 || run_size(t.rows) == 0) return footprint;
  footprint.w = tile_number(grid, t.columns.begin, t.rows.begin);
  bool fits = run_size(t.columns) <= 8 && run_size(t.rows) <= 8;
  for (int row = t.rows.begin; row < t.rows.end; ++row) {
    TileRun run = tiles_of_row(bounds, t, s, grid, row);
    footprint.z += uint(run_size(run));
    if (!fits || run_size(run) == 0) continue;
    int r = row - t.rows.begin;
    uint bits = ((1u << uint(run_size(run))) - 1u) << uint(8 * (r & 3) + run.begin - t.columns.begin);
    if (r < 4) footprint.x |= bits;
    else footprint.y |= bits;
  }
  return footprint;
}
