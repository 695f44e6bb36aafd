// SPDX-License-Identifier: Apache-2.0
#include "bench/variants.hpp"

#include <cmath>
#include <random>
#include <stdexcept>
#include <string>

#include "number_text.hpp"

namespace swiftgs::cli {
namespace {

/// How many Gaussians each of `size` becomes, `count` in all: numbers that differ by one at most, chosen one
/// after the other with the chance that is left.
class Shares {
 public:
  Shares(std::size_t size, std::size_t count, std::uint32_t seed)
      : each_(count / size), more_(count % size), left_(size), random_(seed) {}

  std::size_t next() {
    const bool one_more = std::uniform_int_distribution<std::size_t>(0, left_-- - 1)(random_) < more_;
    if (one_more) --more_;
    return each_ + (one_more ? 1 : 0);
  }

 private:
  std::size_t each_, more_, left_;
  std::mt19937_64 random_;
};

/// World direction of local axis `axis`.
vec3 direction(const Quaternion& q, int axis) {
  const float w = q.w, x = q.x, y = q.y, z = q.z;
  if (axis == 0) return {1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)};
  if (axis == 1) return {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)};
  return {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
}

/// Adds `parts` pieces of Gaussian `i`.
void add_pieces(const Scene& scene, std::size_t i, std::size_t parts, Scene& to) {
  const std::size_t rest = 3 * std::size_t(sh_rest_count(scene.sh_degree));
  const vec3 scale = scene.scales[i];
  const int axis = scale.x >= scale.y && scale.x >= scale.z ? 0 : scale.y >= scale.z ? 1 : 2;
  const double n = double(parts);
  // Pieces at a regular distance d have a variance of d^2 (n^2 - 1) / 12 about their middle, and 1 / n^2
  // each.
  const float distance = parts > 1 ? float(std::sqrt(12 / (n * n)) * scale[axis]) : 0;
  for (std::size_t piece = 0; piece < parts; ++piece) {
    vec3 shorter = scale;
    shorter[axis] /= float(parts);
    to.means.push_back(scene.means[i] + direction(scene.rotations[i], axis) *
                                            (distance * float(double(piece) - 0.5 * (n - 1))));
    to.scales.push_back(shorter);
    to.rotations.push_back(scene.rotations[i]);
    to.opacities.push_back(scene.opacities[i]);
    to.sh0.push_back(scene.sh0[i]);
    const float* const from = scene.sh_rest.data() + i * rest;
    to.sh_rest.insert(to.sh_rest.end(), from, from + rest);
  }
}

}  // namespace

void require_count(std::size_t count) {
  constexpr std::size_t most = 100'000'000;
  if (count == 0 || count > most)
    throw std::invalid_argument("--gaussians " + std::to_string(count) + ": expected numbers from 1 to " +
                                std::to_string(most));
}

void require_factor(double factor) {
  if (!(factor >= 1e-3 && factor <= 1e3))
    throw std::invalid_argument("--enlarge " + text_of_number(factor) +
                                ": expected factors from 0.001 to 1000");
}

Scene with_count(const Scene& scene, std::size_t count, std::uint32_t seed) {
  require_count(count);
  if (count == scene.size()) return scene;
  if (scene.size() == 0) throw std::invalid_argument("--gaussians: expected a scene that is not empty");
  Scene result;
  result.sh_degree = scene.sh_degree, result.antialiased = scene.antialiased;
  result.means.reserve(count), result.scales.reserve(count), result.rotations.reserve(count);
  result.opacities.reserve(count), result.sh0.reserve(count);
  result.sh_rest.reserve(count * 3 * std::size_t(sh_rest_count(scene.sh_degree)));
  Shares shares(scene.size(), count, seed);
  for (std::size_t i = 0; i < scene.size(); ++i) add_pieces(scene, i, shares.next(), result);
  return result;
}

Scene enlarged(Scene scene, double factor) {
  require_factor(factor);
  for (vec3& scale : scene.scales) scale *= float(factor);
  return scene;
}

}  // namespace swiftgs::cli
