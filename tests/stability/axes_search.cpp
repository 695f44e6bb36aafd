// SPDX-License-Identifier: Apache-2.0
#include "stability/gaussians.hpp"

namespace swiftgs::test {
namespace {

/// What `image_axes` gets beside the camera.
struct Candidate {
  float tx, ty, z;
  vec3 scale;
  Quaternion rotation;
};

/// tx, ty, z, scale, quaternion, the camera's rotation by rows.
using Inputs = std::array<Real, 19>;
using Results = std::array<Real, 9>;  ///< x, y, absolute cross

Inputs inputs_of(const ViewConstants& v, const Candidate& c) {
  Inputs in{c.tx,      c.ty,         c.z,          c.scale.x,    c.scale.y,
            c.scale.z, c.rotation.w, c.rotation.x, c.rotation.y, c.rotation.z};
  for (std::size_t i = 0; i < 9; ++i) in[10 + i] = v.rotation[i / 3][i % 3];
  return in;
}

Results exactly(const ViewConstants& v, const Inputs& in) {
  const Rotation w{Real3{in[10], in[11], in[12]}, Real3{in[13], in[14], in[15]},
                   Real3{in[16], in[17], in[18]}};
  const ExactAxes m(w, Real(v.fx), Real(v.fy), in[0], in[1], in[2], &in[3], &in[6]);
  const Real3 c = cross(m.x, m.y);
  Results out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = m.x[k], out[3 + k] = m.y[k], out[6 + k] = std::abs(c[k]);
  return out;
}

Candidate draw(Random& random, const ViewConstants& v) {
  const Gaussian g = draw_gaussian(random, v);
  return {random.f(double(v.tan_x_min), double(v.tan_x_max)),
          random.f(double(v.tan_y_min), double(v.tan_y_max)), float(random.scale(0.02, 100)), g.scale,
          g.rotation};
}

void nudge_all(Random& random, Candidate& c) {
  nudge(random, c.tx), nudge(random, c.ty), nudge(random, c.z);
  for (int k = 0; k < 3; ++k) nudge(random, c.scale[k]);
  nudge(random, c.rotation);
}

std::string text_of(const Candidate& c) {
  return text("tx %.9g ty %.9g z %.9g scale %.9g %.9g %.9g rotation %.9g %.9g %.9g %.9g", double(c.tx),
              double(c.ty), double(c.z), double(c.scale.x), double(c.scale.y), double(c.scale.z),
              double(c.rotation.w), double(c.rotation.x), double(c.rotation.y), double(c.rotation.z));
}

}  // namespace

std::vector<Worst> search_axes(int effort) {
  std::vector<Worst> worst{{"rows of `image_axes`", "conditioned ulps", "serial", 0, ""},
                           {"cross product of `image_axes`", "conditioned ulps", "serial", 0, ""}};
  std::uint64_t seed = 200;
  for (const NamedCamera& named : searched_cameras()) {
    const ViewConstants v = view_constants(named.camera, Conventions());
    Search<Candidate> search(2, 120, effort, ++seed);
    const auto judge = [&](const std::vector<Candidate>& candidates, const auto& offer) {
      for (const Candidate& c : candidates) {
        const ImageAxes got = image_axes(v, c.tx, c.ty, 1 / c.z, c.scale, c.rotation);
        const Inputs in = inputs_of(v, c);
        const Results exact = exactly(v, in);
        Results moved{}, errors;
        bool found = false;
        for (std::size_t k = 0; k < 9; ++k) {
          const vec3& row = k < 3 ? got.x : k < 6 ? got.y : got.cross;
          const float value = row[int(k % 3)];
          errors[k] = std::abs((k < 6 ? Real(value) : std::abs(Real(value))) - exact[k]);
          const std::size_t objective = k / 6;
          if (double(errors[k] / ulp(exact[k])) <= search.reached(objective)) continue;
          if (!found)
            moved = moves([&](const Inputs& at) { return exactly(v, at); }, in, ulps_of(in)), found = true;
          offer(objective, c, double(errors[k] / (ulp(exact[k]) + moved[k])));
        }
      }
    };
    search.run(
        256, [&](Random& random) { return draw(random, v); }, nudge_all, judge);
    for (std::size_t i = 0; i < worst.size(); ++i)
      if (search.value(i) > worst[i].ulps)
        worst[i].ulps = search.value(i),
        worst[i].at = named.name + ": " + text_of(search.best()[i].candidate);
  }
  return worst;
}

}  // namespace swiftgs::test
