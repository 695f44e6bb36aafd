// SPDX-License-Identifier: Apache-2.0

// Pixels of a view in memory: what the colours hold, and what `store_pixel` makes of a blended pixel.

// A plane: its first pixel, null where it is absent, and the bytes from a row to the one below it, of 64 bits.
struct Plane {
  uvec2 data, pitch;
};

// A view as rasterizers need it: `RasterView` of the host.
struct RasterView {
  Plane colour, alpha, depth, first_depth, median_depth, id, median_id, normal, squared_depth, features, occluder;
  FloatPair stored_p, stored_q, stored_r, stored_s;
  TileGrid grid;
  uint width, height, format, conversion, over, stored_as_depth, feature_channels;
  float least, alpha_max, stop_below, first_below;  // alpha_min / alpha_max; of transmittances
  vec3 background;
  vec2 middle;  // of the image
};

uvec2 pixel_of(Plane plane, uvec2 at, uint bytes) {
  uint high, low, carry;
  umulExtended(at.y, plane.pitch.x, high, low);
  low = uaddCarry(plane.data.x, low, carry);
  return element(uvec2(low, plane.data.y + high + at.y * plane.pitch.y + carry), at.x, bytes);
}
Floats floats_of(Plane plane, uvec2 at, uint channels) { return Floats(pixel_of(plane, at, 4u * channels)); }
Uints words_of(Plane plane, uvec2 at, uint words) { return Uints(pixel_of(plane, at, 4u * words)); }

// The order of `PixelFormat`.
const uint rgb_float = 0u, rgba_float = 1u, rgba_half = 2u, rgba_8 = 3u, bgra_8 = 4u;

// Rounds to nearest even; beyond 65,504 becomes infinite.
uint to_half(float value) {
  const uint f = floatBitsToUint(value), sign = (f >> 16) & 0x8000u, magnitude = f & 0x7fffffffu;
  if (magnitude > 0x7f800000u) return sign | 0x7e00u;
  if (magnitude >= 0x477ff000u) return sign | 0x7c00u;
  if (magnitude < 0x38800000u) {
    precise float shifted = uintBitsToFloat(magnitude) + 0.5;
    return sign | (floatBitsToUint(shifted) - 0x3f000000u);
  }
  const uint rebased = magnitude - (112u << 23);
  return sign | ((rebased + 0xfffu + ((rebased >> 13) & 1u)) >> 13);
}
float from_half(uint bits) { return unpackHalf2x16(bits).x; }

uint to_unorm8(float value) {
  precise float half_steps = min(value, 1.0) * 510.0;
  return value > 0.0 ? uint((int(half_steps) + 1) >> 1) : 0u;
}

vec4 load_colour(RasterView view, uvec2 at) {
  if (view.format == rgb_float) {
    Floats p = floats_of(view.colour, at, 3u);
    return vec4(p.at[0], p.at[1], p.at[2], 1.0);
  }
  if (view.format == rgba_float) {
    Floats p = floats_of(view.colour, at, 4u);
    return vec4(p.at[0], p.at[1], p.at[2], p.at[3]);
  }
  if (view.format == rgba_half) {
    Uints p = words_of(view.colour, at, 2u);
    return vec4(unpackHalf2x16(p.at[0]), unpackHalf2x16(p.at[1]));
  }
  const uint p = words_of(view.colour, at, 1u).at[0];
  const vec4 c = vec4(p & 255u, (p >> 8) & 255u, (p >> 16) & 255u, p >> 24) * (1.0 / 255.0);
  return view.format == bgra_8 ? c.zyxw : c;
}

void store_colour(RasterView view, uvec2 at, vec4 colour) {
  if (view.format <= rgba_float) {
    const uint channels = view.format == rgb_float ? 3u : 4u;
    Floats p = floats_of(view.colour, at, channels);
    p.at[0] = colour.r;
    p.at[1] = colour.g;
    p.at[2] = colour.b;
    if (channels == 4u) p.at[3] = colour.a;
  } else if (view.format == rgba_half) {
    Uints p = words_of(view.colour, at, 2u);
    p.at[0] = to_half(colour.x) | (to_half(colour.y) << 16);
    p.at[1] = to_half(colour.z) | (to_half(colour.w) << 16);
  } else {
    const vec4 c = view.format == bgra_8 ? colour.zyxw : colour;
    words_of(view.colour, at, 1u).at[0] =
        to_unorm8(c.x) | (to_unorm8(c.y) << 8) | (to_unorm8(c.z) << 16) | (to_unorm8(c.w) << 24);
  }
}

// x^(-1 / n) of n = 10 or 12, about a unit in the last place: a guess from the bits and two steps of the series.
float inverse_root_of(float x, uint n) {
  const bool ten = n == 10u;
  const float part = ten ? 0.1 : 0.083333336, c2 = ten ? 0.055 : 0.045138888, c3 = ten ? 0.0385 : 0.031346452;
  const int start = ten ? 1171473301 : 1153723706;
  float y = intBitsToFloat(start - int(float(floatBitsToInt(x)) * part));
  for (uint k = 0u; k < 2u; ++k) {
    const float y2 = y * y, y4 = y2 * y2, missing = 1.0 - (x * y4) * (ten ? y4 * y2 : y4 * y4);
    y = y * missing * ((missing * c3 + c2) * missing + part) + y;
  }
  return y;
}
// As `to_srgb` and `from_srgb`.
float to_srgb(float light) {
  const float x = abs(light), curved = 1.055 * (sqrt(x) * inverse_root_of(x, 12u)) - 0.055;
  const float encoded = x <= 0.0031308 ? 12.92 * x : curved;
  return light < 0.0 ? -encoded : encoded;
}
float from_srgb(float encoded) {
  const float x = abs(encoded), base = (x + 0.055) * 0.94786733;
  const float light = x <= 0.04045 ? x * 0.077399380 : base * base * (sqrt(base) * inverse_root_of(base, 10u));
  return encoded < 0.0 ? -light : light;
}

// The order of `Conversion`.
const uint as_is = 0u, srgb_to_linear = 1u, linear_to_srgb = 2u;

// Premultiplied colours through a curve or back.
vec4 converted(RasterView view, vec4 colour, float alpha, bool back) {
  const bool encode = (view.conversion == linear_to_srgb) != back;
  if (!(alpha > 0.0)) return vec4(0.0, 0.0, 0.0, colour.w);
  for (uint c = 0u; c < 3u; ++c) {
    const float straight = colour[c] / alpha;
    colour[c] = (encode ? to_srgb(straight) : from_srgb(straight)) * alpha;
  }
  return colour;
}

// The depth that an occluder has at a pixel; infinite for nothing.
float occluder_at(RasterView view, uvec2 at) {
  const float value = floats_of(view.occluder, at, 1u).at[0], infinite = uintBitsToFloat(0x7f800000u);
  if (view.stored_as_depth != 0u) return value;
  const FloatPair v = pair(value, 0.0), below = multiply_add(view.stored_r, v, view.stored_s);
  if (!(below.high > 0.0)) return infinite;
  return times(multiply_add(view.stored_p, v, view.stored_q), inverse_pair(below)).high;
}
