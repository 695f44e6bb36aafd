// SPDX-License-Identifier: Apache-2.0
#include "nearest_points.hpp"

#include <algorithm>
#include <limits>

// Compile the rest of this file for every target; the order of these lines matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "nearest_points.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace swiftgs::io::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using F32 = hn::CappedTag<float, 16>;
using Vec = hn::Vec<F32>;
constexpr std::size_t lanes = hn::MaxLanes(F32());
constexpr std::size_t at_once = 6;  // points, each with two vectors of sums: what 16 registers hold

/// Calls `take(tile, column, sums)` for all columns of `table`, two vectors at a time: `sums[p][v]` is the
/// score of point p.
template <class Take>
HWY_INLINE void ForScores(const float* const* points, const PointTable& table, const Take& take) {
  const F32 d;
  const std::size_t width = table.width();
  for (std::size_t t = 0; t < table.tiles(); ++t) {
    const float* const tile = table.tile_data(t);
    for (std::size_t column = 0; column < PointTable::tile; column += 2 * lanes) {
      const float* from = tile + column;
      const Vec a = hn::LoadU(d, from + width * PointTable::tile);
      const Vec b = hn::LoadU(d, from + width * PointTable::tile + lanes);
      Vec a0 = a, a1 = a, a2 = a, a3 = a, a4 = a, a5 = a;
      Vec b0 = b, b1 = b, b2 = b, b3 = b, b4 = b, b5 = b;
      for (std::size_t k = 0; k < width; ++k, from += PointTable::tile) {
        const Vec x = hn::LoadU(d, from), y = hn::LoadU(d, from + lanes);
        Vec p = hn::Set(d, points[0][k]);
        a0 = hn::MulAdd(p, x, a0), b0 = hn::MulAdd(p, y, b0);
        p = hn::Set(d, points[1][k]);
        a1 = hn::MulAdd(p, x, a1), b1 = hn::MulAdd(p, y, b1);
        p = hn::Set(d, points[2][k]);
        a2 = hn::MulAdd(p, x, a2), b2 = hn::MulAdd(p, y, b2);
        p = hn::Set(d, points[3][k]);
        a3 = hn::MulAdd(p, x, a3), b3 = hn::MulAdd(p, y, b3);
        p = hn::Set(d, points[4][k]);
        a4 = hn::MulAdd(p, x, a4), b4 = hn::MulAdd(p, y, b4);
        p = hn::Set(d, points[5][k]);
        a5 = hn::MulAdd(p, x, a5), b5 = hn::MulAdd(p, y, b5);
      }
      const std::size_t first = t * PointTable::tile + column;
      take(first, 0, a0, b0), take(first, 1, a1, b1), take(first, 2, a2, b2);
      take(first, 3, a3, b3), take(first, 4, a4, b4), take(first, 5, a5, b5);
    }
  }
}

/// `at_once` points from `first` on; the last is repeated where there are fewer.
HWY_INLINE void Gather(const Points& points, std::span<const std::uint32_t> ids, std::size_t first,
                       const float** rows) {
  for (std::size_t p = 0; p < at_once; ++p) rows[p] = points[ids[std::min(first + p, ids.size() - 1)]];
}

HWY_ATTR void FindNearest(const Points& points, std::span<const std::uint32_t> ids, const PointTable& table,
                          std::uint32_t* nearest) {
  const F32 d;
  const hn::RebindToUnsigned<F32> du;
  const float* rows[at_once];
  for (std::size_t first = 0; first < ids.size(); first += at_once) {
    Gather(points, ids, first, rows);
    HWY_ALIGN float best[at_once][lanes];
    HWY_ALIGN std::uint32_t place[at_once][lanes];
    for (std::size_t p = 0; p < at_once; ++p) {
      hn::Store(hn::Set(d, -std::numeric_limits<float>::infinity()), d, best[p]);
      hn::Store(hn::Zero(du), du, place[p]);
    }
    ForScores(rows, table, [&](std::size_t column, std::size_t p, Vec a, Vec b) HWY_ATTR {
      Vec most = hn::Load(d, best[p]);
      auto at = hn::Load(du, place[p]);
      const auto improve = [&](Vec score, std::size_t from) HWY_ATTR {
        const auto better = hn::Gt(score, most);
        most = hn::IfThenElse(better, score, most);
        at = hn::IfThenElse(hn::RebindMask(du, better), hn::Iota(du, std::uint32_t(from)), at);
      };
      improve(a, column), improve(b, column + lanes);
      hn::Store(most, d, best[p]), hn::Store(at, du, place[p]);
    });
    for (std::size_t p = 0; p < std::min(at_once, ids.size() - first); ++p) {
      std::size_t lane = 0;
      for (std::size_t l = 1; l < lanes; ++l)
        if (best[p][l] > best[p][lane] || (best[p][l] == best[p][lane] && place[p][l] < place[p][lane]))
          lane = l;
      nearest[first + p] = place[p][lane];
    }
  }
}

HWY_ATTR void Score(const Points& points, std::span<const std::uint32_t> ids, const PointTable& table,
                    float* scores) {
  const F32 d;
  const std::size_t stride = table.tiles() * PointTable::tile;
  const float* rows[at_once];
  for (std::size_t first = 0; first < ids.size(); first += at_once) {
    Gather(points, ids, first, rows);
    ForScores(rows, table, [&](std::size_t column, std::size_t p, Vec a, Vec b) HWY_ATTR {
      if (first + p >= ids.size()) return;
      float* const to = scores + (first + p) * stride + column;
      hn::StoreU(a, d, to), hn::StoreU(b, d, to + lanes);
    });
  }
}

/// The first `count` lanes from `from` on, and zeros; what lies behind them is not read.
template <class D>
HWY_INLINE hn::Vec<D> LoadFirst(D d, const float* from, std::size_t count) {
  if (count == 0) return hn::Zero(d);
#if HWY_MEM_OPS_MIGHT_FAULT
  HWY_ALIGN float first[hn::MaxLanes(D())] = {};
  std::copy_n(from, count, first);
  return hn::Load(d, first);
#else
  return hn::MaskedLoad(hn::FirstN(d, count), d, from);
#endif
}

HWY_ATTR void Project(const Points& points, std::span<const std::uint32_t> ids, const float* direction,
                      float* products) {
  const F32 d;
  const std::size_t width = points.width, whole = width / lanes * lanes;
  const Vec last = LoadFirst(d, direction + whole, width - whole);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const float* const row = points[ids[i]];
    Vec sum = hn::Mul(LoadFirst(d, row + whole, width - whole), last);
    for (std::size_t k = 0; k < whole; k += lanes)
      sum = hn::MulAdd(hn::LoadU(d, row + k), hn::LoadU(d, direction + k), sum);
    products[i] = hn::GetLane(hn::SumOfLanes(d, sum));
  }
}

using F64 = hn::CappedTag<double, 8>;
constexpr std::size_t doubles = hn::MaxLanes(F64());

/// Adds all points to `sums`: `take(i, sum, coordinates)` returns the next sum.
template <class Take>
HWY_INLINE void AddUp(const Points& points, std::span<const std::uint32_t> ids, double* sums,
                      const Take& take) {
  const F64 d;
  const hn::Rebind<float, F64> df;
  HWY_ALIGN std::array<double, most_width + doubles> each{};
  std::copy_n(sums, points.width, each.begin());
  const std::size_t whole = points.width / doubles * doubles;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const float* const point = points[ids[i]];
    const auto add = [&](std::size_t k, auto floats) HWY_ATTR {
      hn::StoreU(take(i, hn::LoadU(d, each.data() + k), hn::PromoteTo(d, floats)), d, each.data() + k);
    };
    for (std::size_t k = 0; k < whole; k += doubles) add(k, hn::LoadU(df, point + k));
    add(whole, LoadFirst(df, point + whole, points.width - whole));
  }
  std::copy_n(each.begin(), points.width, sums);
}

HWY_ATTR void AddPoints(const Points& points, std::span<const std::uint32_t> ids, Sums& sums) {
  auto squares = hn::Zero(F64());
  AddUp(points, ids, sums.first.data(), [&](std::size_t, auto sum, auto x) HWY_ATTR {
    squares = hn::MulAdd(x, x, squares);
    return hn::Add(sum, x);
  });
  sums.second += hn::GetLane(hn::SumOfLanes(F64(), squares));
}

HWY_ATTR void AddWeighted(const Points& points, std::span<const std::uint32_t> ids, const float* weights,
                          double* sums) {
  AddUp(points, ids, sums, [&](std::size_t i, auto sum, auto x) HWY_ATTR {
    return hn::MulAdd(hn::Set(F64(), double(weights[i])), x, sum);
  });
}

}  // namespace swiftgs::io::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace swiftgs::io {
namespace {
HWY_EXPORT(FindNearest);
HWY_EXPORT(Score);
HWY_EXPORT(Project);
HWY_EXPORT(AddPoints);
HWY_EXPORT(AddWeighted);
}  // namespace

void PointTable::assign(const Points& points, std::span<const std::uint32_t> ids) {
  width_ = points.width;
  data_.assign((ids.size() + tile - 1) / tile * floats_of_tile(), 0);
  for (std::size_t t = 0; t * tile < ids.size(); ++t) {
    float* const to = data_.data() + t * floats_of_tile();
    float* const half_squares = to + width_ * tile;
    std::fill(half_squares, half_squares + tile, -std::numeric_limits<float>::infinity());
    for (std::size_t i = 0; i < std::min(tile, ids.size() - t * tile); ++i) {
      const float* const point = points[ids[t * tile + i]];
      float squared = 0;
      for (std::size_t k = 0; k < width_; ++k) {
        to[k * tile + i] = point[k];
        squared += point[k] * point[k];
      }
      half_squares[i] = -squared / 2;
    }
  }
}

void find_nearest(const Points& points, std::span<const std::uint32_t> ids, const PointTable& table,
                  std::uint32_t* nearest) {
  if (!ids.empty()) HWY_DYNAMIC_DISPATCH(FindNearest)(points, ids, table, nearest);
}

void score(const Points& points, std::span<const std::uint32_t> ids, const PointTable& table, float* scores) {
  if (!ids.empty()) HWY_DYNAMIC_DISPATCH(Score)(points, ids, table, scores);
}

void project(const Points& points, std::span<const std::uint32_t> ids, const float* direction,
             float* products) {
  HWY_DYNAMIC_DISPATCH(Project)(points, ids, direction, products);
}

void add_up(const Points& points, std::span<const std::uint32_t> ids, Sums& sums) {
  HWY_DYNAMIC_DISPATCH(AddPoints)(points, ids, sums);
}

void add_weighted(const Points& points, std::span<const std::uint32_t> ids, const float* weights,
                  std::array<double, most_width>& sums) {
  HWY_DYNAMIC_DISPATCH(AddWeighted)(points, ids, weights, sums.data());
}

}  // namespace swiftgs::io
#endif
