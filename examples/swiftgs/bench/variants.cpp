// SPDX-License-Identifier: Apache-2.0

#include "bench/variants.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/edit/select.hpp>

#include "words.hpp"

namespace swiftgs::cli {
namespace {

template <class Number>
std::vector<Number> parsed(const std::string& option, const std::string& text, const char* expected) {
  std::vector<Number> numbers;
  for (const std::string& part : list_of(option, text)) {
    const std::optional<Number> number = parse<Number>(part);
    if (!number)
      throw std::invalid_argument(option + " '" + text + "': expected " + expected + " separated by commas");
    if (std::find(numbers.begin(), numbers.end(), *number) != numbers.end())
      throw std::invalid_argument(option + " '" + text + "': expected every value once");
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

std::vector<std::string> list_of(const std::string& option, const std::string& text) {
  const std::vector<std::string_view> split_text = split(text, ',');
  const std::vector<std::string> parts(split_text.begin(), split_text.end());
  if (std::any_of(parts.begin(), parts.end(), [](const std::string& part) { return part.empty(); }))
    throw std::invalid_argument(option + " '" + text + "': expected values separated by commas");
  for (auto part = parts.begin(); part != parts.end(); ++part)
    if (std::find(parts.begin(), part, *part) != part)
      throw std::invalid_argument(option + " '" + text + "': expected every value once");
  return parts;
}

std::vector<double> numbers_of(const std::string& option, const std::string& text) {
  return parsed<double>(option, text, "numbers");
}

std::vector<std::size_t> counts_of(const std::string& option, const std::string& text) {
  return parsed<std::size_t>(option, text, "whole numbers");
}

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

/// Makes pieces of `parts` copies of a Gaussian, from number `first` on.
void divide(Scene& scene, std::size_t first, std::size_t parts) {
  const vec3 mean = scene.means[first], scale = scene.scales[first];
  const int axis = scale.x >= scale.y && scale.x >= scale.z ? 0 : scale.y >= scale.z ? 1 : 2;
  const double n = double(parts);
  // Pieces at a regular distance d have a variance of d^2 (n^2 - 1) / 12 about their middle, and 1 / n^2
  // each.
  const float distance = parts > 1 ? float(std::sqrt(12 / (n * n)) * scale[axis]) : 0;
  const vec3 along = direction(scene.rotations[first], axis);
  for (std::size_t piece = 0; piece < parts; ++piece) {
    scene.means[first + piece] = mean + along * (distance * float(double(piece) - 0.5 * (n - 1)));
    scene.scales[first + piece][axis] /= float(parts);
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
  Shares shares(scene.size(), count, seed);
  std::vector<std::uint32_t> sources;
  sources.reserve(count);
  for (std::size_t i = 0; i < scene.size(); ++i)
    sources.insert(sources.end(), shares.next(), std::uint32_t(i));
  Scene result = subset(scene, sources);
  for (std::size_t first = 0, next = 0; first < count; first = next) {
    while (next < count && sources[next] == sources[first]) ++next;
    divide(result, first, next - first);
  }
  return result;
}

Scene enlarged(Scene scene, double factor) {
  require_factor(factor);
  for (vec3& scale : scene.scales) scale *= float(factor);
  return scene;
}

}  // namespace swiftgs::cli
