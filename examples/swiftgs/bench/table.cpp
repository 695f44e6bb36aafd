// SPDX-License-Identifier: Apache-2.0
#include "bench/table.hpp"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <map>
#include <tuple>

namespace swiftgs::cli {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// One renderer over the views of one table.
struct Mean {
  std::string renderer;
  int views = 0, judged = 0, photographed = 0;
  double project = 0, sort = 0, raster = 0, total = 0, wall = 0, uncertain = 0;
  double psnr_db = infinity, max_abs = 0, photo_psnr_db = 0;

  void add(const RowResult& row) {
    ++views;
    project += row.ms.project.median, sort += row.ms.sort.median, raster += row.ms.raster.median;
    total += row.ms.total.median, wall += row.ms.wall.median;
    uncertain = std::max(uncertain, (row.ms.total.high - row.ms.total.low) / (2 * row.ms.total.median));
    if (row.errors) {
      ++judged;
      psnr_db = std::min(psnr_db, row.errors->psnr_db), max_abs = std::max(max_abs, row.errors->max_abs);
    }
    if (row.photo) ++photographed, photo_psnr_db += row.photo->psnr_db;
  }
};

using Table = std::tuple<std::string, std::size_t, double, double, std::string, int>;

Table table_of(const RowResult& row) {
  const Place& p = row.place;
  return {p.scene, p.gaussians, p.enlarge, p.scale, p.conventions, row.threads};
}

void print_heading(const RowResult& row) {
  const Place& p = row.place;
  std::printf("\n%s: %zu Gaussians, %dx%d, %s conventions, %d threads", p.scene.c_str(), p.gaussians, p.width,
              p.height, p.conventions.c_str(), row.threads);
  if (p.enlarge != 1) std::printf(", scales times %g", p.enlarge);
  std::printf(
      "\n\n| renderer | views | project | sort | raster | total ms | within | wall ms | worst dB | max abs | "
      "photo dB |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
}

void print_mean(const Mean& m) {
  const double n = m.views;
  std::printf("| `%s` | %d | %.3f | %.3f | %.3f | %.3f | %.1f %% | %.3f |", m.renderer.c_str(), m.views,
              m.project / n, m.sort / n, m.raster / n, m.total / n, 100 * m.uncertain, m.wall / n);
  if (m.judged)
    std::printf(" %.1f | %.1e |", m.psnr_db, m.max_abs);
  else
    std::printf(" | |");
  if (m.photographed)
    std::printf(" %.2f |\n", m.photo_psnr_db / m.photographed);
  else
    std::printf(" |\n");
}

}  // namespace

void print_tables(const std::vector<RowResult>& rows) {
  std::map<Table, std::map<std::string, Mean>> tables;
  std::vector<const RowResult*> firsts;  // of each table, in the order of measurement
  for (const RowResult& row : rows) {
    if (!tables.contains(table_of(row))) firsts.push_back(&row);
    Mean& mean = tables[table_of(row)][row.renderer];
    mean.renderer = row.renderer;
    mean.add(row);
  }
  for (const RowResult* first : firsts) {
    std::vector<Mean> means;
    for (const auto& [name, mean] : tables[table_of(*first)]) means.push_back(mean);
    std::stable_sort(means.begin(), means.end(),
                     [](const Mean& a, const Mean& b) { return a.total / a.views < b.total / b.views; });
    print_heading(*first);
    for (const Mean& mean : means) print_mean(mean);
  }
  std::printf(
      "\nMeans over views of medians; 'within' is half the widest 95 %% interval of a median; errors are the "
      "worst view's.\n");
}

}  // namespace swiftgs::cli
