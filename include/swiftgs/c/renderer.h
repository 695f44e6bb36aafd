/* SPDX-License-Identifier: Apache-2.0 */
#ifndef SWIFTGS_C_RENDERER_H
#define SWIFTGS_C_RENDERER_H

/// @file
/// Renderers, by name.

#include <stddef.h>
#include <stdint.h>

#include <swiftgs/c/scene.h>
#include <swiftgs/c/status.h>
#include <swiftgs/c/view.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Renders frames of the scenes that it was given. It keeps its memory: a frame no larger than an earlier one
/// allocates nothing. Calls from several threads run one after another.
typedef struct swiftgs_renderer swiftgs_renderer;

/// One row of the table of renderers.
typedef struct swiftgs_renderer_entry {
  uint32_t size;      ///< `sizeof(swiftgs_renderer_entry)`
  int32_t usable;     ///< 1: it can run on this machine
  const char* name;   ///< BACKEND/SORT/RASTER/BOUNDS; valid as long as the library is loaded
  int32_t on_device;  ///< 1: it draws in the memory of a CUDA device; 0: in the host's, or of `vulkan` in
                      ///< Vulkan's
  uint32_t reserved;  ///< 0
} swiftgs_renderer_entry;

/// How many renderers this build has, whether or not they can run here.
SWIFTGS_C_API swiftgs_status swiftgs_renderers_count(size_t* count);
/// Fills `entry`, whose size is set. `SWIFTGS_INVALID_ARGUMENT` beyond the last.
SWIFTGS_C_API swiftgs_status swiftgs_renderers_get(size_t index, swiftgs_renderer_entry* entry);
/// Fills `entry`, whose size is set, with the renderer called `name`; or where `name` is a backend alone
/// (`serial`, `vulkan`, `cpu`, `cuda`), with its usual one; or where `name` is NULL, with that of the
/// quickest backend that can run here. `SWIFTGS_INVALID_ARGUMENT` for any other name.
SWIFTGS_C_API swiftgs_status swiftgs_renderers_find(const char* name, swiftgs_renderer_entry* entry);

/// Memory of `bytes` bytes, aligned to 64 bytes on a host and to 256 on a device, or NULL if there is none:
/// the call that needed it then fails with `SWIFTGS_OUT_OF_MEMORY`. Must not throw. It may ask the renderer
/// that called it for numbers; it must not draw with it, nor call other renderers, which may wait for this
/// one.
typedef void* (*swiftgs_allocate)(void* context, size_t bytes);
/// Takes back what `swiftgs_allocate` returned for as many bytes.
typedef void (*swiftgs_release)(void* context, void* memory, size_t bytes);

/// How a renderer keeps harmonics above band 0 of the scenes that it uploads. Those of arrays stay floats.
enum {
  SWIFTGS_HARMONICS_FLOAT = 0,  ///< so that `swiftgs_renderer_update_scene` may replace them
  /// In the fewest bytes that hold them exactly; on hosts, which share a scene, as they are.
  SWIFTGS_HARMONICS_SMALLEST = 1,
  /// Rounded to the nearest half: a coefficient c is off by at most 2^-11 |c| or 2^-25. Those beyond 65504
  /// are refused.
  SWIFTGS_HARMONICS_HALF = 2
};

typedef struct swiftgs_renderer_options {
  uint32_t size;              ///< `sizeof(swiftgs_renderer_options)`
  int32_t threads;            ///< of the backend `cpu`, 0 or more; 0: all
  void* stream;               ///< of the backend `cuda`: a `cudaStream_t`, which outlives the renderer
  swiftgs_allocate allocate;  ///< of all the renderer's memory; NULL: the backend's own. With `release` only.
  swiftgs_release release;    ///< on a device in stream order, as docs/embedding.md says
  void* context;              ///< of both; outlives the renderer and those that share its scene
  int32_t harmonics;          ///< `SWIFTGS_HARMONICS_...`
  uint32_t reserved;          ///< 0
} swiftgs_renderer_options;

/// Makes the renderer called `name`, such as "cpu/early/axis-shared-threshold-float-cholesky/ellipse".
/// `options` may be NULL. A renderer of `cuda` belongs to the device that is current now, which must be
/// current wherever it is used. Errors: `SWIFTGS_INVALID_ARGUMENT` with the valid words if the name is not
/// known, `SWIFTGS_UNAVAILABLE` if it cannot run here, `SWIFTGS_DEVICE_ERROR`.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_create(const char* name,
                                                     const swiftgs_renderer_options* options,
                                                     swiftgs_renderer** renderer);
SWIFTGS_C_API void swiftgs_renderer_free(swiftgs_renderer* renderer);

/// BACKEND/SORT/RASTER/BOUNDS
SWIFTGS_C_API swiftgs_status swiftgs_renderer_name(const swiftgs_renderer* renderer, const char** name);
/// Model of the processor or device, with the number of threads where that is a choice.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_device_name(const swiftgs_renderer* renderer,
                                                          const char** name);

/// Uploads `scene` for the frames that follow, in place of all scenes and placements before; backends of the
/// host share it. A graph of frames that were recorded before reads the scene of then: destroy the graph
/// first.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_set_scene(swiftgs_renderer* renderer,
                                                        const swiftgs_scene* scene);
/// As above, of arrays. Those of a device go to a renderer of `cuda` within the device, in stream order, and
/// no host waits: the renderer's stream waits for `stream` of the arrays, and what `stream` is given next
/// comes after the copy, so that it may overwrite them. Memory of the scene before is taken again, unless it
/// was ever shared; growing it waits. Any other pair of memory and backend is copied by way of the host. A
/// Gaussian with a NaN or an infinity is refused on the host, and not drawn on a device, where no pass looks
/// for it. Errors: as `swiftgs_scene_from_arrays`, and `SWIFTGS_CAPACITY_ERROR`, after which the renderer has
/// no scene.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_set_gaussians(swiftgs_renderer* renderer,
                                                            const swiftgs_gaussians* gaussians);
/// As above, of arrays that frames read where they lie, in the memory of the renderer's backend: nothing is
/// copied, and numbers are not checked; a Gaussian with a NaN or an infinity is not drawn. The arrays stay
/// until another scene is set and frames are finished. They may change between frames. The renderer's stream
/// waits for `stream` of the arrays, once. `SWIFTGS_INVALID_ARGUMENT` also for `SWIFTGS_LOG_SCALES`,
/// `SWIFTGS_LOGIT_OPACITIES`, strides of 4 GiB and arrays in other memory.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_borrow_gaussians(swiftgs_renderer* renderer,
                                                               const swiftgs_gaussians* gaussians);
/// Shares the scenes that `other` has uploaded, without copies, and their placements, but no pages. On a
/// device the renderer's stream waits for what the stream of `other` has now. `SWIFTGS_INVALID_ARGUMENT`, and
/// nothing changes, if `other` has no scene or another backend.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_share_scene(swiftgs_renderer* renderer,
                                                          const swiftgs_renderer* other);

/// Uploads one more scene, and writes its number: 0, 1 and so on. Frames show it too, where it stands by
/// itself, until the next `swiftgs_renderer_place`.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_add_scene(swiftgs_renderer* renderer,
                                                        const swiftgs_scene* scene, uint64_t* number);

/// A placed scene: one of a renderer's scenes in a frame, or a range of its Gaussians, moved to p_world =
/// scale rotation p_scene + translation. Zeros show it all where it stands by itself. Its clip is in the
/// scene's own space, and shows the Gaussians whose means lie in all half-spaces and in the sphere.
typedef struct swiftgs_placement {
  uint32_t size;             ///< `sizeof(swiftgs_placement)`; the same in all elements of an array
  int32_t half_space_count;  ///< 0 to 6
  uint64_t scene;            ///< number of the scene, as `swiftgs_renderer_add_scene` writes it
  double rotation[9];        ///< @shape{3, 3} scene to world, row after row, orthonormal; all 0: none
  double scale;              ///< above 0; 0: 1
  double translation[3];     ///< world position of the scene's zero
  double transparency;       ///< 1 less what opacities are multiplied by; 0 to 1
  float half_spaces[24];     ///< @shape{6, 4} x, y, z, w each: points p with (x, y, z) . p + w >= 0
  float centre[3];           ///< of the sphere
  float radius;              ///< 0: no sphere
  uint64_t first;            ///< number of the first Gaussian that shows; multiples of 128 are drawn fastest
  uint64_t count;            ///< how many Gaussians show; 0: all from there on
  float tint[3];             ///< RGB that is mixed into colours, in the scene's own values, 0 or more
  float tint_amount;         ///< 0 to 1: 0 leaves the Gaussians' colours, 1 shows `tint` in their place
} swiftgs_placement;

/// Replaces Gaussians [first, first + count) of a scene of the renderer by those of `gaussians`, whose arrays
/// lie where the renderer draws, or on the host for `vulkan`; arrays that are NULL stay as they are, `origin`
/// and the model are not looked at. Renderers that share the scene show the update too, as do all later and
/// recorded frames. On a device it is in stream order, as `swiftgs_renderer_set_gaussians`, and numbers are
/// not checked; a scene that was uploaded from the host has no bands there above the highest one with a
/// number other than 0. On hosts no frame of the scene may be under way, in no renderer, and numbers that are
/// not finite are refused; the `swiftgs_scene` stays as it is. Errors: `SWIFTGS_INVALID_ARGUMENT`, also for
/// `sh_rest` of a scene that is not kept as floats (`swiftgs_renderer_options`), and nothing changes.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_update_scene(swiftgs_renderer* renderer, uint64_t scene,
                                                           uint64_t first,
                                                           const swiftgs_gaussians* gaussians);

/// Sets the placed scenes that frames show: any of the renderer's scenes, any number of times. Gaussians are
/// numbered over all of them, those of the first placed scene first: so `id`, `median_id` and
/// `swiftgs_renderer_pick` tell them. Origins of scenes are not looked at: add them to translations. Errors:
/// `SWIFTGS_INVALID_ARGUMENT`, and nothing changes.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_place(swiftgs_renderer* renderer,
                                                    const swiftgs_placement* placements, size_t count);

/// What a frame measures beside its images. Flags are added.
enum {
  SWIFTGS_MEASURE_COUNTS = 1,  ///< all of `swiftgs_statistics`, which costs some time
  SWIFTGS_MEASURE_TIMES = 2    ///< `swiftgs_renderer_times`, which costs a device some microseconds
};

/// The views of a frame, and what it measures.
typedef struct swiftgs_frame {
  uint32_t size;              ///< `sizeof(swiftgs_frame)`
  uint32_t measure;           ///< sum of `SWIFTGS_MEASURE_...`; not of recorded frames
  const swiftgs_view* views;  ///< @shape{count}
  uint64_t count;             ///< 1 to 65536
} swiftgs_frame;

/// Draws all views in one frame: one projection, one sort, one rasterization. Each image has the bits that
/// its view gives alone. All planes are memory that the backend reaches: the host's for `serial` and `cpu`,
/// the device's for `cuda`.
///
/// @sync On a host the frame is complete when it returns. On a device it is in stream order, and the call has
/// waited once, until projection had counted.
///
/// Errors: `SWIFTGS_INVALID_ARGUMENT` for what nothing can be rendered with, `SWIFTGS_LOGIC_ERROR` before a
/// scene is set, `SWIFTGS_CAPACITY_ERROR`, `SWIFTGS_OUT_OF_MEMORY`, `SWIFTGS_DEVICE_ERROR`.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_render_into(swiftgs_renderer* renderer,
                                                          const swiftgs_frame* frame);

/// As `swiftgs_renderer_render_into`, but all planes are the host's memory on every backend, and the frame is
/// complete when it returns. A device copies what `over` and `occluder` need to it, and the images from it.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_render(swiftgs_renderer* renderer, const swiftgs_frame* frame);

/// Capacity of recorded frames.
typedef struct swiftgs_capacity {
  uint32_t size;      ///< `sizeof(swiftgs_capacity)`
  uint32_t reserved;  ///< 0
  uint64_t splats;    ///< visible Gaussians of all views; 0: as many as are visible now, and an eighth more
  uint64_t intersections;  ///< pairs of splat and tile; 0: as many as there are now, and an eighth more
} swiftgs_capacity;

/// Takes all memory that `swiftgs_renderer_record` needs for `frame`, sets its views, draws nothing and
/// waits. `capacity` may be NULL. docs/scenes.md says what may change between recorded frames.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_reserve(swiftgs_renderer* renderer, const swiftgs_frame* frame,
                                                      const swiftgs_capacity* capacity);
/// Sets the views that recorded frames draw, in stream order: as many as were reserved, of the same sizes and
/// with the same planes; pinholes that take depth z alone, if all that were reserved do.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_set_views(swiftgs_renderer* renderer,
                                                        const swiftgs_frame* frame);

/// Sets what recorded frames show to what `swiftgs_renderer_place` was given since, in stream order: as many
/// placed scenes of as many Gaussians as were reserved, moved, clipped or made fainter.
/// `SWIFTGS_INVALID_ARGUMENT`, and nothing changes, for others, and if a scene alone was reserved.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_set_recorded_scenes(swiftgs_renderer* renderer);

/// What recorded frames show, in memory of the backend: arrays of a number or a few for each placed scene, in
/// the order of the placements, `stride` bytes from one to the next. `rotation` has the scene's x, y and z
/// axes in the world, one after the other: the columns, where `swiftgs_placement` has the rows.
typedef struct swiftgs_recorded_scenes {
  uint32_t size;        ///< `sizeof(swiftgs_recorded_scenes)`
  uint32_t reserved;    ///< 0
  uint64_t count;       ///< N, placed scenes
  int64_t stride;       ///< @units{bytes}
  double* rotation;     ///< @shape{N, 3, 3} scene to world, column after column, orthonormal
  double* scale;        ///< @shape{N} above 0
  double* translation;  ///< @shape{N, 3} world position of the scene's zero
  float* opacity;       ///< @shape{N} what opacities are multiplied by, 0 to 1
  float* tint;          ///< @shape{N, 4} RGB that is mixed into colours, and its amount, 0 to 1
} swiftgs_recorded_scenes;

/// Fills `scenes`, whose size is set. Work in the order of the renderer's stream may write these numbers: the
/// recorded frames that run after it show them, also in a CUDA graph, until
/// `swiftgs_renderer_set_recorded_scenes`. A device does not draw a scene whose numbers are not valid; a host
/// refuses to record. Valid until the next `swiftgs_renderer_reserve` or `swiftgs_renderer_trim`, or another
/// scene takes the place of all. `SWIFTGS_LOGIC_ERROR` unless placed scenes were reserved: one placement of a
/// scene or range that stands by itself is a scene alone.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_recorded_scenes(swiftgs_renderer* renderer,
                                                              swiftgs_recorded_scenes* scenes);

/// Fills `refused` with 1 for each of `count` placed scenes that the last recorded frame did not draw, of
/// those that its views show, since its numbers were not valid, and with 0 for the others. Waits.
/// `SWIFTGS_INVALID_ARGUMENT` if `count` is not that of `swiftgs_recorded_scenes`; `SWIFTGS_LOGIC_ERROR` as
/// above.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_refused_scenes(swiftgs_renderer* renderer, uint8_t* refused,
                                                             size_t count);

/// What a recorded frame took. If it overflowed, it drew nothing; a capacity of these numbers suffices.
typedef struct swiftgs_report {
  uint64_t visible;        ///< Gaussians, of all views
  uint64_t intersections;  ///< pairs of splat and tile
  uint64_t overflowed;     ///< 1: they were more than was reserved
} swiftgs_report;

/// Draws the views that were set. It neither waits nor allocates, so that a CUDA graph may capture it.
/// `report` is memory that the backend reaches: of the host, or of the device, or pinned. On a host the frame
/// is complete when it returns. Errors: `SWIFTGS_INVALID_ARGUMENT` before `swiftgs_renderer_reserve`, and of
/// placed scenes where others were uploaded since in their place; `SWIFTGS_CAPACITY_ERROR` for a scene of
/// more Gaussians than were reserved.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_record(swiftgs_renderer* renderer, swiftgs_report* report);

/// Returns when all work submitted so far is done.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_wait(swiftgs_renderer* renderer);

/// The Gaussian of the largest weight at a pixel, and the median one. A weight is alpha times transmittance,
/// as `AxisSharedThreshold<FloatCholesky>` blends with it, whatever the renderer. Depths are of the
/// Gaussians' means, as the view's conventions measure them. The struct has no size, because it never grows.
typedef struct swiftgs_picked {
  uint32_t gaussian;   ///< index of the largest weight, of equal ones the nearest; or `SWIFTGS_NOTHING`
  float weight;        ///< 0 of nothing
  float depth;         ///< 0 of nothing
  uint32_t median;     ///< that takes the transmittance below 1/2; or `SWIFTGS_NOTHING`
  float median_depth;  ///< 0 of nothing
} swiftgs_picked;

/// Fills `picked` [height, width], by rows, with what the last frame shows in a rectangle of at most 64x64
/// pixels of a view's image. `x` and `y` are its first pixel, from the top left. Waits. Occluders are not
/// looked at: compare depths with yours. A recorded frame above its capacity shows nothing on a device, and
/// is no frame on a host. Errors: `SWIFTGS_LOGIC_ERROR` before the first frame, and after
/// `swiftgs_renderer_reserve`, `swiftgs_renderer_trim` or a frame that failed once its views were valid;
/// `SWIFTGS_INVALID_ARGUMENT` for a view that there is not and a rectangle that does not lie in its image;
/// `SWIFTGS_DEVICE_ERROR`.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_pick(swiftgs_renderer* renderer, uint64_t view, int32_t x,
                                                   int32_t y, int32_t width, int32_t height,
                                                   swiftgs_picked* picked);

/// Durations of the last frame's stages. @units{milliseconds}
typedef struct swiftgs_times {
  uint32_t size;      ///< `sizeof(swiftgs_times)`
  uint32_t reserved;  ///< 0
  double project, sort, raster, total;
} swiftgs_times;

/// Fills `times`, whose size is set. Not a number unless the frame measured them and is finished: this does
/// not wait.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_times(swiftgs_renderer* renderer, swiftgs_times* times);

/// Counts of the last frame that was not recorded.
typedef struct swiftgs_statistics {
  uint32_t size;           ///< `sizeof(swiftgs_statistics)`
  uint32_t reserved;       ///< 0
  uint64_t gaussians;      ///< in all placed scenes
  uint64_t visible;        ///< projected to splats
  uint64_t intersections;  ///< pairs of splat and tile
  /// 0 unless the frame measured counts, as all below.
  uint64_t intersections_visited;  ///< before all pixels of their raster block had stopped
  uint64_t rows_visited;           ///< rows of pixels on which an intersection was evaluated
  uint64_t contributing_pairs;     ///< pairs of pixel and splat that were blended
  uint64_t pixels_stopped;         ///< pixels that ended before their list
  /// Those of `intersections` whose means lie at or behind an occluder in all pixels of their tile. Where
  /// it is 99 % of them, `stored_depth` of the view is mostly missing.
  uint64_t intersections_hidden;
} swiftgs_statistics;

/// Fills `statistics`, whose size is set.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_statistics(const swiftgs_renderer* renderer,
                                                         swiftgs_statistics* statistics);

/// Fills `visible` with the splats of each of `count` placed scenes in the last frame, all views together.
/// Waits, and brings 4 bytes a splat to the host. Errors: `SWIFTGS_LOGIC_ERROR` before a frame and after one
/// that was recorded; `SWIFTGS_INVALID_ARGUMENT` unless `count` is the number of that frame's placed scenes,
/// 1 of a scene alone.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_visible_by_scene(const swiftgs_renderer* renderer,
                                                               uint64_t* visible, size_t count);

/// Memory that a renderer keeps, the scene excluded, and that of its device. @units{bytes}
typedef struct swiftgs_memory {
  uint32_t size;           ///< `sizeof(swiftgs_memory)`
  uint32_t reserved;       ///< 0
  uint64_t project;        ///< splats, footprints and colours included
  uint64_t sort;           ///< tile lists included
  uint64_t raster;         ///< of the raster stage, and of images that `swiftgs_renderer_render` keeps
  uint64_t device_in_use;  ///< by all programs; 0 for backends of the host
  uint64_t device_total;   ///< 0 for backends of the host
} swiftgs_memory;

/// Fills `memory`, whose size is set.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_memory(const swiftgs_renderer* renderer,
                                                     swiftgs_memory* memory);

/// Waits, and gives back all memory that the renderer keeps, the scene excluded. The next frame takes it
/// again; what was reserved is forgotten.
SWIFTGS_C_API swiftgs_status swiftgs_renderer_trim(swiftgs_renderer* renderer);

#ifdef __cplusplus
}
#endif

#endif
