// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Distances between two images of the same size. Images are arrays of float or double (a `std::vector`, a
/// `Span`, anything with `begin` and `end`), and the arithmetic is double.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <vector>

#include <swiftgs/error.hpp>

namespace swiftgs {

namespace metrics {

/// Throws `InvalidArgument` unless `a` and `b` have the same number of values, above 0.
template <class A, class B>
void require_same_size(const A& a, const B& b) {
  const auto size_a = std::distance(a.begin(), a.end()), size_b = std::distance(b.begin(), b.end());
  if (size_a != size_b || size_a == 0)
    detail::refuse("metrics: expected two images with the same number of values, got ", size_a, " and ",
                   size_b);
}

/// |a - b|; 0 for equal infinities, NaN where one is NaN.
inline double distance(double a, double b) { return a == b ? 0 : std::abs(a - b); }

}  // namespace metrics

/// Peak signal-to-noise ratio of `a` against `b` over all values @units{dB}; `peak` is the largest value that
/// an image can have. Infinity when all are equal, NaN when one is NaN. Throws `InvalidArgument` when the
/// sizes differ or are 0.
template <class A, class B>
double psnr(const A& a, const B& b, double peak = 1) {
  metrics::require_same_size(a, b);
  double sum = 0, count = 0;
  auto other = b.begin();
  for (const double value : a) {
    const double d = metrics::distance(value / peak, double(*other++) / peak);
    sum += d * d, ++count;
  }
  return -10 * std::log10(sum / count);
}

/// Largest difference between a value of `a` and its counterpart in `b`; NaN when one is NaN. Throws
/// `InvalidArgument` when the sizes differ or are 0.
template <class A, class B>
double max_abs_difference(const A& a, const B& b) {
  metrics::require_same_size(a, b);
  double largest = 0;
  auto other = b.begin();
  for (const double value : a) {
    const double d = metrics::distance(value, double(*other++));
    if (std::isnan(d)) return d;
    largest = std::max(largest, d);
  }
  return largest;
}

namespace metrics {

/// Weighted means over a window: of both images, their squares, and their product.
struct Moments {
  double a = 0, b = 0, aa = 0, bb = 0, ab = 0;

  void add(double weight, const Moments& m) {
    a += weight * m.a, b += weight * m.b;
    aa += weight * m.aa, bb += weight * m.bb, ab += weight * m.ab;
  }

  /// Structural similarity of the two images in this window.
  double similarity() const {
    constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const double luminance = (2 * a * b + c1) / (a * a + b * b + c1);
    return luminance * (2 * (ab - a * b) + c2) / ((aa - a * a) + (bb - b * b) + c2);
  }
};

/// One axis of the window: a Gaussian of standard deviation 1.5 over 11 pixels, or over `side` if that is
/// less; the weights add to 1.
inline std::vector<double> ssim_weights(int side) {
  std::vector<double> weights(std::size_t(std::min(side, 11)));
  const double centre = 0.5 * double(weights.size() - 1);
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double d = (double(i) - centre) / 1.5;
    sum += weights[i] = std::exp(-0.5 * d * d);
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// Moments of one image row over each horizontal window. `a` and `b` point to the row's first value of one
/// channel; `step` is the distance to the next pixel.
template <class A, class B>
void filter_row(const A& a, const B& b, std::ptrdiff_t step, const std::vector<double>& weights,
                std::vector<Moments>& row) {
  for (std::size_t x = 0; x < row.size(); ++x) {
    row[x] = {};
    for (std::size_t k = 0; k < weights.size(); ++k) {
      const double va = double(a[std::ptrdiff_t(x + k) * step]), vb = double(b[std::ptrdiff_t(x + k) * step]);
      row[x].add(weights[k], {va, vb, va * va, vb * vb, va * vb});
    }
  }
}

/// Mean structural similarity of one channel, as `ssim` below.
template <class A, class B>
double ssim_channel(int width, int height, std::ptrdiff_t channels, const A& a, const B& b) {
  const std::vector<double> across = ssim_weights(width), down = ssim_weights(height);
  const std::size_t columns = std::size_t(width) - across.size() + 1;
  // The filtered rows that the vertical window spans, in a ring: row y is at y mod the window's height.
  std::vector<std::vector<Moments>> ring(down.size(), std::vector<Moments>(columns));
  double sum = 0;
  for (std::size_t y = 0; y < std::size_t(height); ++y) {
    const std::ptrdiff_t first = std::ptrdiff_t(y) * width * channels;
    filter_row(a + first, b + first, channels, across, ring[y % down.size()]);
    if (y + 1 < down.size()) continue;
    const std::size_t top = y + 1 - down.size();
    for (std::size_t x = 0; x < columns; ++x) {
      Moments window;
      for (std::size_t k = 0; k < down.size(); ++k) window.add(down[k], ring[(top + k) % down.size()][x]);
      sum += window.similarity();
    }
  }
  return sum / (double(columns) * double(std::size_t(height) - down.size() + 1));
}

}  // namespace metrics

/// Structural similarity (Wang et al. 2004) for values in [0, 1]: 11x11 Gaussian window of standard deviation
/// 1.5, K1 = 0.01, K2 = 0.03, mean over all windows that lie inside the image and over the channels. In an
/// image less than 11 pixels wide or high the window is as wide or high as the image.
/// @shape{height, width, channels} Throws `InvalidArgument` when the sizes differ, are 0, or are not
/// width * height * channels.
template <class A, class B>
double ssim(int width, int height, int channels, const A& a, const B& b) {
  metrics::require_same_size(a, b);
  if (width <= 0 || height <= 0 || channels <= 0 ||
      std::distance(a.begin(), a.end()) != std::ptrdiff_t(width) * height * channels)
    detail::refuse("ssim: expected ", width, " x ", height, " x ", channels, " values, got ",
                   std::distance(a.begin(), a.end()));
  double sum = 0;
  for (int channel = 0; channel < channels; ++channel)
    sum += metrics::ssim_channel(width, height, channels, a.begin() + channel, b.begin() + channel);
  return sum / channels;
}

}  // namespace swiftgs
