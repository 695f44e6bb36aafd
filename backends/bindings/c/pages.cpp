// SPDX-License-Identifier: Apache-2.0

// Page files, and pools that draw them.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <swiftgs/c/pages.h>
#include <swiftgs/error.hpp>
#include <swiftgs/pages/page_pool.hpp>
#include <swiftgs/pages/paged_scene.hpp>

#include "error.hpp"
#include "objects.hpp"
#include "structs.hpp"

struct swiftgs_pages {
  swiftgs::PagedScene file;
};

struct swiftgs_pool {
  swiftgs_renderer* renderer;
  std::vector<swiftgs::PagedScene> files;
  std::unique_ptr<swiftgs::PagePool<swiftgs::AnyRenderer>> pool;
  std::shared_ptr<swiftgs::Cut> cut{};  ///< the last one; the renderer may keep it longer
};

namespace swiftgs::c {
namespace {

PagePoolOptions to_options(const swiftgs_pool_options& from) {
  require_zero(from.reserved, "swiftgs_pool_options");
  PagePoolOptions to;
  if (from.bytes != 0) to.bytes = std::size_t(from.bytes);
  if (from.upload_per_frame != 0) to.upload_per_frame = std::size_t(from.upload_per_frame);
  if (from.waiting != 0) to.waiting = std::size_t(from.waiting);
  to.estimate = std::size_t(from.estimate);
  return to;
}

CutGoal to_goal(const swiftgs_cut_goal& from) {
  require_zero(from.reserved, "swiftgs_cut_goal");
  CutGoal to;
  if (from.pixels != 0) to.pixels = from.pixels < 0 ? 0 : from.pixels;
  if (from.splats != 0) to.splats = from.splats;
  to.blend = from.blend;
  return to;
}

const swiftgs_pool& open(const swiftgs_pool* pool) {
  require_pointer(pool, "pool");
  return *pool;
}
swiftgs_pool& open(swiftgs_pool* pool) {
  require_pointer(pool, "pool");
  return *pool;
}

void require_cut(const swiftgs_pool& pool, const char* call) {
  if (!pool.cut) throw OrderError(std::string(call) + ": expected swiftgs_pool_cut before");
}

/// Shows the cut of `pool` with `renderer`, and describes it in `told`.
void show(swiftgs_pool& pool, AnyRenderer& renderer, swiftgs_cut* told) {
  const Cut& cut = *pool.cut;
  renderer.show({cut.scenes().data(), cut.scenes().size()});
  pool.renderer->shown = pool.cut;
  if (!told) return;
  write_struct(told,
               {.size = 0,
                .is_settled = cut.is_settled(),
                .splats = cut.splats(),
                .wanted = cut.wanted(),
                .missing = cut.missing(),
                .pixels = cut.pixels(),
                .resident = pool.pool->resident(),
                .bytes = pool.pool->bytes(),
                .failure = cut.failed().empty() ? nullptr : cut.failed()[0].reason.c_str(),
                .scenes = cut.scenes().size(),
                .estimated_db = cut.estimated_db()},
               "swiftgs_cut");
}

void check_cut(const swiftgs_cut* cut) {
  if (cut) check_struct(cut, "swiftgs_cut");
}

}  // namespace
}  // namespace swiftgs::c

using namespace swiftgs::c;

extern "C" {

swiftgs_status swiftgs_pages_open(const char* path, swiftgs_pages** pages) {
  return guarded([&] {
    require_pointer(path, "path");
    require_pointer(pages, "pages");
    *pages = std::make_unique<swiftgs_pages>(swiftgs_pages{swiftgs::open_pages(path)}).release();
  });
}

void swiftgs_pages_free(swiftgs_pages* pages) { delete pages; }

swiftgs_status swiftgs_pages_get_info(const swiftgs_pages* pages, swiftgs_pages_info* info) {
  return guarded([&] {
    require_pointer(pages, "pages");
    const swiftgs::PagedScene& file = pages->file;
    swiftgs_pages_info to{};
    to.sh_degree = file.sh_degree(), to.gaussians = file.gaussians();
    to.pages = file.pages().size, to.page_size = file.page_size();
    const swiftgs::ChunkBounds& bounds = file.pages()[file.root()].bounds;
    for (int axis = 0; axis < 3; ++axis) {
      to.origin[axis] = file.origin()[axis];
      to.lower[axis] = bounds.low[axis], to.upper[axis] = bounds.high[axis];
    }
    write_struct(info, to, "swiftgs_pages_info");
  });
}

swiftgs_status swiftgs_pool_create(swiftgs_renderer* renderer, const swiftgs_pages* const* pages,
                                   size_t count, const swiftgs_pool_options* options, swiftgs_pool** pool) {
  return guarded([&] {
    const Turn any = of(renderer);
    require_pointer(pool, "pool");
    if (count != 0) require_pointer(pages, "pages");
    auto made = std::make_unique<swiftgs_pool>(swiftgs_pool{renderer, {}, nullptr});
    std::vector<swiftgs::PlacedPages> placed;
    for (std::size_t i = 0; i < count; ++i) {
      require_pointer(pages[i], "pages");
      made->files.push_back(pages[i]->file), placed.push_back({pages[i]->file});
    }
    made->pool = std::make_unique<swiftgs::PagePool<swiftgs::AnyRenderer>>(
        *any, std::move(placed), to_options(read_options(options, "swiftgs_pool_options")));
    *pool = made.release();
  });
}

void swiftgs_pool_free(swiftgs_pool* pool) {
  if (!pool) return;
  const Turn any(*pool->renderer);
  delete pool;
}

swiftgs_status swiftgs_pool_place(swiftgs_pool* pool, const swiftgs_placement* placements, size_t count) {
  return guarded([&] {
    const auto& files = open(pool).files;
    const Turn any = of(pool->renderer);
    std::vector<swiftgs::PlacedPages> placed;
    for_each_struct(placements, count, "swiftgs_placement", [&](const swiftgs_placement& each) {
      const swiftgs::Placement p = to_placement(each);
      if (p.scene >= files.size())
        refuse("pool_place: the scene is number ", p.scene, ", expected less than ", files.size());
      if (each.first != 0 || each.count != 0)
        refuse("pool_place: found first or count, expected 0: pages show as wholes");
      placed.push_back({files[p.scene], p.world_from_scene, p.opacity, p.clip, p.tint});
    });
    pool->pool->place(std::move(placed));
  });
}

swiftgs_status swiftgs_pool_cut(swiftgs_pool* pool, const swiftgs_frame* frame, const swiftgs_frame* ahead,
                                const swiftgs_cut_goal* goal, swiftgs_cut* cut) {
  return guarded([&] {
    swiftgs_renderer& renderer = *open(pool).renderer;
    const Turn any = of(&renderer);
    check_cut(cut);
    read_views(read_struct(frame, "swiftgs_frame"), renderer.views);
    std::vector<swiftgs::View> later;
    if (ahead) read_views(read_struct(ahead, "swiftgs_frame"), later);
    pool->cut = std::make_shared<swiftgs::Cut>(
        pool->pool->cut({renderer.views.data(), renderer.views.size()},
                        to_goal(read_options(goal, "swiftgs_cut_goal")), {later.data(), later.size()}));
    show(*pool, *any, cut);
  });
}

swiftgs_status swiftgs_pool_wait(swiftgs_pool* pool, swiftgs_cut* cut) {
  return guarded([&] {
    const Turn any = of(open(pool).renderer);
    check_cut(cut);
    require_cut(*pool, "pool_wait");
    // Recorded frames may show the last cut. Others give its pages back before they wait for more.
    pool->cut = std::make_shared<swiftgs::Cut>(*pool->cut);
    any->show({});
    pool->renderer->shown.reset();
    pool->pool->wait(*pool->cut);
    show(*pool, *any, cut);
  });
}

swiftgs_status swiftgs_pool_named(const swiftgs_pool* pool, uint32_t number, swiftgs_named_node* named) {
  return guarded([&] {
    const Turn any = of(open(pool).renderer);
    require_cut(*pool, "pool_named");
    const swiftgs::NamedNode node = pool->cut->named(number);
    write_struct(named, {0, node.is_gaussian, node.scene, node.page, node.number}, "swiftgs_named_node");
  });
}

}  // extern "C"
