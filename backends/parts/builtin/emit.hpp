// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Turns surfaces into Gaussians that are distributed as training would leave them.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>

#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/scene.hpp>
#include <swiftgs/tools/scene_part.hpp>

#include "light.hpp"

namespace swiftgs::builtin {

/// Three orthonormal directions.
struct Axes {
  dvec3 x, y, z;
};

/// Axes whose z is `normal` and whose x is as near to `along` as that allows.
inline Axes axes_along(const dvec3& normal, const dvec3& along) {
  const dvec3 x = unit(along - normal * dot(along, normal));
  return {x, cross(normal, x), normal};
}

/// `axes` turned about its own z.
inline Axes turned(const Axes& axes, double turns) {
  const double c = cos_turns(turns), s = sin_turns(turns);
  return {axes.x * c + axes.y * s, axes.y * c - axes.x * s, axes.z};
}

inline Quaternion quaternion(const Axes& a) { return rounded(quaternion_of(dmat3(a.x, a.y, a.z))); }

/// One Gaussian before it is stored.
struct Blob {
  dvec3 mean{0.0};
  Axes axes{};
  dvec3 scale{0.0};
  double opacity = 0;
  Radiance radiance{};
};

/// A range of a scene that one part of the picture fills, from first to last. `scene` holds the Gaussians in
/// `kept` alone.
class Sink {
 public:
  Sink(Scene& scene, ScenePart::Range kept, std::size_t begin, std::size_t end)
      : scene_(&scene), kept_(kept), next_(begin), end_(end) {}

  std::size_t left() const { return end_ - next_; }

  /// Passes over the next `count` Gaussians if none of them is kept.
  bool skips(std::size_t count = 1) {
    if (next_ < kept_.end && next_ + count > kept_.begin) return false;
    next_ += count < left() ? count : left();
    return true;
  }

  void add(const Blob& blob) {
    const std::size_t at = next_++;
    if (at < kept_.begin || at >= kept_.end) return;
    const std::size_t i = at - kept_.begin;
    scene_->means[i] = vec3(blob.mean);
    scene_->scales[i] = vec3(blob.scale);
    scene_->rotations[i] = quaternion(blob.axes);
    scene_->opacities[i] = float(blob.opacity);
    scene_->sh0[i] =
        vec3((blob.radiance.coefficients[0] * 0.28209479177387814 - dvec3(0.5)) / 0.28209479177387814);
    for (std::size_t k = 1; k < 16; ++k)
      for (int c = 0; c < 3; ++c)
        scene_->sh_rest[i * 45 + (k - 1) * 3 + std::size_t(c)] = float(blob.radiance.coefficients[k][c]);
  }

 private:
  Scene* scene_;
  ScenePart::Range kept_;
  std::size_t next_, end_;
};

/// What a surface is made of at one point. Colours of `body` are linear, those added to it are as displayed.
struct Material {
  dvec3 body{0.5};          ///< part of the light sent back in all directions
  dvec3 highlight{0.0};     ///< the sun's reflection
  dvec3 rim{0.03};          ///< the sky's reflection at grazing angles
  dvec3 interference{0.0};  ///< a thin film: one colour face on, its opposite beside it
};

/// A surface over the unit square; the cross product of its derivatives by v and by u points outward.
struct Surface {
  std::function<dvec3(double u, double v)> point;
  /// Material at `p`, which may be moved to where the detail is.
  std::function<Material(double u, double v, dvec3& p)> material;
  double cover = 0.62;      ///< standard deviation over the distance between neighbours
  double faint = 0.42;      ///< part of the Gaussians that is left over from training
  double stretch = 0.8;     ///< spread of the elongation, in powers of two
  double roughness = 0.05;  ///< tilt of a flake, as a tangent
};

/// Light that leaves `p` towards every direction.
inline Radiance shade(const Material& m, const dvec3& p, const dvec3& n, const Light& light) {
  Radiance out;
  out.add(display(m.body * light.falls_on(p, n)));
  out.add_lobe(n, rim_lobe, m.rim);
  if (m.interference != dvec3(0.0)) out.add_lobe(n, interference_lobe, m.interference);
  if (m.highlight != dvec3(0.0)) {
    const dvec3 mirror = n * (2 * dot(n, to_sun())) - to_sun();
    const double lit = smooth_step(-0.1, 0.25, dot(n, to_sun())) * light.sun_reaches(p);
    out.add_lobe(mirror, highlight_lobe, m.highlight * lit);
    // The brightest part of the sky, overhead.
    const dvec3 up(0, -1, 0), sky_mirror = n * (2 * dot(n, up)) - up;
    out.add_lobe(sky_mirror, highlight_lobe,
                 m.highlight * dvec3(0.16, 0.21, 0.28) * smooth_step(-0.2, 0.6, -n.y));
  }
  return out;
}

/// Small errors of every coefficient, as training leaves them.
inline void add_residue(Radiance& radiance, Random& random, double size) {
  for (std::size_t k = 1; k < 16; ++k) {
    const double common = random.bell();
    for (int c = 0; c < 3; ++c) radiance.coefficients[k][c] += size * (common + 0.3 * random.bell());
  }
}

/// Makes `blob` one of the many faint ones: larger, longer, a little off the surface.
inline void make_faint(Blob& blob, Random& random, double spacing) {
  const double size = spacing * power_of_two(-0.6 + 0.75 * random.bell());
  const double stretch = power_of_two(0.3 + 1.7 * std::abs(random.bell()));
  const double thin = power_of_two(-0.4 - 1.6 * std::abs(random.bell()));
  const double dim = random.uniform();
  blob.axes = turned(blob.axes, random.uniform());
  blob.mean += blob.axes.z * (0.35 * spacing * random.bell());
  blob.scale = dvec3(size * std::sqrt(stretch), size / std::sqrt(stretch), size * thin / std::sqrt(stretch));
  blob.opacity = 0.0045 + 0.22 * dim * dim * dim;
}

/// Fills `sink` with the Gaussians of `surface`; their size follows from the area that each has to cover.
inline void emit(const Surface& surface, std::uint64_t stream, Sink sink, const Light& light) {
  const std::size_t count = sink.left();
  constexpr double step = 1e-4;
  for (std::size_t i = 0; i < count; ++i) {
    if (sink.skips()) continue;
    Random random(stream, i);
    const SquarePoint q(i);
    const double u = step + (1 - 2 * step) * q.u, v = step + (1 - 2 * step) * q.v;
    dvec3 p = surface.point(u, v);
    const dvec3 du = (surface.point(u + step, v) - surface.point(u - step, v)) / (2 * step);
    const dvec3 dv = (surface.point(u, v + step) - surface.point(u, v - step)) / (2 * step);
    dvec3 n = cross(dv, du);
    const double area = length(n), solid_count = double(count) * (1 - surface.faint);
    if (!(area > 0))
      n = dvec3(0, -1, 0);
    else
      n /= area;
    const double spacing = std::sqrt(area / solid_count);
    const Material material = surface.material(u, v, p);

    Blob blob;
    blob.mean = p;
    blob.radiance = shade(material, p, n, light);
    const dvec3 tilt = random.bell3();
    blob.axes = turned(axes_along(unit(n + tilt * surface.roughness), du), 0.03 * random.bell());
    const double sigma = surface.cover * spacing * power_of_two(0.18 * random.bell());
    const double stretch = power_of_two(surface.stretch * std::abs(random.bell()));
    const double thin = power_of_two(-0.9 - 2.4 * std::abs(random.bell()));
    blob.scale = dvec3(sigma * stretch, sigma, sigma * thin);
    const double loss = random.uniform();
    blob.opacity = 0.998 - 0.6 * loss * loss;
    if (random.uniform() < surface.faint) {
      make_faint(blob, random, spacing);
      blob.radiance.add(random.bell3() * 0.03);
    }
    add_residue(blob.radiance, random, 0.008);
    sink.add(blob);
  }
}

}  // namespace swiftgs::builtin
