// SPDX-License-Identifier: Apache-2.0

// Which chunks a pinhole cannot show, as swiftgs/project/chunks.hpp has it, in floats with wider margins. tests/vulkan
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

// A number that is NaN hides nothing.
FUNCTION bool hides(Eye eye, Culler culler, Chunk chunk) {
  float opacity = eye.opacity * chunk.opacity;
  if (opacity < eye.alpha_min) return true;
  ChunkBox box;
  box.rounding = 0.0f;
  for (int k = 0; k < 3; ++k) {
    float low = float_minus(chunk.low[k], eye.centre[k]).high, high = float_minus(chunk.high[k], eye.centre[k]).high;
    box.centre[k] = 0.5f * (low + high);
    box.extent[k] = 0.5f * (high - low);
    box.rounding = box.rounding + 4e-6f * (abs(low) + abs(high));
  }
  float furthest = eye.depth_scale.high * most(eye, box, 0.0f, 0.0f, 1.0f);
  if (furthest + 1e-6f * abs(furthest) <= eye.near_plane) return true;
  float nearest = -eye.depth_scale.high * most(eye, box, 0.0f, 0.0f, -1.0f);
  if (nearest - 1e-6f * abs(nearest) > eye.far_plane) return true;
  // sqrt(2 ln(opacity / alpha_min))
  float k = 1.1775f * sqrt(log2(1.0001f * opacity / eye.alpha_min));
  float cx = eye.cx.high, cy = eye.cy.high, fx = eye.fx.high, fy = eye.fy.high;
  float margin = 0.03f + k * culler.blur, size = 1.0001f * k * chunk.size, x = size * culler.wide, y = size * culler.high;
  float across = margin + 1e-6f * abs(cx), down = margin + 1e-6f * abs(cy);
  return most(eye, box, -fx, 0.0f, eye.right - cx + across) < -x || most(eye, box, fx, 0.0f, cx - eye.left + across) < -x ||
         most(eye, box, 0.0f, -fy, eye.bottom - cy + down) < -y || most(eye, box, 0.0f, fy, cy - eye.top + down) < -y;
}
