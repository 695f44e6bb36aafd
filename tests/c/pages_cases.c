/* SPDX-License-Identifier: Apache-2.0 */

/* Page files. What cuts draw is tested in page_pool_test. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "check.h"

enum { floats = 3 * small_width * small_height };

void test_pages(void) {
  swiftgs_pages* pages = NULL;
  CHECK_OK(swiftgs_pages_open(SWIFTGS_TEST_PAGES, &pages));
  swiftgs_pages_info info = {.size = sizeof(info)};
  CHECK_OK(swiftgs_pages_get_info(pages, &info));
  CHECK(info.gaussians == 130 && info.pages > 1 && info.page_size == 128 && info.lower[1] < info.upper[1]);

  struct drawing d;
  set_up(&d, small_renderer);
  const swiftgs_pages* const files[2] = {pages, pages};
  swiftgs_pool_options options = {.size = sizeof(options), .bytes = 10000000, .estimate = 10000000};
  swiftgs_pool* pool = NULL;
  CHECK_OK(swiftgs_pool_create(d.renderer, files, 1, &options, &pool));
  swiftgs_pages_free(pages);
  const swiftgs_cut_goal all = {.size = sizeof(all), .pixels = -1};
  swiftgs_cut cut = {.size = sizeof(cut)};
  CHECK_OK(swiftgs_pool_cut(pool, &d.frame, &d.frame, &all, &cut));
  CHECK(cut.splats == 65 && !cut.is_settled && cut.missing > 0 && cut.failure == NULL);
  CHECK_OK(swiftgs_pool_wait(pool, &cut));
  CHECK(cut.splats == cut.wanted && cut.is_settled && cut.pixels == 0 && isinf(cut.estimated_db));
  uint64_t visible[64] = {0};
  CHECK(cut.scenes > 1 && cut.scenes < 64);
  CHECK(cut.resident > 1 && cut.bytes > 0 && cut.bytes <= options.bytes);
  CHECK_OK(swiftgs_renderer_render(d.renderer, &d.frame));
  CHECK_OK(swiftgs_renderer_visible_by_scene(d.renderer, visible, cut.scenes));
  float* const near = make_floats(floats);
  memcpy(near, d.colour, floats * sizeof(float));
  swiftgs_named_node named = {.size = sizeof(named)};
  CHECK_OK(swiftgs_pool_named(pool, 0, &named));
  CHECK(named.is_gaussian && named.scene == 0 && named.number < 130);
  CHECK_INVALID(swiftgs_pool_named(pool, 130, &named), "expected less than");

  swiftgs_placement placement = {.size = sizeof(placement), .translation = {0, 0, 3}};
  CHECK_OK(swiftgs_pool_place(pool, &placement, 1));
  CHECK_OK(swiftgs_pool_cut(pool, &d.frame, NULL, NULL, NULL));
  CHECK_OK(swiftgs_pool_wait(pool, NULL));
  CHECK(!draws(&d, near));
  placement.scene = 1;
  CHECK_INVALID(swiftgs_pool_place(pool, &placement, 1), "the scene is number 1, expected less than 1");
  placement.scene = 0, placement.count = 3;
  CHECK_INVALID(swiftgs_pool_place(pool, &placement, 1), "found first or count");
  swiftgs_pool_free(pool), swiftgs_renderer_free(d.renderer);
}

void test_pages_freed(void) {
  struct drawing d;
  set_up(&d, small_renderer);
  swiftgs_pages* pages = NULL;
  CHECK_OK(swiftgs_pages_open(SWIFTGS_TEST_PAGES, &pages));
  const swiftgs_pages* const files[1] = {pages};
  swiftgs_pool* pool = NULL;
  CHECK_OK(swiftgs_pool_create(d.renderer, files, 1, NULL, &pool));
  swiftgs_pages_free(pages);
  float* const alone = draw_plain(d.renderer, &d.camera);
  CHECK_OK(swiftgs_pool_cut(pool, &d.frame, NULL, NULL, NULL));
  CHECK_OK(swiftgs_pool_wait(pool, NULL));
  float* const expected = draw_plain(d.renderer, &d.camera);
  CHECK_OK(swiftgs_renderer_reserve(d.renderer, &d.frame, NULL));
  swiftgs_renderer* second = NULL;
  CHECK_OK(swiftgs_renderer_create(small_renderer, NULL, &second));
  CHECK_OK(swiftgs_renderer_share_scene(second, d.renderer));

  swiftgs_pool_free(pool);
  CHECK(same_floats(draw_plain(second, &d.camera), alone, floats));
  swiftgs_scene* const other = make_scene(); /* takes the memory of freed pages */
  CHECK(draws(&d, expected));
  memset(d.colour, 0, floats * sizeof(float));
  swiftgs_report report = {0};
  CHECK_OK(swiftgs_renderer_record(d.renderer, &report));
  CHECK_OK(swiftgs_renderer_wait(d.renderer));
  CHECK(report.visible > 0 && same_floats(d.colour, expected, floats));
  CHECK_OK(swiftgs_renderer_set_scene(d.renderer, other));
  CHECK(draws(&d, alone));
  swiftgs_scene_free(other), swiftgs_renderer_free(second), swiftgs_renderer_free(d.renderer);
}

void test_pages_errors(void) {
  swiftgs_pages* pages = NULL;
  CHECK_NULLS(swiftgs_pages_open, "none.sgp", "path", &pages, "pages");
  CHECK_ERROR(swiftgs_pages_open("none.sgp", &pages), SWIFTGS_SYSTEM_ERROR, "none.sgp");
  CHECK_ERROR(swiftgs_pages_open(__FILE__, &pages), SWIFTGS_FORMAT_ERROR, "pages_cases.c");
  CHECK(pages == NULL);
  CHECK_OK(swiftgs_pages_open(SWIFTGS_TEST_PAGES, &pages));
  swiftgs_pages_info info = {.size = sizeof(info)};
  CHECK_NULLS(swiftgs_pages_get_info, pages, "pages", &info, "swiftgs_pages_info");

  struct drawing d;
  set_up(&d, small_renderer);
  const swiftgs_pages* const files[2] = {pages, NULL};
  swiftgs_pool* pool = NULL;
  swiftgs_pool_options options = {.size = sizeof(options), .bytes = 1};
  CHECK_INVALID(swiftgs_pool_create(NULL, files, 1, NULL, &pool), "renderer is NULL");
  CHECK_INVALID(swiftgs_pool_create(d.renderer, files, 0, NULL, &pool), "no pages");
  CHECK_INVALID(swiftgs_pool_create(d.renderer, files, 2, NULL, &pool), "pages is NULL");
  CHECK_INVALID(swiftgs_pool_create(d.renderer, files, 1, NULL, NULL), "pool is NULL");
  CHECK_INVALID(swiftgs_pool_create(d.renderer, files, 1, &options, &pool), "page pool: 1 bytes");
  options.bytes = 0, options.reserved = 1;
  CHECK_INVALID(swiftgs_pool_create(d.renderer, files, 1, &options, &pool), "reserved is 1");
  CHECK_OK(swiftgs_pool_create(d.renderer, files, 1, NULL, &pool));
  swiftgs_cut cut = {.size = 4}, told = {.size = sizeof(told)};
  CHECK_INVALID(swiftgs_pool_cut(NULL, &d.frame, NULL, NULL, NULL), "pool is NULL");
  CHECK_INVALID(swiftgs_pool_cut(pool, NULL, NULL, NULL, NULL), "swiftgs_frame is NULL");
  CHECK_INVALID(swiftgs_pool_cut(pool, &d.frame, NULL, NULL, &cut), "swiftgs_cut: size is 4");
  swiftgs_cut_goal goal = {.size = sizeof(goal), .blend = -1};
  CHECK_INVALID(swiftgs_pool_cut(pool, &d.frame, NULL, &goal, NULL), "a blend of -1");
  goal.blend = 0, goal.reserved = 1;
  CHECK_INVALID(swiftgs_pool_cut(pool, &d.frame, NULL, &goal, NULL), "reserved is 1");
  CHECK_INVALID(swiftgs_pool_wait(NULL, NULL), "pool is NULL");
  CHECK_INVALID(swiftgs_pool_place(NULL, NULL, 0), "pool is NULL");
  swiftgs_named_node named = {.size = sizeof(named)};
  CHECK_INVALID(swiftgs_pool_named(NULL, 0, &named), "pool is NULL");
  CHECK_ERROR(swiftgs_pool_named(pool, 0, &named), SWIFTGS_LOGIC_ERROR, "expected swiftgs_pool_cut before");
  CHECK_ERROR(swiftgs_pool_wait(pool, NULL), SWIFTGS_LOGIC_ERROR, "expected swiftgs_pool_cut before");
  CHECK_OK(swiftgs_pool_cut(pool, &d.frame, NULL, NULL, &told));
  CHECK(isnan(told.estimated_db));
  swiftgs_pool_free(NULL), swiftgs_pool_free(pool);
  swiftgs_renderer_free(d.renderer), swiftgs_pages_free(pages);
}
