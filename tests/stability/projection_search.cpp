// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vector>

#include "stability/gaussians.hpp"
#include "stability/targets.hpp"

namespace swiftgs::test {
namespace {

/// What is reported of a projected Gaussian. The mean and the depth come from double and are measured in
/// plain ulps; all others are conditioned.
struct Stage {
  const char* name;
  const char* yardstick;
};
constexpr Stage stages[] = {{"mean", "ulps, of a thousandth of a pixel at least"},
                            {"depth", "ulps"},
                            {"determinant without blur", "conditioned ulps"},
                            {"`l0` without blur", "conditioned ulps of its factors"},
                            {"`l1` without blur", "conditioned ulps of its factors"},
                            {"`l0`", "conditioned ulps of its factors"},
                            {"`l1`", "conditioned ulps of its factors"},
                            {"`l2`", "conditioned ulps"},
                            {"compensated opacity", "conditioned ulps"},
                            {"cutoff", "conditioned ulps"},
                            {"half width", "conditioned ulps"}};
constexpr std::size_t stage_count = std::size(stages);

struct NamedView {
  std::string name;
  View view;
};

std::vector<NamedView> views() {
  std::vector<NamedView> all;
  for (const NamedCamera& c : searched_cameras()) {
    const FrameView frame{.width = c.camera.width, .height = c.camera.height};
    Conventions plain, sharp, compensated;
    sharp.blur = 0, compensated.antialiased = true;
    all.push_back({c.name, make_view(c.camera, plain, frame)});
    all.push_back({c.name + " blur 0", make_view(c.camera, sharp, frame)});
    all.push_back({c.name + " antialiased", make_view(c.camera, compensated, frame)});
  }
  return all;
}

/// A candidate's splat on one target.
struct Found {
  std::size_t candidate;
  SplatShape shape;
  float depth;
};

/// Projects all candidates on `backend`.
template <class B>
std::vector<Found> project_all(B& backend, const NamedView& view, const std::vector<Gaussian>& candidates) {
  Scene scene;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Gaussian& g = candidates[i];
    scene.means.push_back(g.mean), scene.scales.push_back(g.scale), scene.rotations.push_back(g.rotation);
    scene.opacities.push_back(g.opacity), scene.sh0.push_back(vec3(0));
  }
  const Projected projected = project_to_host(backend, view.view, scene);
  std::vector<Found> found;
  for (std::size_t i = 0; i < projected.shapes.size(); ++i) {
    found.push_back({projected.gaussians[i], projected.shapes[i], projected.depths[i]});
  }
  return found;
}

/// Errors of one splat by stage; -1 where a stage is not judged in this view. How inputs move a
/// result is found only where its plain error exceeds what is already known.
class Judge {
 public:
  Judge(const NamedView& view, const Gaussian& g)
      : view_(view),
        inputs_(inputs_of(view.view.camera, g)),
        exact_(project_exactly(view.view.camera, inputs_)) {
    joint_.fill(-1);
  }

  template <class Known>
  std::array<double, stage_count> errors(const Found& f, const Known& known) {
    using namespace result;
    const SplatShape& s = f.shape;
    const bool blurred = view_.view.camera.blur > 0, compensated = view_.view.camera.antialiased;
    std::array<double, stage_count> out;
    out.fill(-1);
    // Of a pixel, or of the distance from the largest image.
    const auto mean = [&](double got, Real exact) {
      const Real outside = exact - std::clamp(exact, Real(0), Real(max_image_side));
      return double(std::abs(Real(got) - exact) / ulp(std::max(std::abs(outside), Real(1))));
    };
    out[0] = std::max(mean(s.exact_mean().x, exact_[mean_x]), mean(s.exact_mean().y, exact_[mean_y]));
    out[1] = double(std::abs(f.depth - exact_[depth]) / ulp(exact_[depth]));
    const auto judge = [&](std::size_t stage, Real got, Real exact, Real scale, const auto& moved) {
      const Real error = std::abs(got - exact);
      const double plain = double(error / ulp(scale));
      out[stage] = plain <= known(stage) ? plain : double(error / (ulp(scale) + moved()));
    };
    const auto alone = [&](std::size_t stage, Index index, Real got) {
      judge(stage, got, exact_[index], exact_[index], [&] { return joint(index); });
    };
    if (!blurred) {
      const Real root = exact_base_2 * exact_base_2 / (Real(s.l0) * Real(s.l2));
      alone(2, determinant, root * root);
    }
    // l0 is made of the determinant and of the variance of y, which are computed apart: where their moves
    // cancel in l0, their roundings do not.
    const auto factors = [&] {
      return 0.5L * joint(Index::blurred) / exact_[Index::blurred] + 0.5L * moved()[var_y] / exact_[var_y];
    };
    judge(blurred ? 5 : 3, s.l0, exact_[l0], exact_[l0], [&] { return exact_[l0] * factors(); });
    // In l0 dx + l1 dy, l1 counts as much as l0 dx does at the edge of the splat: l0 times the lengths of
    // both rows over the variance of y. Below, digits of l1 move no pixel.
    const Real scale = std::max(std::abs(exact_[l1]), exact_[l1_scale]);
    judge(blurred ? 6 : 4, s.l1, exact_[l1], scale, [&] {
      return std::abs(exact_[l1]) * (factors() + moved()[var_y] / exact_[var_y]) +
             exact_[l0] * moved()[xy] / exact_[var_y];
    });
    judge(7, s.l2, exact_[l2], exact_[l2], [&] { return moved()[l2]; });
    if (compensated) alone(8, opacity, s.opacity);
    alone(9, cutoff, s.cutoff);
    judge(10, EllipseExtent(s).width, exact_[half_width], exact_[half_width],
          [&] { return moved()[half_width]; });
    return out;
  }

 private:
  const ProjectionResults& moved() {
    if (!found_) {
      const auto f = [&](const ProjectionInputs& in) { return project_exactly(view_.view.camera, in); };
      moves_ = moves(f, inputs_, ulps_of(inputs_));
      found_ = true;
    }
    return moves_;
  }

  Real joint(result::Index index) {
    if (joint_[index] < 0) {
      const auto f = [&](const ProjectionInputs& in) {
        return project_exactly(view_.view.camera, in)[index];
      };
      joint_[index] = joint_move(f, inputs_, ulps_of(inputs_));
    }
    return joint_[index];
  }

  const NamedView& view_;
  ProjectionInputs inputs_;
  ProjectionResults exact_, moves_{}, joint_;
  bool found_ = false;
};

}  // namespace

std::vector<Worst> search_projection(int effort) {
  Targets targets;
  std::vector<Worst> worst(stage_count * targets.size());
  for (std::size_t i = 0; i < worst.size(); ++i)
    worst[i] = {stages[i % stage_count].name, stages[i % stage_count].yardstick,
                targets.name(i / stage_count), 0, ""};
  std::uint64_t seed = 100;
  for (const NamedView& view : views()) {
    Search<Gaussian> search(worst.size(), 45, effort, ++seed);
    const auto judge = [&](const std::vector<Gaussian>& candidates, const auto& offer) {
      std::vector<Judge> judges;
      for (const Gaussian& g : candidates) judges.emplace_back(view, g);
      for (std::size_t t = 0; t < targets.size(); ++t) {
        std::vector<Found> found;
        targets.on(t, [&](auto& backend) { found = project_all(backend, view, candidates); });
        const auto known = [&](std::size_t stage) { return search.reached(t * stage_count + stage); };
        for (const Found& f : found) {
          const auto errors = judges[f.candidate].errors(f, known);
          for (std::size_t k = 0; k < stage_count; ++k)
            offer(t * stage_count + k, candidates[f.candidate], errors[k]);
        }
      }
    };
    search.run(
        256, [&](Random& random) { return draw_gaussian(random, view.view.camera); },
        [](Random& random, Gaussian& g) { nudge(random, g); }, judge);
    for (std::size_t i = 0; i < worst.size(); ++i)
      if (search.value(i) > worst[i].ulps)
        worst[i].ulps = search.value(i), worst[i].at = view.name + ": " + text_of(search.best()[i].candidate);
  }
  return worst;
}

}  // namespace swiftgs::test
