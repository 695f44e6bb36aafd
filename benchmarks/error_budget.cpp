// SPDX-License-Identifier: Apache-2.0

/// @file
/// Where frames lose digits: draws views as `Serial` does, but with one term after the other exact, or all of
/// them but one. docs/stability.md shows the rows that carry the point.

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <swiftgs/project/project.hpp>
#include <swiftgs/serial.hpp>
#include <swiftgs/swiftgs.hpp>
#include <swiftgs/tools/parallel.hpp>

#include "inputs.hpp"
#include "reference/rendering.hpp"

namespace {

using namespace swiftgs;
using reference::Splat;

/// What renderers round to float on the way from a scene to a pixel.
enum Term : unsigned { mean, factor_, exponent, exponential, opacity, colour, blending, ties, term_count };

constexpr std::string_view term_names[term_count] = {
    "mean",      "stored factor", "exponent",     "exponential", "opacity, cutoff and alpha",
    "harmonics", "blending",      "order of ties"};

/// A bit for each term that is exact.
using Terms = unsigned;
constexpr Terms none = 0, all = (1u << term_count) - 1;
constexpr Terms only(Term term) { return 1u << term; }
bool has(Terms exact, Term term) { return (exact & only(term)) != 0; }

/// Terms that are not exact round each of their operations to float, as float arithmetic does.
double rounded_unless(bool exact, double value) { return exact ? value : double(float(value)); }

/// A splat as renderers in float project it.
struct Rounded {
  ProjectedShape projected;
  vec3 rgb{0};
};

/// Base-2 exponent of a splat along a row of pixels.
class RowExponent {
 public:
  RowExponent(const Splat& splat, const SplatShape& shape, Terms exact, float y)
      : splat_(splat), shape_(shape), exact_mean_(has(exact, mean)), wide_(has(exact, exponent)) {
    const double dy = exact_mean_ ? y - splat.y : double(shape.below_mean(y));
    double l1 = shape.l1, l2 = shape.l2;
    l0_ = shape.l0;
    if (has(exact, factor_)) {
      l0_ = to_base_2 * std::sqrt(splat.x_weight), l1 = -l0_ * splat.shear;
      l2 = to_base_2 * std::sqrt(splat.y_weight);
    }
    q_ = rounded(l1 * dy);
    const double v = rounded(l2 * dy);
    r_ = rounded(v * v);
  }
  double at(float x) const {
    const double dx = exact_mean_ ? x - splat_.x : double(shape_.right_of_mean(x));
    const double u = rounded(rounded(l0_ * dx) + q_);
    return rounded(rounded(u * u) + r_);
  }

 private:
  double rounded(double value) const { return rounded_unless(wide_, value); }

  const Splat& splat_;
  const SplatShape& shape_;
  bool exact_mean_, wide_;
  double l0_, q_, r_;
};

struct Pixel {
  double rgb[3]{}, transmittance = 1;
  bool stopped = false;
};

/// One view of a scene, drawn with any terms exact.
class BudgetView {
 public:
  BudgetView(const Scene& scene, const Camera& camera)
      : camera_(camera),
        conventions_(as_trained(Conventions::gsplat(), scene.model)),
        view_(camera, conventions_, ReferenceScene{scene}),
        chunks_(reference::project_all({view_}, thread_count(0))),
        strips_(reference::sort_into_strips(chunks_, camera.height)),
        rounded_(scene.size()) {
    const View in_float = make_view(camera, conventions_, {.width = camera.width, .height = camera.height});
    rules_ = in_float.rules;
    const SceneView stored = swiftgs::view(scene);
    for_each_index(chunks_.size(), thread_count(0), [&](std::size_t chunk) {
      for (const Splat& splat : chunks_[chunk]) {
        Rounded& out = rounded_[splat.index];
        out.projected = project_shape(in_float.camera, gaussian(stored, splat.index));
        out.rgb = splat_colour(project_colour(in_float.camera, stored, splat.index), 1).rgb;
      }
    });
  }

  /// RGB of all pixels. A pixel keeps a splat where it would if the terms `deciding` were the exact ones.
  std::vector<double> draw(Terms exact, Terms deciding) const {
    std::vector<Pixel> pixels(std::size_t(camera_.width) * std::size_t(camera_.height));
    for_each_index(strips_.size(), thread_count(0), [&](std::size_t strip) {
      const int first = int(strip) * reference::strip_rows;
      const int last = std::min(camera_.height, first + reference::strip_rows);
      for (const Splat* splat : ordered(strips_[strip], exact))
        for (int y = std::max(first, splat->y_begin); y < std::min(last, splat->y_end); ++y)
          blend_row(&pixels[std::size_t(y) * std::size_t(camera_.width)], y, *splat, exact, deciding);
    });
    std::vector<double> image;
    for (const Pixel& pixel : pixels) image.insert(image.end(), pixel.rgb, pixel.rgb + 3);
    return image;
  }

 private:
  std::vector<const Splat*> ordered(std::vector<const Splat*> splats, Terms exact) const {
    const auto depth = [&](const Splat* splat) { return rounded_[splat->index].projected.depth; };
    if (!has(exact, ties))
      std::sort(splats.begin(), splats.end(), [&](const Splat* a, const Splat* b) {
        return depth(a) != depth(b) ? depth(a) < depth(b) : a->index < b->index;
      });
    return splats;
  }

  void blend_row(Pixel* pixels, int y, const Splat& splat, Terms exact, Terms deciding) const {
    const Rounded& stored = rounded_[splat.index];
    const SplatShape& shape = stored.projected.shape;
    if (!stored.projected.visible) return;  // no pixel keeps it
    const float at_y = float(y) + 0.5f;
    const double cutoff =
        has(deciding, opacity) ? std::log2(splat.opacity / double(rules_.alpha_min)) : double(shape.cutoff);
    const double most = has(exact, opacity) ? splat.opacity : double(shape.opacity);
    const RowExponent exponents(splat, shape, exact, at_y), decisions(splat, shape, deciding, at_y);

    // Pixels that may keep the splat, and one more to either side.
    const double dy = at_y - splat.y, left = splat.cutoff - splat.y_weight * dy * dy;
    const double half = std::sqrt(std::max(0.0, left) / splat.x_weight) + 1;
    const double middle = splat.x + splat.shear * dy - 0.5;
    const auto column = [&](double x) { return int(std::clamp(x, 0.0, double(camera_.width))); };
    const int end = column(std::floor(middle + half) + 1);
    for (int x = column(std::ceil(middle - half)); x < end; ++x) {
      if (pixels[x].stopped) continue;
      const float at_x = float(x) + 0.5f;
      const double s = exponents.at(at_x);
      if ((deciding == exact ? s : decisions.at(at_x)) > cutoff) continue;
      const double part = has(exact, exponential) ? std::exp2(-s) : double(std::exp2(-float(s)));
      const double alpha = rounded_unless(has(exact, opacity), most * part);
      blend(pixels[x], std::min(alpha, double(rules_.alpha_max)), splat, stored.rgb, exact);
    }
  }

  void blend(Pixel& pixel, double alpha, const Splat& splat, const vec3& rgb, Terms exact) const {
    const bool wide = has(exact, blending);
    const double before = pixel.transmittance;
    const double next = wide ? before * (1 - alpha) : double(dimmed(float(before), float(alpha)));
    const bool stops = !wide                        ? next < double(rules_.stop_below)
                       : conventions_.stop_at_equal ? next <= double(conventions_.stop)
                                                    : next < double(conventions_.stop);
    if (stops) {
      pixel.stopped = true;
      return;
    }
    const double weight = rounded_unless(wide, rounded_unless(wide, alpha) * before);
    for (int c = 0; c < 3; ++c) {
      const double value = has(exact, colour) ? splat.colour[c] : double(rgb[c]);
      pixel.rgb[c] = rounded_unless(wide, pixel.rgb[c] + rounded_unless(wide, weight * value));
    }
    pixel.transmittance = next;
  }

  Camera camera_;
  Conventions conventions_;
  BlendRules rules_{};
  reference::View view_;
  reference::SplatChunks chunks_;
  std::vector<std::vector<const Splat*>> strips_;
  std::vector<Rounded> rounded_;  ///< by the index of the Gaussian
};

/// Prints a row: how far `image` is from `expected`. A pixel that is further off than `flip` has most likely
/// kept a splat that the reference skips, or the reverse.
template <class Image>
void print_row(const std::string& what, const Image& image, const std::vector<double>& expected) {
  constexpr double flip = 0x1p-17;
  double of_flips = 0, of_others = 0, largest = 0;
  std::size_t flips = 0;
  for (std::size_t i = 0; i < expected.size(); i += 3) {
    double squares = 0, worst = 0;
    for (std::size_t c = i; c < i + 3; ++c) {
      const double error = double(image[c]) - expected[c];
      squares += error * error, worst = std::max(worst, std::abs(error));
    }
    largest = std::max(largest, worst), flips += worst > flip;
    (worst > flip ? of_flips : of_others) += squares;
  }
  const auto decibels = [&](double squares) { return -10 * std::log10(squares / double(expected.size())); };
  std::printf("| %s | %.1f | %.1e | %zu | %.1f |\n", what.c_str(), decibels(of_flips + of_others), largest,
              flips, decibels(of_others));
  std::fflush(stdout);
}

void print_table(const bench::Input& input, std::size_t number) {
  const Scene scene = input.load();
  const Camera& camera = input.views.at(number);
  const std::vector<double> expected =
      render_reference(scene, camera, as_trained(Conventions::gsplat(), scene.model)).colour;
  std::printf("\n%s, view %zu, %dx%d:\n\n", input.name.c_str(), number, camera.width, camera.height);
  std::printf("| what is exact | dB | largest error | pixels off by 2^-17 | dB of the others |\n");
  std::printf("| --- | ---: | ---: | ---: | ---: |\n");
  Renderer<Serial> renderer;
  const auto uploaded = renderer.backend().upload(scene);
  print_row("nothing, by `serial`", renderer.render(uploaded, camera).colour, expected);

  const BudgetView view(scene, camera);
  const auto row = [&](const std::string& what, Terms exact, Terms deciding) {
    print_row(what, view.draw(exact, deciding), expected);
  };
  row("nothing", none, none);
  row("decisions at `alpha_min`", none, all);
  for (unsigned term = 0; term < term_count; ++term)
    row(std::string(term_names[term]), only(Term(term)), only(Term(term)));
  row("all but decisions at `alpha_min`", all, none);
  for (unsigned term = 0; term < term_count; ++term)
    row("all but " + std::string(term_names[term]), all & ~only(Term(term)), all & ~only(Term(term)));
  row("all", all, all);
  print_row("all, rounded to float at the end", std::vector<float>(expected.begin(), expected.end()),
            expected);
}

std::size_t number_of(std::string_view text, const bench::Input& input) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number >= input.views.size())
    throw std::invalid_argument("view '" + std::string(text) + "' of " + input.name + ": expected 0 to " +
                                std::to_string(input.views.size() - 1));
  return number;
}

}  // namespace

/// error_budget (SCENE VIEW)...: a table of each view, in Markdown. VIEW counts the views that benchmarks
/// draw, every eighth of a capture's.
int main(int argc, char** argv) try {
  if (argc < 3 || argc % 2 == 0) {
    std::cerr
        << "usage: error_budget (SCENE VIEW)...; expected a capture or builtin:N, and a view's number\n";
    return 2;
  }
  for (int i = 1; i < argc; i += 2) {
    const bench::Input input = bench::inputs_named({argv[i]}).at(0);
    print_table(input, number_of(argv[i + 1], input));
  }
  return 0;
} catch (const std::exception& error) {
  std::cerr << "error_budget: " << error.what() << '\n';
  return 1;
}
