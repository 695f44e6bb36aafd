// SPDX-License-Identifier: Apache-2.0

// Which chunks a view cannot show, as swiftgs/project/chunks.hpp has it, in floats with wider margins. tests/vulkan
// compiles this file as C++.

// The layout of `ChunkBounds`.
struct Chunk {
  vec3 low;
  float size;
  vec3 high;
  float opacity;
};

// Half width and height of a splat of one standard deviation at depth 1, and the blur. In pixels.
struct Culler {
  float wide, high, blur;
};

struct ChunkBox {
  float centre[3], extent[3];
  float rounding;
};

// The largest of `x`, `y` and `z` times the camera's axes over a box.
FUNCTION float most(Eye eye, ChunkBox box, float x, float y, float z) {
  float sum = (abs(x) + abs(y) + abs(z)) * box.rounding;
  for (int k = 0; k < 3; ++k) {
    float row = x * eye.rotation[k].high + y * eye.rotation[3 + k].high + z * eye.rotation[6 + k].high;
    sum = sum + row * box.centre[k] + abs(row) * box.extent[k];
  }
  return sum;
}

// As `ChunkCuller::culled_by_distance`.
FUNCTION bool culled_by_distance(Eye eye, ChunkBox box) {
  float nearest = 0.0f, furthest = 0.0f;
  for (int k = 0; k < 3; ++k) {
    float to = abs(box.centre[k]), extent = box.extent[k] + box.rounding, near = max(to - extent, 0.0f);
    nearest = nearest + near * near;
    furthest = furthest + (to + extent) * (to + extent);
  }
  return 1.003f * eye.depth_scale.high * sqrt(furthest) <= eye.near_plane ||
         0.997f * eye.depth_scale.high * sqrt(nearest) > eye.far_plane;
}

// As `ChunkCuller::culled_through_lens`; a splat reaches `k` deviations.
FUNCTION bool culled_through_lens(uint lens, Eye eye, ChunkBox box, float k, float size, float blur) {
  CameraBox of;
  for (int row = 0; row < 3; ++row) {
    of.centre[row] = 0.0f;
    of.extent[row] = box.rounding;
    for (int i = 0; i < 3; ++i) {
      float axis = eye.rotation[3 * row + i].high;
      of.centre[row] = of.centre[row] + axis * box.centre[i];
      of.extent[row] = of.extent[row] + abs(axis) * box.extent[i];
    }
  }
  LensBox seen = box_through(lens, eye, of);
  if (!seen.inside) return true;
  if (!seen.bounded) return false;
  float cx = eye.cx.high, cy = eye.cy.high, fx = eye.fx.high, fy = eye.fy.high, across = fx * seen.u, down = fy * seen.v;
  float wide = 1.003f * k * size * fx * seen.du, high = 1.003f * k * size * fy * seen.dv;
  float margin = 0.03f + k * blur + 5e-4f * (wide + high);
  float reach_x = 1.002f * fx * seen.half_u + wide + margin + 4e-6f * abs(across) + 1e-6f * abs(cx);
  float reach_y = 1.002f * fy * seen.half_v + high + margin + 4e-6f * abs(down) + 1e-6f * abs(cy);
  float y = down + cy;
  if (y + reach_y < eye.top || y - reach_y > eye.bottom) return true;
  float x = nearest_copy(eye, pair(across + cx, 0.0f)).high;
  if (eye.turn.high == 0.0f) return x + reach_x < eye.left || x - reach_x > eye.right;
  // The copy that a Gaussian of the box is shown at may be at the other side of the middle.
  float middle = eye.panorama_middle.high, shown = max(abs(eye.left - middle), abs(eye.right - middle));
  return abs(x - middle) - reach_x > shown;
}

// A number that is NaN culls nothing, where the driver compares NaN as IEEE 754 has it.
FUNCTION bool culls(uint lens, Eye eye, Culler culler, Chunk chunk) {
  float opacity = eye.opacity * chunk.opacity;
  if (opacity < eye.alpha_min) return true;
  ChunkBox box;
  box.rounding = 0.0f;
  for (int k = 0; k < 3; ++k) {
    float low = float_minus(chunk.low[k], eye.centre[k]).high, high = float_minus(chunk.high[k], eye.centre[k]).high;
    // Squares leave the range of float.
    if (lens != pinhole && !(abs(low) < 1e15f && abs(high) < 1e15f)) return false;
    box.centre[k] = 0.5f * (low + high);
    box.extent[k] = 0.5f * (high - low);
    box.rounding = box.rounding + 4e-6f * (abs(low) + abs(high));
  }
  if (eye.depth_is_distance != 0u) {
    if (culled_by_distance(eye, box)) return true;
  } else {
    float furthest = eye.depth_scale.high * most(eye, box, 0.0f, 0.0f, 1.0f);
    if (furthest + 1e-6f * abs(furthest) <= eye.near_plane) return true;
    float nearest = -eye.depth_scale.high * most(eye, box, 0.0f, 0.0f, -1.0f);
    if (nearest - 1e-6f * abs(nearest) > eye.far_plane) return true;
  }
  // sqrt(2 ln(opacity / alpha_min))
  float k = 1.1775f * sqrt(log2(1.0001f * opacity / eye.alpha_min));
  if (lens != pinhole) return culled_through_lens(lens, eye, box, k, chunk.size, culler.blur);
  float cx = eye.cx.high, cy = eye.cy.high, fx = eye.fx.high, fy = eye.fy.high;
  float margin = 0.03f + k * culler.blur, size = 1.0001f * k * chunk.size, x = size * culler.wide, y = size * culler.high;
  float across = margin + 1e-6f * abs(cx), down = margin + 1e-6f * abs(cy);
  return most(eye, box, -fx, 0.0f, eye.right - cx + across) < -x || most(eye, box, fx, 0.0f, cx - eye.left + across) < -x ||
         most(eye, box, 0.0f, -fy, eye.bottom - cy + down) < -y || most(eye, box, 0.0f, fy, cy - eye.top + down) < -y;
}
