/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_PAGES_H
#define SWIFTGS_C_PAGES_H

/// @file
/// Scenes larger than the memory: page files, and pools that draw them within a budget. docs/pages.md tells
/// how.

#include <stddef.h>
#include <stdint.h>

#include <swiftgs/c/renderer.h>
#include <swiftgs/c/status.h>

#ifdef __cplusplus
extern "C" {
#endif

/// An open page file, which never changes. Pools that were made with it share it: free it as soon as you
/// like.
typedef struct swiftgs_pages swiftgs_pages;

/// Opens what `swiftgs pages` wrote. Reads its table, and no page. Errors: `SWIFTGS_FORMAT_ERROR`,
/// `SWIFTGS_SYSTEM_ERROR`.
SWIFTGS_C_API swiftgs_status swiftgs_pages_open(const char* path, swiftgs_pages** pages);
SWIFTGS_C_API void swiftgs_pages_free(swiftgs_pages* pages);

typedef struct swiftgs_pages_info {
  uint32_t size;       ///< `sizeof(swiftgs_pages_info)`
  int32_t sh_degree;   ///< 0 to 3
  uint64_t gaussians;  ///< of all leaves
  uint64_t pages;      ///< leaves, and those above them
  uint64_t page_size;  ///< most Gaussians or nodes of a page
  double origin[3];    ///< as in `swiftgs_scene_info`
  float lower[3];      ///< least coordinates of all means, less `origin`
  float upper[3];      ///< greatest
} swiftgs_pages_info;

/// Fills `info`, whose size is set.
SWIFTGS_C_API swiftgs_status swiftgs_pages_get_info(const swiftgs_pages* pages, swiftgs_pages_info* info);

/// Pages in the memory of a renderer's backend. The renderer outlives it.
typedef struct swiftgs_pool swiftgs_pool;

typedef struct swiftgs_pool_options {
  uint32_t size;              ///< `sizeof(swiftgs_pool_options)`
  uint32_t reserved;          ///< 0
  uint64_t bytes;             ///< of all pages in the backend's memory; 0: 2,000,000,000
  uint64_t upload_per_frame;  ///< 0: 16 MiB @units{bytes}
  uint64_t waiting;           ///< of pages that were read and not uploaded; 0: 64 MiB @units{bytes}
  uint64_t estimate;  ///< of the host, in which a thread measures `swiftgs_cut.estimated_db` by pages that it
                      ///< reads for itself; 0: none does @units{bytes}
} swiftgs_pool_options;

/// Makes a pool of `count` files, each placed where it stands, and uploads their coarsest pages. `options`
/// may be NULL. Errors: `SWIFTGS_INVALID_ARGUMENT` for no files, and where `bytes` or `estimate` does not
/// hold their coarsest pages.
SWIFTGS_C_API swiftgs_status swiftgs_pool_create(swiftgs_renderer* renderer,
                                                 const swiftgs_pages* const* pages, size_t count,
                                                 const swiftgs_pool_options* options, swiftgs_pool** pool);
/// The renderer keeps the pages that its frames and recorded frames show until they show others. Waits for
/// the pages that are being read, and with `estimate` for the part of a view that is being drawn; calls for
/// the renderer in other threads wait as long.
SWIFTGS_C_API void swiftgs_pool_free(swiftgs_pool* pool);

/// Places files of the pool by their indices, any number of times, as wholes: `first` and `count` are 0.
/// `SWIFTGS_INVALID_ARGUMENT`, and nothing changes, for anything else.
SWIFTGS_C_API swiftgs_status swiftgs_pool_place(swiftgs_pool* pool, const swiftgs_placement* placements,
                                                size_t count);

/// What a cut should be like.
typedef struct swiftgs_cut_goal {
  uint32_t size;      ///< `sizeof(swiftgs_cut_goal)`
  uint32_t reserved;  ///< 0
  double pixels;    ///< largest error of a page that is drawn; 0: 1; negative: none, all Gaussians are drawn
  uint64_t splats;  ///< most Gaussians and nodes; 0: any
  double blend;     ///< part of `pixels` over which a page fades into its children; 0: none
} swiftgs_cut_goal;

/// What a cut is like.
typedef struct swiftgs_cut {
  uint32_t size;        ///< `sizeof(swiftgs_cut)`
  int32_t is_settled;   ///< 1: nothing is missing but pages that fail, and those below them
  uint64_t splats;      ///< Gaussians and nodes that it draws
  uint64_t wanted;      ///< at most, once all pages are there
  uint64_t missing;     ///< pages that are not in memory yet
  double pixels;        ///< error that the budgets allow when nothing is missing
  uint64_t resident;    ///< pages in memory
  uint64_t bytes;       ///< that pages take
  const char* failure;  ///< why a page could not be read, until the next cut; NULL: none failed
  uint64_t scenes;  ///< placed scenes of a frame that shows it, as `swiftgs_renderer_visible_by_scene` counts
  double estimated_db;  ///< PSNR beside the scene of the last complete cut that was measured, after
                        ///< `swiftgs_pool_wait` of this one: of its pages alone in front of the background,
                        ///< without other scenes and images below; NaN: none yet, or not to be measured
} swiftgs_cut;

/// Chooses the pages for all views of `frame`, and has the renderer show them in place of its own scenes,
/// until another scene is set, added or placed. Does not wait for files. Then it brings what the views of
/// `ahead` need; NULL: those of the cameras in ten frames if they go on as they do. `goal` may be NULL. Fills
/// `cut`, whose size is set, or which is NULL. Errors: `SWIFTGS_INVALID_ARGUMENT` as
/// `swiftgs_renderer_render_into`.
SWIFTGS_C_API swiftgs_status swiftgs_pool_cut(swiftgs_pool* pool, const swiftgs_frame* frame,
                                              const swiftgs_frame* ahead, const swiftgs_cut_goal* goal,
                                              swiftgs_cut* cut);
/// Makes the last cut complete but for pages that fail, and has the renderer show it, or nothing if it fails.
/// Waits for files, and with `estimate` for its measurement; calls for the renderer in other threads wait as
/// long.
/// Errors: `SWIFTGS_LOGIC_ERROR` before the first cut.
SWIFTGS_C_API swiftgs_status swiftgs_pool_wait(swiftgs_pool* pool, swiftgs_cut* cut);

/// What a number in `id`, `median_id` or a pick of a frame of the last cut names.
typedef struct swiftgs_named_node {
  uint32_t size;        ///< `sizeof(swiftgs_named_node)`
  int32_t is_gaussian;  ///< 1; 0: a node of a page, which stands for several
  uint64_t scene;       ///< index of the placement
  uint32_t page;
  uint32_t number;  ///< of the Gaussian in the source, or of the node in its page
} swiftgs_named_node;

/// Fills `named`, whose size is set. `SWIFTGS_INVALID_ARGUMENT` for a number that the cut does not have,
/// `SWIFTGS_LOGIC_ERROR` before the first cut.
SWIFTGS_C_API swiftgs_status swiftgs_pool_named(const swiftgs_pool* pool, uint32_t number,
                                                swiftgs_named_node* named);

#ifdef __cplusplus
}
#endif

#endif
