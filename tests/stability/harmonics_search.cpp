// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include <swiftgs/project/sh.hpp>

#include "stability/exact_projection.hpp"
#include "stability/search.hpp"
#include "stability/targets.hpp"

namespace swiftgs::test {
namespace {

constexpr int most = sh_rest_count(max_sh_degree);

/// A basis function and the sum of the magnitudes of its terms.
struct Exact {
  Real value = 0, terms = 0;
};

/// Bands 1 to 3 in the direction `d`, as homogeneous polynomials.
std::array<Exact, most> exact_basis(const Real3& d) {
  const auto root = [](Real number) { return std::sqrt(number / pi); };
  const Real x = d[0], y = d[1], z = d[2], xx = x * x, yy = y * y, zz = z * z;
  const auto f = [](Real c, Real factor, Real a, Real b = 0, Real e = 0) {
    return Exact{c * factor * (a + b + e), std::abs(c * factor) * (std::abs(a) + std::abs(b) + std::abs(e))};
  };
  const Real c1 = root(3) / 2, c2 = root(15) / 2, c3 = root(Real(35) / 2) / 4, c32 = root(Real(21) / 2) / 4;
  return {f(-c1, 1, y),
          f(c1, 1, z),
          f(-c1, 1, x),
          f(c2, 1, x * y),
          f(-c2, 1, y * z),
          f(root(5) / 4, 1, 2 * zz, -xx, -yy),
          f(-c2, 1, x * z),
          f(c2 / 2, 1, xx, -yy),
          f(-c3, y, 3 * xx, -yy),
          f(root(105) / 2, 1, x * y * z),
          f(-c32, y, 4 * zz, -xx, -yy),
          f(root(7) / 4, z, 2 * zz, -3 * xx, -3 * yy),
          f(-c32, x, 4 * zz, -xx, -yy),
          f(root(105) / 4, z, xx, -yy),
          f(-c3, x, xx, -3 * yy)};
}

/// One Gaussian's place and coefficients of a channel; the camera is at the origin.
struct Candidate {
  vec3 mean;
  float sh0, rest[most];
};

Real3 direction(vec3 mean) {
  const Real3 d{mean.x, mean.y, mean.z};
  const Real length = std::sqrt(dot(d, d));
  return {d[0] / length, d[1] / length, d[2] / length};
}

Exact exact_colour(int degree, const Candidate& c, const Real3& d) {
  const Real c0 = 1 / std::sqrt(4 * pi);
  const std::array<Exact, most> basis = exact_basis(d);
  Exact out{0.5L + c0 * Real(c.sh0), 0.5L + c0 * std::abs(Real(c.sh0))};
  for (std::size_t k = 0; k < std::size_t(sh_rest_count(degree)); ++k) {
    out.value += basis[k].value * Real(c.rest[k]);
    out.terms += basis[k].terms * std::abs(Real(c.rest[k]));
  }
  return out;
}

/// In front of a camera at the origin, so that a backend shows it.
Candidate draw(Random& random) {
  const double z = random.scale(0.1, 100);
  const float y = random.f(-0.4, 0.4) * float(z), x = random.f(-0.5, 0.5) * float(z);
  Candidate c{vec3(x, y, float(z)), random.f(-1, 3), {}};
  for (float& v : c.rest) v = random.bits() % 3 == 0 ? 0 : random.f(-1, 1);
  return c;
}

void nudge_all(Random& random, Candidate& c) {
  for (int k = 0; k < 3; ++k) nudge(random, c.mean[k]);
  for (int k = 0; k < 2; ++k) c.mean[k] = std::clamp(c.mean[k], -c.mean.z, c.mean.z);
  nudge(random, c.sh0);
  for (float& v : c.rest) nudge(random, v);
  if (random.bits() % 8 == 0) c.rest[random.bits() % most] *= -1;
}

std::string text_of(const Candidate& c) {
  std::string line = text("mean %.9g %.9g %.9g coefficients %.9g", double(c.mean.x), double(c.mean.y),
                          double(c.mean.z), double(c.sh0));
  for (const float v : c.rest) line += text(" %.9g", double(v));
  return line;
}

/// Colours of all candidates by a whole projection, in the order of the candidates, which are all visible.
template <class B>
std::vector<float> colours_on(B& backend, int degree, const std::vector<Candidate>& candidates,
                              const View& view) {
  Scene scene;
  scene.sh_degree = degree;
  for (const Candidate& c : candidates) {
    scene.means.push_back(c.mean), scene.scales.push_back(vec3(c.mean.z)), scene.rotations.push_back({});
    scene.opacities.push_back(1), scene.sh0.push_back(vec3(c.sh0));
    for (int k = 0; k < sh_rest_count(degree); ++k)
      for (int channel = 0; channel < 3; ++channel) scene.sh_rest.push_back(c.rest[k]);
  }
  std::vector<float> found;
  for (const SplatColour& colour : project_to_host(backend, view, scene).colours)
    found.push_back(colour.rgb.y);
  return found;
}

}  // namespace

std::vector<Worst> search_harmonics(int effort) {
  Targets targets;
  const Camera camera = forward_camera(128, 96);
  const View view = make_view(camera, Conventions(), {.width = camera.width, .height = camera.height});
  std::vector<Worst> all;
  for (int degree = 1; degree <= max_sh_degree; ++degree) {
    // Objective 0 is the basis alone, 1 is `sh_colour` alone; then whole colours on each target.
    // Many short climbs: with so many coefficients, one climb ends at a hill of its own.
    Search<Candidate> search(2 + targets.size(), 400, 8 * effort, std::uint64_t(300 + degree));
    const auto judge = [&](const std::vector<Candidate>& candidates, const auto& offer) {
      for (const Candidate& c : candidates) {
        const vec3 d = view_direction(view.camera, c.mean);
        const Real3 wide{d.x, d.y, d.z};
        float basis[most];
        sh_basis(degree, d, basis);
        const std::array<Exact, most> exact = exact_basis(wide);
        for (std::size_t k = std::size_t(sh_rest_count(degree - 1)); k < std::size_t(sh_rest_count(degree));
             ++k)
          offer(0, c, double(std::abs(basis[k] - exact[k].value) / ulp(exact[k].terms)));
        float rest[3 * most];
        for (int k = 0; k < 3 * most; ++k) rest[k] = c.rest[k / 3];
        const Exact colour = exact_colour(degree, c, wide);
        offer(1, c,
              double(std::abs(sh_colour(degree, vec3(c.sh0), rest, d).y - colour.value) / ulp(colour.terms)));
      }
      for (std::size_t t = 0; t < targets.size(); ++t) {
        std::vector<float> found;
        targets.on(t, [&](auto& b) { found = colours_on(b, degree, candidates, view); });
        for (std::size_t i = 0; i < found.size() && found.size() == candidates.size(); ++i) {
          const Exact exact = exact_colour(degree, candidates[i], direction(candidates[i].mean));
          if (exact.value > 0)  // below, the colour is cut
            offer(2 + t, candidates[i], double(std::abs(found[i] - exact.value) / ulp(exact.terms)));
        }
      }
    };
    search.run(256, draw, nudge_all, judge);
    const std::string of = text(" of degree %d", degree), yardstick = "ulps of the sum of magnitudes";
    for (std::size_t i = 0; i < 2 + targets.size(); ++i)
      all.push_back({(i == 0   ? "`sh_basis`"
                      : i == 1 ? "`sh_colour`"
                               : "colour") +
                         of,
                     yardstick, i < 2 ? "serial" : targets.name(i - 2), search.value(i),
                     text_of(search.best()[i].candidate)});
  }
  return all;
}

}  // namespace swiftgs::test
