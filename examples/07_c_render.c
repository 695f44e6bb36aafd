/* SPDX-License-Identifier: Apache-2.0 */

/* The C interface: renders a scene and writes frame.png. `07_c_render SCENE CAMERAS` draws a file from the
   first of its cameras, `07_c_render SCENE` from where most of it is seen, and without a word the built-in
   scene. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <swiftgs.h>

/* Ends the program with the library's own words where a call failed. */
static void check(swiftgs_status status, const char* doing) {
  if (status == SWIFTGS_OK) return;
  fprintf(stderr, "%s: %s (%s)\n", doing, swiftgs_last_error(), swiftgs_status_name(status));
  exit(1);
}

/* Called for each thing that a file has and the scene has not. */
static void print_note(void* context, const char* sentence) {
  (void)context;
  printf("%s\n", sentence);
}

static swiftgs_scene* load(const char* path) {
  swiftgs_scene* scene = NULL;
  /* A struct says how large it is; what is zero has its default. */
  const swiftgs_read_options options = {.size = sizeof(options), .note = &print_note};
  if (path)
    check(swiftgs_scene_read(path, &options, &scene), "reading the scene");
  else
    check(swiftgs_scene_builtin(20000, &scene), "making the scene");
  return scene;
}

/* In the coordinates of the scene, whose zero lies at its origin. */
static swiftgs_camera first_camera(const char* path, const swiftgs_scene_info* info) {
  swiftgs_cameras* cameras = NULL;
  swiftgs_camera camera = {.size = sizeof(camera)};
  check(swiftgs_cameras_read(path, &cameras), "reading cameras");
  check(swiftgs_cameras_get(cameras, 0, &camera), "the first camera");
  swiftgs_cameras_free(cameras);
  for (int row = 0; row < 3; ++row)
    for (int axis = 0; axis < 3; ++axis)
      camera.translation[row] += camera.rotation[3 * row + axis] * info->origin[axis];
  return camera;
}

/* The table lists the backends from the simplest to the quickest: take the last that runs here. */
static swiftgs_renderer* make_renderer(void) {
  static const char wanted[] = "/early/axis-shared-threshold-float-cholesky/ellipse";
  const char* name = NULL;
  size_t count = 0;
  check(swiftgs_renderers_count(&count), "the table of renderers");
  for (size_t i = 0; i < count; ++i) {
    swiftgs_renderer_entry entry = {.size = sizeof(entry)};
    check(swiftgs_renderers_get(i, &entry), "the table of renderers");
    if (entry.usable && strcmp(entry.name + strcspn(entry.name, "/"), wanted) == 0) name = entry.name;
  }
  swiftgs_renderer* renderer = NULL;
  check(swiftgs_renderer_create(name, NULL, &renderer), "making a renderer");
  return renderer;
}

int main(int argc, char** argv) {
  swiftgs_scene* const scene = load(argc > 1 ? argv[1] : NULL);
  swiftgs_scene_info info = {.size = sizeof(info)};
  check(swiftgs_scene_get_info(scene, &info), "what the scene holds");

  swiftgs_camera camera = {.size = sizeof(camera)};
  if (argc > 2)
    camera = first_camera(argv[2], &info);
  else if (argc > 1)
    check(swiftgs_scene_default_view(scene, 640, 360, &camera, NULL), "finding a view");
  else
    check(swiftgs_camera_builtin(640, 360, &camera), "the camera");

  /* A renderer shares the scene, or copies it to its device: here it is needed no more. */
  swiftgs_renderer* const renderer = make_renderer();
  check(swiftgs_renderer_set_scene(renderer, scene), "setting the scene");
  swiftgs_scene_free(scene);

  /* The image is the program's own memory. A device would draw into its own with
   * swiftgs_renderer_render_into. */
  const int64_t row = (int64_t)(3 * sizeof(float)) * camera.width;
  float* const pixels = malloc((size_t)row * (size_t)camera.height);
  if (!pixels) return 1;
  swiftgs_conventions conventions = {.size = sizeof(conventions)};
  check(swiftgs_conventions_named("gsplat", &conventions), "conventions");
  const swiftgs_view view = {
      .size = sizeof(view), .camera = &camera, .conventions = &conventions, .colour = {pixels, row}};
  const swiftgs_frame frame = {
      .size = sizeof(frame), .measure = SWIFTGS_MEASURE_TIMES, .views = &view, .count = 1};
  check(swiftgs_renderer_render(renderer, &frame), "rendering");

  swiftgs_times times = {.size = sizeof(times)};
  swiftgs_statistics statistics = {.size = sizeof(statistics)};
  const char* name = NULL;
  check(swiftgs_renderer_times(renderer, &times), "times");
  check(swiftgs_renderer_statistics(renderer, &statistics), "statistics");
  check(swiftgs_renderer_name(renderer, &name), "the renderer's name");
  printf("%s: %llu of %llu Gaussians in view, %.1f ms\n", name, (unsigned long long)statistics.visible,
         (unsigned long long)info.count, times.total);

  const swiftgs_image image = {
      .size = sizeof(image), .width = camera.width, .height = camera.height, .colour = view.colour};
  check(swiftgs_image_write("frame.png", &image), "writing frame.png");
  free(pixels);
  swiftgs_renderer_free(renderer);
  return statistics.visible > 0 ? 0 : 1;
}
