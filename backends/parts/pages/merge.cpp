// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include <glm/matrix.hpp>

#include <swiftgs/edit/rotation.hpp>
#include <swiftgs/frame/half.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "nodes.hpp"

namespace swiftgs::pages {
namespace {

/// Nodes that are compared with each other.
constexpr std::size_t block_size = 128;

/// Moments of the Gaussians that a node stands for. `sum_of` adds two.
struct Moments {
  dvec3 mean;
  dmat3 covariance;
  double mass;  ///< opacity times `shown_area`, above 0
  double spread;
  vec3 sh0;
  std::array<float, 45> sh_rest;
};

Moments moments_of(const Nodes& nodes, std::size_t i, std::size_t each) {
  const Scene& scene = nodes.scene;
  const Quaternion& q = scene.rotations[i];
  const dmat3 rotation = matrix_of(DQuaternion{q.w, q.x, q.y, q.z});
  const dvec3 scale(scene.scales[i]);
  dmat3 axes = rotation;
  for (int k = 0; k < 3; ++k) axes[k] *= scale[k];
  // What shows nothing still has a place, which the smallest mass gives it.
  const double mass = std::max(double(scene.opacities[i]) * shown_area(scale), 1e-60);
  Moments m{
      dvec3(scene.means[i]), axes * glm::transpose(axes), mass, double(nodes.spread[i]), scene.sh0[i], {}};
  std::copy_n(scene.sh_rest.data() + each * i, each, m.sh_rest.begin());
  return m;
}

Moments sum_of(const Moments& a, const Moments& b, std::size_t each) {
  const double mass = a.mass + b.mass, wa = a.mass / mass, wb = b.mass / mass;
  const dvec3 apart = a.mean - b.mean;
  Moments sum;
  sum.mass = mass;
  sum.mean = wa * a.mean + wb * b.mean;
  sum.covariance = wa * a.covariance + wb * b.covariance + wa * wb * glm::outerProduct(apart, apart);
  sum.spread = wa * a.spread + wb * b.spread + wa * wb * dot(apart, apart);
  const float fa = float(wa), fb = float(wb);
  sum.sh0 = fa * a.sh0 + fb * b.sh0;
  for (std::size_t k = 0; k < each; ++k) sum.sh_rest[k] = fa * a.sh_rest[k] + fb * b.sh_rest[k];
  return sum;
}

/// A node of a block that takes in another. Costs of a block's steps never fall.
struct Step {
  float cost;
  std::uint8_t to, from;
};

/// Merges pairs of up to `block_size` nodes.
class Block {
 public:
  Block(const Nodes& nodes, std::span<const std::uint32_t> members, std::size_t each)
      : nodes_(nodes), each_(each), count_(members.size()) {
    origin_ = dvec3(nodes.scene.means[members[0]]);
    for (std::size_t i = 0; i < count_; ++i) {
      member_[i] = members[i], merged_[i] = false;
      moments_[i] = moments_of(nodes, members[i], each);
    }
  }

  /// Merges the two that cost least, again and again, until `count` are left.
  std::vector<Step> merge_to(std::size_t count) {
    for (std::size_t i = 0; i < count_; ++i) place(i);
    for (std::size_t i = 0; i < count_; ++i) find_partner(i);
    std::vector<Step> steps;
    for (std::size_t left = count_; left > count;) {
      const auto cheapest = std::min_element(cost_.begin(), cost_.begin() + std::ptrdiff_t(count_));
      const auto i = std::size_t(cheapest - cost_.begin()), j = partner_[i];
      if (j == none) {
        find_partner(i);
        continue;
      }
      const float last = steps.empty() ? 0 : steps.back().cost;
      steps.push_back({std::max(*cheapest, last), std::uint8_t(i), std::uint8_t(j)});
      take(steps.back());
      place(i);
      cost_[j] = never, --left;
      const Each<float> costs = find_partner(i);
      for (std::size_t k = 0; k < count_; ++k) {
        if (k == i) continue;
        const bool lost = partner_[k] == i || partner_[k] == j;
        if (costs[k] < cost_[k] || (lost && costs[k] == cost_[k]))
          cost_[k] = costs[k], partner_[k] = i;
        else if (lost)
          partner_[k] = none;  // all others cost at least as much as the lost partner
      }
    }
    return steps;
  }

  void take(const Step& step) {
    moments_[step.to] = sum_of(moments_[step.to], moments_[step.from], each_);
    merged_[step.to] = true, gone_[step.from] = never;
  }

  /// Writes the nodes that are left, from number `to` on. Copies those that did not merge.
  void write(Nodes& out, std::size_t to) const {
    for (std::size_t i = 0; i < count_; ++i) {
      if (gone_[i] != 0) continue;
      merged_[i] ? write_merged(out, to, moments_[i]) : copy(out, to, member_[i]);
      // Pages need not keep the sign of 0, so no node has one: those read from a page are those written.
      for (float& value : std::span(out.scene.sh_rest).subspan(each_ * to, each_))
        value = to_float(to_half(std::clamp(value, -65504.0f, 65504.0f))) + 0.0f;
      ++to;
    }
  }

 private:
  static constexpr float never = std::numeric_limits<float>::infinity();
  static constexpr std::size_t none = block_size;
  template <class T>
  using Each = std::array<T, block_size>;

  /// What costs of node `i` are computed of.
  void place(std::size_t i) {
    const Moments& m = moments_[i];
    const dvec3 at = m.mean - origin_;
    x_[i] = float(at.x), y_[i] = float(at.y), z_[i] = float(at.z);
    red_[i] = m.sh0.x, green_[i] = m.sh0.y, blue_[i] = m.sh0.z;
    // Masses and squares of lengths of small scenes leave the range of float together only.
    inverse_mass_[i] = float(1 / std::max(m.mass, 1e-30));
    for (int k = 0; k < 3; ++k) {
      diagonal_[k][i] = float(m.covariance[k][k]);
      others_[k][i] = float(m.covariance[k][(k + 1) % 3]);
    }
  }

  /// What the picture changes if two merge: their means by the distance, their covariances by the difference,
  /// their colours over their size. The same for (j, i) while neither is gone.
  float cost_of(std::size_t i, std::size_t j) const {
    const float dx = x_[i] - x_[j], dy = y_[i] - y_[j], dz = z_[i] - z_[j];
    const float dr = red_[i] - red_[j], dg = green_[i] - green_[j], db = blue_[i] - blue_[j];
    const float moved = dx * dx + dy * dy + dz * dz;
    // Squared differences: xx, yy and zz count once; xy, yz and xz twice, since the matrix is symmetric.
    float diagonal = 0, others = 0, sizes = 1e-30f;
    for (int k = 0; k < 3; ++k) {
      const float own = diagonal_[k][i] - diagonal_[k][j], other = others_[k][i] - others_[k][j];
      diagonal += own * own, others += other * other, sizes += diagonal_[k][i] + diagonal_[k][j];
    }
    const float reshaped = (diagonal + 2 * others) / sizes;
    const float coloured = (dr * dr + dg * dg + db * db) * sizes;
    // Finite where numbers leave the range of float, so that only nodes that are gone cost more.
    return std::min(std::numeric_limits<float>::max(),
                    (moved + reshaped + coloured) / (inverse_mass_[i] + inverse_mass_[j])) +
           gone_[j];
  }

  /// Returns what merging with each costs.
  Each<float> find_partner(std::size_t i) {
    Each<float> costs;
    for (std::size_t j = 0; j < count_; ++j) costs[j] = cost_of(i, j);
    costs[i] = never;
    const auto least = std::min_element(costs.begin(), costs.begin() + std::ptrdiff_t(count_));
    partner_[i] = std::size_t(least - costs.begin()), cost_[i] = *least;
    return costs;
  }

  void copy(Nodes& out, std::size_t to, std::size_t from) const {
    for_each_array(
        [&](const char*, std::size_t values, const auto& source, auto& target) {
          std::copy_n(source.begin() + std::ptrdiff_t(values * from), values,
                      target.begin() + std::ptrdiff_t(values * to));
        },
        nodes_.scene, out.scene);
    out.spread[to] = nodes_.spread[from];
  }

  void write_merged(Nodes& out, std::size_t to, const Moments& m) const {
    const detail::PrincipalAxes axes = detail::principal_axes(m.covariance);
    const dvec3 scale(std::sqrt(axes.lengths.x), std::sqrt(axes.lengths.y), std::sqrt(axes.lengths.z));
    const double area = shown_area(scale);
    Scene& scene = out.scene;
    scene.means[to] = vec3(m.mean), scene.scales[to] = vec3(scale);
    scene.rotations[to] = rounded(unit(quaternion_of(axes.directions)));
    scene.opacities[to] = area > 0 ? float(std::min(1.0, m.mass / area)) : 1.0f;
    scene.sh0[to] = m.sh0;
    std::copy_n(m.sh_rest.begin(), each_, scene.sh_rest.data() + each_ * to);
    out.spread[to] = float(std::min(m.spread, double(std::numeric_limits<float>::max())));
  }

  const Nodes& nodes_;
  std::size_t each_, count_;
  dvec3 origin_{0.0};
  Each<std::size_t> member_;
  Each<std::size_t> partner_;  ///< costs least; `none`: not known, and costs `cost_` or more
  Each<bool> merged_;
  Each<Moments> moments_;
  Each<float> diagonal_[3], others_[3];  ///< of covariances
  Each<float> x_, y_, z_, red_, green_, blue_, inverse_mass_, cost_;
  Each<float> gone_{};  ///< `never` of a node that merged into another, else 0: it adds to costs
};

Nodes joined(const Nodes& left, const Nodes& right) {
  Nodes all{empty_like(left.scene), left.spread};
  for_each_array(
      [](const char*, std::size_t, const auto& a, const auto& b, auto& to) {
        to.reserve(a.size() + b.size());
        to.insert(to.end(), a.begin(), a.end());
        to.insert(to.end(), b.begin(), b.end());
      },
      left.scene, right.scene, all.scene);
  all.spread.insert(all.spread.end(), right.spread.begin(), right.spread.end());
  return all;
}

/// Keeps `count` steps of all blocks, those that cost least; of equal ones those of the first blocks.
void keep_cheapest(std::vector<std::vector<Step>>& steps, std::size_t count) {
  if (count == 0) return steps.assign(steps.size(), {});
  std::vector<float> costs;
  for (const auto& block : steps)
    for (const Step& step : block) costs.push_back(step.cost);
  const auto last = costs.begin() + std::ptrdiff_t(count - 1);
  std::nth_element(costs.begin(), last, costs.end());
  auto equal = std::count(costs.begin(), last + 1, *last);
  for (auto& block : steps) {
    const auto end = std::find_if(block.begin(), block.end(), [&](const Step& step) {
      return step.cost > *last || (step.cost == *last && --equal < 0);
    });
    block.erase(end, block.end());
  }
}

}  // namespace

Nodes merge(const Nodes& left, const Nodes& right, int threads) {
  const Nodes all = joined(left, right);
  const std::size_t count = all.scene.size(), kept = (count + 1) / 2;
  const std::size_t each = 3 * std::size_t(sh_rest_count(all.scene.sh_degree));
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  order_by_halves(all.scene.means, order, count, block_size, threads);

  const std::size_t blocks = (count + block_size - 1) / block_size;
  const auto members = [&](std::size_t k) {
    return std::span<const std::uint32_t>(order).subspan(k * block_size,
                                                         std::min(block_size, count - k * block_size));
  };
  // More steps than needed: blocks where little is lost take more of them.
  std::vector<std::vector<Step>> steps(blocks);
  for_each_index(blocks, threads, [&](std::size_t k) {
    steps[k] = Block(all, members(k), each).merge_to((members(k).size() + 3) / 4);
  });
  keep_cheapest(steps, count - kept);

  Nodes out{empty_like(all.scene), std::vector<float>(kept)};
  for_each_array([&](const char*, std::size_t values, auto& array) { array.resize(values * kept); },
                 out.scene);
  std::vector<std::size_t> first(blocks);
  for (std::size_t k = 1; k < blocks; ++k)
    first[k] = first[k - 1] + members(k - 1).size() - steps[k - 1].size();
  for_each_index(blocks, threads, [&](std::size_t k) {
    Block block(all, members(k), each);
    for (const Step& step : steps[k]) block.take(step);
    block.write(out, first[k]);
  });
  return out;
}

void set_errors(Page& page, const Nodes& nodes) {
  const std::size_t count = nodes.spread.size();
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return nodes.spread[a] < nodes.spread[b]; });
  const auto merged =
      std::partition_point(order.begin(), order.end(), [&](std::uint32_t i) { return nodes.spread[i] == 0; });
  const auto middle = merged + (order.end() - merged) / 2;
  const double median = middle == order.end() ? 0 : std::sqrt(double(nodes.spread[*middle]));
  page.finest = std::clamp(float(median / 8), 1e-20f, 1e20f);
  double pixel = page.finest;
  for (float& error : page.errors) {
    // A pixel shows of a node what lies in it, so small nodes count more where pixels are large. Large
    // Gaussians that did not merge would hide how far off the others are.
    const auto shown = [&](std::uint32_t i) {
      if (nodes.spread[i] == 0) return 0.0;
      return double(nodes.scene.opacities[i]) * (shown_area(nodes.scene.scales[i]) + pixel * pixel);
    };
    double all = 0, below = 0;
    for (const std::uint32_t i : order) all += shown(i);
    std::size_t k = 0;
    while (k + 1 < count && (below += shown(order[k])) < 0.9 * all) ++k;
    error = float(std::sqrt(double(nodes.spread[order[k]])));
    pixel *= 4;
  }
}

}  // namespace swiftgs::pages
