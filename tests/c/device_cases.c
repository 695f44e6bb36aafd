/* SPDX-License-Identifier: Apache-2.0 */

/* What needs a device, and what there is without one. */
#include <math.h>
#include <string.h>

#include "check.h"

static const char* const device_renderer = "cuda/early/axis-shared-threshold-float-cholesky/ellipse";

static bool has_device(void) {
  swiftgs_renderer_entry entry = {.size = sizeof(entry)};
  return swiftgs_renderers_find(device_renderer, &entry) == SWIFTGS_OK && entry.usable == 1;
}

void test_no_device(void) {
  if (has_device()) skip("there is a CUDA device");
  const float numbers[4] = {0};
  swiftgs_gaussians one = {.size = sizeof(one), .count = 1, .memory = SWIFTGS_DEVICE};
  one.means.data = one.scales.data = one.rotations.data = one.opacities.data = one.sh0.data = numbers;
  swiftgs_scene* scene = NULL;
  CHECK_ERROR(swiftgs_scene_from_arrays(&one, &scene), SWIFTGS_UNAVAILABLE,
              "swiftgs_gaussians: arrays on a device");
  swiftgs_renderer* renderer = NULL;
  const swiftgs_status status = swiftgs_renderer_create(device_renderer, NULL, &renderer);
  CHECK(status == SWIFTGS_UNAVAILABLE || status == SWIFTGS_INVALID_ARGUMENT);
  CHECK(strstr(swiftgs_last_error(), device_renderer) != NULL && renderer == NULL && scene == NULL);

  int32_t device = -1;
  void* memory = NULL;
  CHECK_ERROR(swiftgs_device_current(&device), SWIFTGS_UNAVAILABLE, "swiftgs_device_current: a device, but");
  CHECK_ERROR(swiftgs_device_allocate(16, &memory), SWIFTGS_UNAVAILABLE, "swiftgs_device_allocate: memory");
  CHECK_ERROR(swiftgs_device_copy(&device, numbers, 4, NULL), SWIFTGS_UNAVAILABLE, "swiftgs_device_copy");
  CHECK_ERROR(swiftgs_device_order(NULL, NULL), SWIFTGS_UNAVAILABLE, "swiftgs_device_order: streams");
  CHECK(device == -1 && memory == NULL);
  swiftgs_device_free(NULL);
  renderer = make_renderer(small_renderer);
  CHECK_ERROR(swiftgs_renderer_set_gaussians(renderer, &one), SWIFTGS_UNAVAILABLE,
              "swiftgs_gaussians: arrays on a device");
  CHECK_ERROR(swiftgs_renderer_update_scene(renderer, 0, 0, &one), SWIFTGS_UNAVAILABLE,
              "swiftgs_gaussians: arrays on a device");
  swiftgs_renderer_free(renderer);
}

#if defined(SWIFTGS_TEST_CUDA)
#include <cuda_runtime_api.h>

enum { width = small_width, height = small_height, pixels = small_width * small_height };

static void* make_device_memory(size_t bytes) {
  void* memory = NULL;
  if (cudaMalloc(&memory, bytes) != cudaSuccess) give_up("cudaMalloc");
  return memory;
}

static void copy(void* to, const void* from, size_t bytes) {
  CHECK(cudaMemcpy(to, from, bytes, cudaMemcpyDefault) == cudaSuccess);
}

/* Arrays on the device, with a gap behind each Gaussian's means, make the scene of the same arrays on the
 * host. */
static void test_device_arrays(void) {
  swiftgs_scene *made = make_scene(), *fetched = NULL;
  swiftgs_gaussians host = arrays_of(made), device = host;
  device.memory = SWIFTGS_DEVICE;
  float* const features = make_floats(2 * small_count);
  for (int i = 0; i < 2 * small_count; ++i) features[i] = (float)i;
  host.features = (swiftgs_array){features, 8}, host.feature_channels = device.feature_channels = 2;
  const swiftgs_array* const from[] = {&host.scales, &host.rotations, &host.opacities,
                                       &host.sh0,    &host.sh_rest,   &host.features};
  swiftgs_array* const to[] = {&device.scales, &device.rotations, &device.opacities,
                               &device.sh0,    &device.sh_rest,   &device.features};
  for (int i = 0; i < 6; ++i) {
    const size_t bytes = (size_t)from[i]->stride * small_count;
    float* const memory = make_device_memory(bytes);
    copy(memory, from[i]->data, bytes);
    to[i]->data = memory;
  }
  float* const means = make_device_memory(20 * small_count);
  CHECK(cudaMemcpy2D(means, 20, host.means.data, 12, 12, small_count, cudaMemcpyHostToDevice) == cudaSuccess);
  device.means = (swiftgs_array){means, 20};
  CHECK_OK(swiftgs_scene_from_arrays(&device, &fetched));
  const swiftgs_gaussians found = arrays_of(fetched);
  CHECK(memcmp(found.means.data, host.means.data, 12 * small_count) == 0);
  CHECK(memcmp(found.rotations.data, host.rotations.data, 16 * small_count) == 0);
  CHECK(memcmp(found.sh_rest.data, host.sh_rest.data, 180 * small_count) == 0);
  CHECK(found.feature_channels == 2 && memcmp(found.features.data, features, 8 * small_count) == 0);

  /* They go to a renderer without the host, on a stream beside its own, and draw as the scene does. They may
   * be overwritten in the order of that stream. */
  struct drawing d;
  set_up(&d, device_renderer);
  swiftgs_renderer* const renderer = d.renderer;
  const float* const expected = draw_plain(renderer, &d.camera);
  cudaStream_t stream = NULL;
  CHECK(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking) == cudaSuccess);
  device.stream = stream;
  for (int i = 0; i < 2; ++i) { /* the second takes the memory of the first again */
    CHECK_OK(swiftgs_renderer_set_gaussians(renderer, &device));
    if (i == 1) CHECK(cudaMemsetAsync(means, 0xff, 20 * small_count, stream) == cudaSuccess);
    CHECK(draws(&d, expected));
  }
  /* Borrowed arrays are drawn as they are now. */
  CHECK_OK(swiftgs_renderer_borrow_gaussians(renderer, &device));
  CHECK(!draws(&d, expected));
  CHECK(cudaMemcpy2D(means, 20, host.means.data, 12, 12, small_count, cudaMemcpyHostToDevice) == cudaSuccess);
  CHECK(draws(&d, expected));
  CHECK_INVALID(swiftgs_renderer_borrow_gaussians(renderer, &host), "the arrays lie on the host, expected");
  CHECK_OK(swiftgs_renderer_set_gaussians(renderer, &device));
  /* An update goes the same way, and arrays of the host do not. */
  float* const moved = make_device_memory(20 * small_count);
  CHECK(cudaMemset(moved, 0, 20 * small_count) == cudaSuccess);
  swiftgs_gaussians update = {.size = sizeof(update), .count = small_count, .means = {moved, 20}};
  update.memory = SWIFTGS_DEVICE, update.stream = stream;
  CHECK_OK(swiftgs_renderer_update_scene(renderer, 0, 0, &update));
  CHECK(!draws(&d, expected));
  update.means.data = means;
  CHECK_OK(swiftgs_renderer_update_scene(renderer, 0, 0, &update));
  CHECK(cudaMemsetAsync(means, 0xff, 20 * small_count, stream) == cudaSuccess);
  CHECK(draws(&d, expected));
  update = host;
  CHECK_INVALID(swiftgs_renderer_update_scene(renderer, 0, 0, &update),
                "the arrays lie on the host, expected");
  cudaFree(moved);
  host.stream = stream; /* arrays of the host are for every renderer */
  CHECK_OK(swiftgs_renderer_set_gaussians(renderer, &host));
  CHECK(draws(&d, expected));
  swiftgs_renderer_free(renderer);
  cudaStreamDestroy(stream);

  for (int i = 0; i < 6; ++i) cudaFree((void*)to[i]->data);
  cudaFree(means);
  swiftgs_scene_free(made), swiftgs_scene_free(fetched);
}

/* Memory and streams for programs without CUDA of their own. */
static void test_device_memory(void) {
  int32_t device = -1, current = -1;
  CHECK_OK(swiftgs_device_current(&device));
  CHECK(cudaGetDevice(&current) == cudaSuccess && device == current);
  void* memory = NULL;
  const uint64_t given = 0x0123456789abcdef;
  uint64_t fetched = 0;
  CHECK_OK(swiftgs_device_allocate(sizeof(given), &memory));
  CHECK_OK(swiftgs_device_copy(memory, &given, sizeof(given), NULL));
  CHECK_OK(swiftgs_device_copy(&fetched, memory, sizeof(given), NULL));
  CHECK(fetched == given);
  CHECK_INVALID(swiftgs_device_copy(NULL, memory, 1, NULL), "to is NULL");
  swiftgs_device_free(memory);
  CHECK_ERROR(swiftgs_device_allocate((uint64_t)1 << 60, &memory), SWIFTGS_CAPACITY_ERROR, "device memory");

  cudaStream_t first = NULL, second = NULL;
  CHECK(cudaStreamCreate(&first) == cudaSuccess && cudaStreamCreate(&second) == cudaSuccess);
  CHECK_OK(swiftgs_device_order(first, second));
  CHECK_OK(swiftgs_device_order(second, second));
  CHECK(cudaStreamSynchronize(second) == cudaSuccess);
  cudaStreamDestroy(first), cudaStreamDestroy(second);
}

/* One view with all planes, over an image and behind a depth buffer, colour from the bottom up. */
static swiftgs_view all_planes(const swiftgs_camera* camera, uint8_t* colour, float* floats) {
  swiftgs_view view = {.size = sizeof(view), .format = SWIFTGS_RGBA_8, .camera = camera, .over = 1};
  view.colour = (swiftgs_plane){colour + 4 * width * (height - 1), -4 * width};
  view.alpha = (swiftgs_plane){floats, 4 * width};
  view.depth = (swiftgs_plane){floats + pixels, 4 * width};
  view.occluder = (swiftgs_plane){floats + 2 * pixels, 4 * width};
  return view;
}

/* The pixels around the middle of a view of the last frame. */
static void pick_middle(swiftgs_renderer* renderer, uint64_t view, swiftgs_picked* picked) {
  CHECK_OK(swiftgs_renderer_pick(renderer, view, width / 2 - 3, height / 2 - 3, 6, 6, picked));
}

void test_device(void) {
  if (!has_device()) skip("no CUDA device that the kernels of this build run on");
  test_device_memory();
  test_device_arrays();

  swiftgs_renderer* const renderer = make_renderer(device_renderer);
  const swiftgs_camera camera = make_camera(width, height);
  uint8_t colour[4 * pixels], fetched_colour[4 * pixels];
  const size_t bytes = 3 * sizeof(float) * pixels;
  float *const floats = make_floats(3 * pixels), *const fetched = make_floats(3 * pixels);
  for (int i = 0; i < 4 * pixels; ++i) colour[i] = (uint8_t)(i % 251);
  for (int i = 0; i < pixels; ++i) floats[2 * pixels + i] = i % 3 == 0 ? 4 : INFINITY;
  uint8_t* const device_colour = make_device_memory(sizeof(colour));
  float* const device_floats = make_device_memory(bytes);
  copy(device_colour, colour, sizeof(colour));
  copy(device_floats, floats, bytes);

  /* Memory of the device and of the host come to the same bits. The second view has RGB alone. */
  float *const rgb = make_floats(3 * pixels), *const fetched_rgb = make_floats(3 * pixels);
  float* const device_rgb = make_device_memory(bytes);
  swiftgs_view views[2] = {all_planes(&camera, device_colour, device_floats), make_view(&camera, device_rgb)};
  swiftgs_frame frame = make_frame(views, 2);
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK_OK(swiftgs_renderer_wait(renderer));
  copy(fetched_colour, device_colour, sizeof(colour));
  copy(fetched, device_floats, bytes);
  copy(fetched_rgb, device_rgb, bytes);
  swiftgs_picked expected[2][36], picked[36];
  for (uint64_t view = 0; view < 2; ++view) pick_middle(renderer, view, expected[view]);
  CHECK(expected[1][0].gaussian < small_count && expected[1][0].weight > 0);
  CHECK(memcmp(expected[0], expected[1], sizeof(picked)) == 0); /* occluders are not looked at */

  views[0] = all_planes(&camera, colour, floats), views[1] = make_view(&camera, rgb);
  frame.measure = SWIFTGS_MEASURE_TIMES;
  CHECK_OK(swiftgs_renderer_render(renderer, &frame));
  CHECK(memcmp(colour, fetched_colour, sizeof(colour)) == 0);
  CHECK(same_floats(floats, fetched, 3 * pixels));
  CHECK(same_floats(rgb, fetched_rgb, 3 * pixels));
  for (uint64_t view = 0; view < 2; ++view) {
    pick_middle(renderer, view, picked);
    CHECK(memcmp(picked, expected[view], sizeof(picked)) == 0);
  }
  float most = 0;
  for (int i = 0; i < pixels; ++i) most = fmaxf(most, floats[i]);
  CHECK(most > 0.5f);
  swiftgs_times times = {.size = sizeof(times)};
  CHECK_OK(swiftgs_renderer_times(renderer, &times));
  CHECK(times.total > 0);
  swiftgs_memory memory = {.size = sizeof(memory)};
  CHECK_OK(swiftgs_renderer_memory(renderer, &memory));
  CHECK(memory.device_total > memory.device_in_use && memory.device_in_use > 0);
  CHECK(memory.raster > 2 * bytes);
  CHECK_OK(swiftgs_renderer_trim(renderer));
  CHECK_OK(swiftgs_renderer_memory(renderer, &memory));
  CHECK(memory.raster == 0);

  /* Recorded, without the image below, which the frames above have changed. */
  views[1] = make_view(&camera, device_rgb);
  frame = make_frame(&views[1], 1);
  CHECK(cudaMemset(device_rgb, 0, bytes) == cudaSuccess);
  swiftgs_report *report = make_device_memory(sizeof(*report)), read = {0};
  CHECK_OK(swiftgs_renderer_reserve(renderer, &frame, NULL));
  CHECK_OK(swiftgs_renderer_record(renderer, report));
  CHECK_OK(swiftgs_renderer_wait(renderer));
  copy(&read, report, sizeof(read));
  copy(fetched_rgb, device_rgb, bytes);
  CHECK(read.visible > 0 && read.overflowed == 0);
  pick_middle(renderer, 0, picked);
  CHECK(memcmp(picked, expected[1], sizeof(picked)) == 0);
  CHECK(same_floats(rgb, fetched_rgb, 3 * pixels));

  /* Poses of placed scenes are written where they lie on the device. */
  swiftgs_placement both[2] = {{.size = sizeof(both[0]), .count = 900},
                               {.size = sizeof(both[0]), .first = 900}};
  CHECK_OK(swiftgs_renderer_place(renderer, both, 2));
  const swiftgs_capacity capacity = {
      .size = sizeof(capacity), .splats = small_count, .intersections = 400000};
  CHECK_OK(swiftgs_renderer_reserve(renderer, &frame, &capacity));
  swiftgs_recorded_scenes scenes = {.size = sizeof(scenes)};
  CHECK_OK(swiftgs_renderer_recorded_scenes(renderer, &scenes));
  CHECK(scenes.count == 2);
  const double scales[3] = {1, -1, 1};
  for (int i = 0; i < 3; ++i) {
    uint8_t refused[2] = {7, 7};
    copy((char*)scenes.scale + scenes.stride, &scales[i], sizeof(double));
    CHECK_OK(swiftgs_renderer_record(renderer, report));
    CHECK_OK(swiftgs_renderer_refused_scenes(renderer, refused, 2));
    CHECK(refused[0] == 0 && refused[1] == (i == 1));
    copy(fetched_rgb, device_rgb, bytes);
    CHECK(same_floats(rgb, fetched_rgb, 3 * pixels) == (i != 1));
  }
  uint64_t visible[2] = {0};
  CHECK_OK(swiftgs_renderer_render_into(renderer, &frame));
  CHECK_OK(swiftgs_renderer_visible_by_scene(renderer, visible, 2));
  CHECK(visible[0] > 0 && visible[1] > 0 && visible[0] + visible[1] == read.visible);

  /* A renderer on a stream of the program's. */
  cudaStream_t stream = NULL;
  CHECK(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking) == cudaSuccess);
  const swiftgs_renderer_options options = {.size = sizeof(options), .stream = stream};
  swiftgs_renderer* streaming = NULL;
  CHECK_OK(swiftgs_renderer_create(device_renderer, &options, &streaming));
  CHECK_OK(swiftgs_renderer_share_scene(streaming, renderer));
  memset(fetched_rgb, 0, bytes);
  views[1] = make_view(&camera, fetched_rgb);
  CHECK_OK(swiftgs_renderer_render(streaming, &frame));
  CHECK(same_floats(rgb, fetched_rgb, 3 * pixels));
  swiftgs_renderer_free(streaming);
  cudaStreamDestroy(stream);

  swiftgs_renderer_free(renderer);
  cudaFree(device_colour), cudaFree(device_floats), cudaFree(device_rgb), cudaFree(report);
}
#else
void test_device(void) { skip("this build is without CUDA"); }
#endif
