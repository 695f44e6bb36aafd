// SPDX-License-Identifier: Apache-2.0

// Chunks that show one Gaussian at the border of what a view shows: the least that no view may hide.
#include <cmath>
#include <cstdint>
#include <optional>

#include <doctest/doctest.h>

#include <swiftgs/lens/view.hpp>
#include <swiftgs/project/chunks.hpp>
#include <swiftgs/project/project.hpp>

#include "policies/random_splats.hpp"

namespace swiftgs::test::chunk_borders_test {

namespace {

/// Kinds of cameras, each odd in one way; the last in all.
enum class Kind { ordinary, uneven_focal, principal_point_off, turned, far_from_origin, part, all, kinds };

ViewConstants odd_camera(Random& random, Kind kind, LensModel model) {
  const auto is = [&](Kind one) { return kind == one || kind == Kind::all; };
  const int width = 16 * int(random.in(2, 120)), height = 16 * int(random.in(2, 120));
  Camera camera = forward_camera(width, height, width * random.scale(0.3, 20));
  camera.lens.model = model;
  if (is(Kind::uneven_focal)) camera.fy = camera.fx * random.scale(0.02, 50);
  if (is(Kind::principal_point_off))
    camera.cx = width * random.in(-4, 5), camera.cy = height * random.in(-4, 5);
  if (is(Kind::turned)) {
    const LocalAxes<float> axes(random_rotation(random));
    for (int column = 0; column < 3; ++column) camera.rotation[column] = dvec3(axes.column[column]);
  }
  const double far = is(Kind::far_from_origin) ? 1e5 : 3;
  for (int axis = 0; axis < 3; ++axis) camera.translation[axis] = random.in(-far, far);
  Conventions conventions = random.bits() % 2 == 0 ? Conventions::gsplat() : Conventions::inria();
  conventions.far_plane = float(random.scale(30, 300));
  conventions.blur = random.bits() % 4 == 0 ? 0.0f : float(random.scale(0.01, 300));
  FrameView frame{.width = width, .height = height};
  FirstPixel first;
  if (is(Kind::part)) {
    first.x = 16 * int(random.in(0, width / 16)), first.y = 16 * int(random.in(0, height / 16));
    frame.width = 16, frame.height = 16;
  }
  return make_view(camera, conventions, frame, vec3(0), first).camera;
}

/// A Gaussian whose splat is about as wide as bounds say: a ball, a needle, or one that a quaternion of
/// another length than 1 lengthens.
Gaussian widest(Random& random, const ViewConstants& view) {
  Gaussian g{};
  g.scale = vec3(float(random.scale(1e-6, 3)));
  g.rotation = random_rotation(random);
  const int axis = int(random.in(0, 3));
  g.scale[axis] *= -1;  // signs mean nothing
  if (random.bits() % 4 == 0) g.scale[(axis + 1) % 3] *= 0.01f, g.scale[(axis + 2) % 3] *= 0.01f;
  if (random.bits() % 3 == 0) {
    const float length = random.f(0.5, 1.5);
    if (random.bits() % 2 == 0) g.rotation.w = 0;
    for (float* part : {&g.rotation.w, &g.rotation.x, &g.rotation.y, &g.rotation.z}) *part *= length;
  }
  g.opacity = float(view.alpha_min * random.scale(1.01, 255));
  return g;
}

/// Where something stands in an image @units{pixels}, and its depth.
struct Place {
  double x, y, depth;
};

/// The point of camera space that a lens shows at a place.
dvec3 seen_at(const ViewConstants& view, const Place& at) {
  const double u = (at.x - view.cx) / view.fx, v = (at.y - view.cy) / view.fy;
  const double angle = std::hypot(u, v), sine = std::sin(angle) / angle;
  switch (view.lens.model) {
    case LensModel::perspective:
      return at.depth * dvec3(u, v, 1);
    case LensModel::fisheye:
      return at.depth * dvec3(u * sine, v * sine, std::cos(angle));
    case LensModel::orthographic:
      return dvec3(u, v, at.depth);
    case LensModel::equirectangular:
      return at.depth * dvec3(std::cos(v) * std::sin(u), std::sin(v), std::cos(v) * std::cos(u));
  }
  return {};
}

vec3 world(const ViewConstants& view, const Place& at) {
  const dvec3 p = seen_at(view, at);
  vec3 point;
  for (int k = 0; k < 3; ++k)
    point[k] = float(view.centre[k] + p[0] * view.rotation[0][k] + p[1] * view.rotation[1][k] +
                     p[2] * view.rotation[2][k]);
  return point;
}

/// The four edges of the image, the two planes, and `borders`, their number.
enum class Border { left, right, top, bottom, near_plane, far_plane, borders };

bool is_plane(Border border) { return border == Border::near_plane || border == Border::far_plane; }

/// Moves a place out of the view; by pixels, or, through the planes, by so many times its depth.
Place moved_out(Place at, Border border, double by) {
  if (border == Border::left) at.x -= by;
  if (border == Border::right) at.x += by;
  if (border == Border::top) at.y -= by;
  if (border == Border::bottom) at.y += by;
  if (border == Border::near_plane) at.depth /= 1 + by;
  if (border == Border::far_plane) at.depth *= 1 + by;
  return at;
}

/// The direction of camera space that leads out of the view.
dvec3 outwards(const ViewConstants& view, Border border) {
  if (border == Border::left) return {-view.fx, 0, view.left - view.cx};
  if (border == Border::right) return {view.fx, 0, view.cx - view.right};
  if (border == Border::top) return {0, -view.fy, view.top - view.cy};
  if (border == Border::bottom) return {0, view.fy, view.cy - view.bottom};
  return {0, 0, border == Border::near_plane ? -1 : 1};
}

/// A Gaussian that is visible and would not be a little further out.
struct AtBorder {
  Gaussian gaussian;
  Place place;
  double reach = 0;  ///< how far outside the view its mean is @units{pixels}
};

std::optional<AtBorder> at_border(Random& random, const ViewConstants& view, Border border) {
  Gaussian g = widest(random, view);
  const double y = random.in(view.top, view.bottom), x = random.in(view.left, view.right);
  const Place within{x, y, random.scale(0.3, 25)};
  double inside = 0, outside = is_plane(border) ? 1000 : random.scale(1e3, 1e6);
  // Further turned, places come back to the image.
  if (!is_plane(border) && traits_of(view.lens.model).sees_behind) outside = std::fmin(outside, 2 * view.fx);
  const auto visible = [&](double by) {
    g.mean = world(view, moved_out(within, border, by));
    return project_shape(view, g).visible;
  };
  if (!visible(inside) || visible(outside)) return std::nullopt;
  for (int step = 0; step < 50; ++step) {
    const double middle = (inside + outside) / 2;
    (visible(middle) ? inside : outside) = middle;
  }
  g.mean = world(view, moved_out(within, border, inside));
  return AtBorder{g, moved_out(within, border, inside), inside};
}

/// A chunk of `g` and of one that cannot be seen. Through a pinhole the second is so far out that `g` is the
/// corner of the box nearest to what the view shows; through other lenses it is behind `g`.
Scene chunk_of(Random& random, const ViewConstants& view, Border border, const Gaussian& g) {
  Scene scene;
  const dvec3 out = outwards(view, border);
  vec3 corner = g.mean;
  const double behind = random.scale(1e-6, 100);
  for (int k = 0; k < 3; ++k) {
    double along = 0;
    for (int row = 0; row < 3; ++row) along += view.rotation[row][k] * out[row];
    corner[k] += float(view.through_lens ? behind * (g.mean[k] - view.centre[k])
                                         : std::copysign(random.scale(1e-4, 1e3), along));
  }
  for (const vec3 mean : {g.mean, corner}) {
    scene.means.push_back(mean), scene.scales.push_back(g.scale), scene.rotations.push_back(g.rotation);
    scene.opacities.push_back(g.opacity), scene.sh0.push_back(vec3(0));
  }
  scene.scales[1] = vec3(0), scene.opacities[1] = 0;
  return scene;
}

bool culls(Random& random, const ViewConstants& view, Border border, const Gaussian& g) {
  const Scene scene = chunk_of(random, view, border, g);
  return ChunkCuller(view).culls(detail::bounds_of_chunk(swiftgs::view(scene), 0));
}

/// What chunks do that show one Gaussian at a border, in random views.
struct Outcome {
  int pairs = 0;
  int wrong = 0;   ///< culled though their Gaussian is visible
  int culled = 0;  ///< of those whose Gaussian is a little beyond
};

Outcome outcome(LensModel model, int kind, int side, int rounds) {
  const auto border = Border(side);
  Random random(std::uint64_t(kind * int(Border::borders) + side));
  Outcome out;
  for (int round = 0; round < rounds; ++round) {
    const ViewConstants view = odd_camera(random, Kind(kind), model);
    const std::optional<AtBorder> found = at_border(random, view, border);
    if (!found) continue;
    ++out.pairs, out.wrong += culls(random, view, border, found->gaussian);
    Gaussian beyond = found->gaussian;
    beyond.mean =
        world(view, moved_out(found->place, border, is_plane(border) ? 0.01 : 3 + 0.1 * found->reach));
    out.culled += culls(random, view, border, beyond);
  }
  return out;
}

}  // namespace

TEST_CASE(
    "chunks: those that show a Gaussian at a border of the view are kept and most a little beyond are "
    "culled") {
  for (const LensModel model :
       {LensModel::perspective, LensModel::fisheye, LensModel::orthographic, LensModel::equirectangular})
    for (int kind = 0; kind < int(Kind::kinds); ++kind)
      for (int side = 0; side < int(Border::borders); ++side) {
        CAPTURE(name_of(model));
        CAPTURE(kind);
        CAPTURE(side);
        // The bounds of other lenses are wide, and the last kind turns their places beyond what they show.
        const bool pinhole = model == LensModel::perspective;
        const int rounds = pinhole ? 6'000 : 600;
        const Outcome found = outcome(model, kind, side, rounds);
        CHECK(found.wrong == 0);
        CHECK(found.pairs > (pinhole ? 0.67 : 0.25) * rounds);
        CHECK(found.culled > (pinhole ? 0.5 : 0.05) * found.pairs);
      }
}

}  // namespace swiftgs::test::chunk_borders_test
