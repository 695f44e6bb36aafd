/* SPDX-License-Identifier: Apache-2.0 */

/* Scenes: files, arrays, and what cannot be one. */
#include <math.h>
#include <string.h>

#include "check.h"

static swiftgs_scene_info info_of(const swiftgs_scene* scene) {
  swiftgs_scene_info info = {.size = sizeof(info)};
  CHECK_OK(swiftgs_scene_get_info(scene, &info));
  return info;
}

static bool same(const swiftgs_array* a, const swiftgs_array* b, uint64_t count) {
  return a->stride == b->stride && memcmp(a->data, b->data, (size_t)a->stride * count) == 0;
}

/* Of scenes with higher bands and features. */
static bool same_scene(const swiftgs_scene* a, const swiftgs_scene* b) {
  const swiftgs_gaussians x = arrays_of(a), y = arrays_of(b);
  return x.count == y.count && x.sh_degree == y.sh_degree && x.antialiased == y.antialiased &&
         x.feature_channels == y.feature_channels && same(&x.means, &y.means, x.count) &&
         same(&x.scales, &y.scales, x.count) && same(&x.rotations, &y.rotations, x.count) &&
         same(&x.opacities, &y.opacities, x.count) && same(&x.sh0, &y.sh0, x.count) &&
         same(&x.sh_rest, &y.sh_rest, x.count) && same(&x.features, &y.features, x.count);
}

void test_scenes(void) {
  swiftgs_scene* const made = make_scene();
  const swiftgs_scene_info info = info_of(made);
  CHECK(info.count == small_count && info.stored == small_count && info.dropped == 0);
  CHECK(info.sh_degree == 3 && info.antialiased == 0 && strcmp(info.format, "") == 0);
  const swiftgs_gaussians arrays = arrays_of(made);
  CHECK(arrays.means.stride == 12 && arrays.rotations.stride == 16 && arrays.opacities.stride == 4 &&
        arrays.sh_rest.stride == 180 && arrays.memory == SWIFTGS_HOST && arrays.raw == 0);
  for (int axis = 0; axis < 3; ++axis) {
    float lower = INFINITY, upper = -INFINITY;
    for (uint64_t i = 0; i < arrays.count; ++i) {
      lower = fminf(lower, arrays.means.data[3 * i + (uint64_t)axis]);
      upper = fmaxf(upper, arrays.means.data[3 * i + (uint64_t)axis]);
    }
    CHECK(info.lower[axis] == lower && info.upper[axis] == upper && lower < upper);
  }

  CHECK_OK(swiftgs_scene_write(made, "c_scenes.ply", NULL));
  swiftgs_scene* read = NULL;
  CHECK_OK(swiftgs_scene_read("c_scenes.ply", NULL, &read));
  const swiftgs_scene_info of_file = info_of(read);
  CHECK(of_file.count == small_count && strcmp(of_file.format, "INRIA PLY (binary_little_endian)") == 0);
  const swiftgs_gaussians again = arrays_of(read);
  CHECK(same(&again.means, &arrays.means, small_count) && same(&again.sh_rest, &arrays.sh_rest, small_count));

  /* The ending of an option counts before the file's, and so does the version of an SPZ. */
  swiftgs_write_options write = {.size = sizeof(write), .ending = ".spz", .spz_version = 3};
  CHECK_OK(swiftgs_scene_write(made, "c_scenes.file", &write));
  swiftgs_scene* spz = NULL;
  CHECK_OK(swiftgs_scene_read("c_scenes.file", NULL, &spz));
  CHECK(strcmp(info_of(spz).format, "SPZ version 3") == 0);

  /* Axes of a reader: those that were not said to be so are turned. */
  const swiftgs_read_options raw = {.size = sizeof(raw), .spz_axes = SWIFTGS_SPZ_RAW};
  swiftgs_scene* turned = NULL;
  CHECK_OK(swiftgs_scene_read("c_scenes.file", &raw, &turned));
  const swiftgs_gaussians a = arrays_of(spz), b = arrays_of(turned);
  CHECK(a.means.data[0] == b.means.data[0] && a.means.data[1] == -b.means.data[1] && a.means.data[1] != 0);

  swiftgs_scene* const all[] = {made, read, spz, turned, NULL};
  for (int i = 0; i < 5; ++i) swiftgs_scene_free(all[i]);
}

/* The head of an ASCII PLY, up to other properties and elements. */
#define ONE_GAUSSIAN                                                                                \
  "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n" \
  "property float f_dc_0\nproperty float f_dc_1\nproperty float f_dc_2\nproperty float opacity\n"   \
  "property float scale_0\nproperty float scale_1\nproperty float scale_2\nproperty float rot_0\n"  \
  "property float rot_1\nproperty float rot_2\nproperty float rot_3\n"

void test_scene_camera(void) {
  write_text("c_scene_camera.ply", ONE_GAUSSIAN
             "element extrinsic 16\nproperty float extrinsic\n"
             "element intrinsic 9\nproperty float intrinsic\n"
             "element image_size 2\nproperty uint image_size\nend_header\n"
             "0 0 1 0 0 0 0 0 0 0 1 0 0 0\n"
             "0\n-1\n0\n5\n1\n0\n0\n6\n0\n0\n1\n7\n0\n0\n0\n1\n"
             "40\n0\n24\n0\n41\n16\n0\n0\n1\n48\n32\n");
  swiftgs_scene *scene = NULL, *made = make_scene();
  CHECK_OK(swiftgs_scene_read("c_scene_camera.ply", NULL, &scene));
  swiftgs_camera camera = {.size = sizeof(camera)};
  CHECK_OK(swiftgs_scene_get_camera(scene, &camera));
  CHECK(camera.width == 48 && camera.height == 32 && camera.fx == 40 && camera.fy == 41);
  CHECK(camera.cx == 24 && camera.cy == 16 && camera.rotation[1] == -1 && camera.translation[2] == 7);
  CHECK_OK(swiftgs_scene_get_camera(made, &camera));
  CHECK(camera.size == sizeof(camera) && camera.width == 0 && camera.fx == 0 && camera.translation[2] == 0);
  CHECK_NULLS(swiftgs_scene_get_camera, made, "scene", &camera, "swiftgs_camera");
  swiftgs_scene_free(scene), swiftgs_scene_free(made);
}

void test_orbit(void) {
  swiftgs_scene* const scene = make_scene();
  swiftgs_scene_bounds bounds = {.size = sizeof(bounds)};
  CHECK_OK(swiftgs_scene_robust_bounds(scene, &bounds));
  CHECK(bounds.size == sizeof(bounds) && bounds.radius > 0);

  /* What these fill in, same_bits_test compares with the C++ interface. */
  swiftgs_camera camera = {.size = sizeof(camera)};
  swiftgs_orbit orbit = {.size = sizeof(orbit), .up = {0, 0, 7}};
  CHECK_OK(swiftgs_scene_default_view(scene, 80, 60, &camera, &orbit));
  CHECK(camera.width == 80 && camera.height == 60 && orbit.size == sizeof(orbit));
  swiftgs_camera moved = camera;
  CHECK_OK(swiftgs_camera_orbit(&moved, &orbit)); /* zeros move nothing */
  for (int row = 0; row < 3; ++row) CHECK(fabs(moved.translation[row] - camera.translation[row]) < 1e-9);
  CHECK_OK(swiftgs_scene_default_view(scene, 80, 60, &camera, NULL));

  CHECK_NULLS(swiftgs_scene_robust_bounds, scene, "scene", &bounds, "swiftgs_scene_bounds");
  CHECK_NULLS(swiftgs_camera_orbit, &camera, "swiftgs_camera", &orbit, "swiftgs_orbit");
  CHECK_INVALID(swiftgs_scene_default_view(NULL, 80, 60, &camera, &orbit), "scene is NULL");
  CHECK_INVALID(swiftgs_scene_default_view(scene, 80, 60, NULL, &orbit), "swiftgs_camera is NULL");
  CHECK_INVALID(swiftgs_scene_default_view(scene, 0, 60, &camera, &orbit), "the image is 0 x 60");
  orbit.distance = -1;
  CHECK_INVALID(swiftgs_camera_orbit(&camera, &orbit), "a finite distance above 0");
  orbit.reserved = 1;
  CHECK_INVALID(swiftgs_camera_orbit(&camera, &orbit), "reserved is 1");
  CHECK_INVALID(swiftgs_scene_default_view(scene, 80, 60, &camera, &orbit), "reserved is 1");
  swiftgs_scene_free(scene);
}

struct heard {
  int calls, notes;
  double last;
  bool cancel;
};

static int32_t hear_progress(void* context, double part) {
  struct heard* const heard = context;
  CHECK(part >= heard->last && part <= 1);
  heard->last = part;
  ++heard->calls;
  return heard->cancel;
}

static void hear_note(void* context, const char* sentence) {
  CHECK(strlen(sentence) > 0 && sentence[strlen(sentence) - 1] == '.');
  ++((struct heard*)context)->notes;
}

void test_progress(void) {
  swiftgs_scene* const made = make_scene();
  struct heard heard = {0};
  swiftgs_write_options write = {
      .size = sizeof(write), .progress = &hear_progress, .note = &hear_note, .context = &heard};
  /* Records of 32 bytes leave the higher bands out, which is worth a note. */
  CHECK_OK(swiftgs_scene_write(made, "c_progress.splat", &write));
  CHECK(heard.calls > 0 && heard.notes > 0);

  struct heard reading = {0};
  swiftgs_read_options read = {
      .size = sizeof(read), .progress = &hear_progress, .note = &hear_note, .context = &reading};
  CHECK_OK(swiftgs_scene_write(made, "c_progress.ply", NULL));
  swiftgs_scene* scene = NULL;
  CHECK_OK(swiftgs_scene_read("c_progress.ply", &read, &scene));
  CHECK(reading.calls > 0);
  swiftgs_scene_free(scene);

  /* A property that no scene carries is worth one as well. */
  static const char text[] =
      ONE_GAUSSIAN "property float of_its_own\nend_header\n0 0 1 0 0 0 0 0 0 0 1 0 0 0 7\n";
  const swiftgs_file_bytes bytes = {
      .size = sizeof(bytes), .data = text, .count = sizeof(text) - 1, .name = "memory.ply"};
  struct heard noted = {0};
  read.context = &noted;
  CHECK_OK(swiftgs_scene_read_bytes(&bytes, &read, &scene));
  CHECK(info_of(scene).count == 1 && arrays_of(scene).means.data[2] == 1 && noted.notes > 0);
  swiftgs_scene_free(scene);

  struct heard cancelling = {.cancel = true};
  read.context = write.context = &cancelling;
  scene = NULL;
  CHECK_ERROR(swiftgs_scene_read("c_progress.ply", &read, &scene), SWIFTGS_CANCELLED,
              "c_progress.ply: cancelled");
  CHECK(scene == NULL);
  cancelling.last = 0;
  CHECK_ERROR(swiftgs_scene_write(made, "c_progress.ply", &write), SWIFTGS_CANCELLED,
              "c_progress.ply: cancelled");
  swiftgs_scene_free(made);
}

/* Two Gaussians of degree 1 as a file of training holds them: all numbers of one side by side. */
struct row {
  float mean[3], log_scale[3], rotation[4], logit, sh0[3], sh_rest[9], features[2];
};
static const struct row rows[2] = {
    {{1, 2, 3}, {-1, 0, 1}, {2, 0, 0, 0}, 0, {4, 5, 6}, {1, 2, 3, 4, 5, 6, 7, 8, 9}, {-1, 40}},
    {{-1, -2, -3}, {0, 0.5f, -4}, {1, 1, 1, 1}, 2, {7, 8, 9}, {9, 8, 7, 6, 5, 4, 3, 2, 1}, {3, -50}},
};

static swiftgs_gaussians arrays_in_rows(void) {
  const int64_t stride = sizeof(struct row);
  const swiftgs_gaussians arrays = {
      .size = sizeof(arrays),
      .sh_degree = 1,
      .count = 2,
      .means = {rows[0].mean, stride},
      .scales = {rows[0].log_scale, stride},
      .rotations = {rows[0].rotation, stride},
      .opacities = {&rows[0].logit, stride},
      .sh0 = {rows[0].sh0, stride},
      .sh_rest = {rows[0].sh_rest, stride},
      .raw = SWIFTGS_LOG_SCALES | SWIFTGS_LOGIT_OPACITIES | SWIFTGS_ANY_ROTATIONS,
      .antialiased = 1,
      .feature_channels = 2,
      .features = {rows[0].features, stride},
      .blur = 0.1f,
      .order = SWIFTGS_ORDER_DISTANCE,
      .colours = SWIFTGS_COLOURS_LINEAR};
  return arrays;
}

static swiftgs_scene* scene_of(const swiftgs_gaussians* arrays) {
  swiftgs_scene* scene = NULL;
  CHECK_OK(swiftgs_scene_from_arrays(arrays, &scene));
  return scene;
}

void test_arrays(void) {
  const swiftgs_gaussians given = arrays_in_rows();
  swiftgs_scene* const scene = scene_of(&given);
  const swiftgs_scene_info info = info_of(scene);
  CHECK(info.count == 2 && info.stored == 2 && info.sh_degree == 1 && info.antialiased == 1);
  CHECK(info.blur == 0.1f && info.order == SWIFTGS_ORDER_DISTANCE);
  CHECK(info.colours == SWIFTGS_COLOURS_LINEAR && info.kernel == SWIFTGS_KERNEL_ELLIPSOID);
  CHECK(info.feature_channels == 2);
  CHECK(info.lower[2] == -3 && info.upper[2] == 3);
  const swiftgs_gaussians kept = arrays_of(scene);
  for (int i = 0; i < 2; ++i) {
    const struct row* const row = &rows[i];
    CHECK(memcmp(kept.means.data + 3 * i, row->mean, sizeof(row->mean)) == 0);
    CHECK(memcmp(kept.sh0.data + 3 * i, row->sh0, sizeof(row->sh0)) == 0);
    CHECK(memcmp(kept.sh_rest.data + 9 * i, row->sh_rest, sizeof(row->sh_rest)) == 0);
    CHECK(memcmp(kept.features.data + 2 * i, row->features, sizeof(row->features)) == 0);
    for (int axis = 0; axis < 3; ++axis) CHECK(kept.scales.data[3 * i + axis] == expf(row->log_scale[axis]));
    CHECK(kept.opacities.data[i] == 1 / (1 + expf(-row->logit)));
  }
  static const float unit[] = {1, 0, 0, 0, 0.5f, 0.5f, 0.5f, 0.5f};
  CHECK(memcmp(kept.rotations.data, unit, sizeof(unit)) == 0);

  /* Activated numbers keep their bits. */
  swiftgs_scene* copy = scene_of(&kept);
  CHECK(same_scene(scene, copy));
  swiftgs_scene_free(copy);

  /* A program that is older than features. */
  swiftgs_gaussians older = given;
  older.size = offsetof(swiftgs_gaussians, features), older.feature_channels = 0;
  copy = scene_of(&older);
  CHECK(info_of(copy).feature_channels == 0 && arrays_of(copy).features.data == NULL);
  swiftgs_scene_free(copy);
  older.feature_channels = -1;
  CHECK(swiftgs_scene_get_arrays(scene, &older) == SWIFTGS_OK && older.feature_channels == 0);

  /* One that is older than origins, and one that is not. */
  older = given;
  older.size = offsetof(swiftgs_gaussians, origin);
  copy = scene_of(&older);
  CHECK(info_of(copy).origin[0] == 0 && swiftgs_scene_get_arrays(copy, &older) == SWIFTGS_OK);
  swiftgs_scene_free(copy);
  swiftgs_gaussians far = given;
  far.origin[0] = 1e7, far.origin[2] = -0.5;
  copy = scene_of(&far);
  CHECK(info_of(copy).origin[0] == 1e7 && info_of(copy).origin[1] == 0 && info_of(copy).origin[2] == -0.5);
  CHECK(arrays_of(copy).origin[0] == 1e7 && arrays_of(copy).origin[2] == -0.5);
  CHECK(memcmp(info_of(copy).lower, info_of(scene).lower, sizeof(info_of(copy).lower)) == 0);
  CHECK_INVALID(swiftgs_scene_get_arrays(copy, &older), "the program is older than origins");
  swiftgs_scene_info old_info = {.size = offsetof(swiftgs_scene_info, origin)};
  CHECK(swiftgs_scene_get_info(copy, &old_info) == SWIFTGS_OK && old_info.count == given.count);
  swiftgs_scene_free(copy);
  far.origin[1] = 1e300;
  CHECK_INVALID(swiftgs_scene_from_arrays(&far, &copy), "scene: origin has 1000000");

  /* Dense arrays need no stride, degree 0 no higher bands, and no Gaussians no arrays. */
  const float numbers[] = {1, 2, 3, 4};
  swiftgs_gaussians one = {.size = sizeof(one), .count = 1};
  one.means.data = one.scales.data = one.rotations.data = one.opacities.data = one.sh0.data = numbers;
  copy = scene_of(&one);
  CHECK(arrays_of(copy).rotations.data[3] == 4);
  swiftgs_scene_free(copy);
  const swiftgs_gaussians none = {.size = sizeof(none), .sh_degree = 3};
  copy = scene_of(&none);
  const swiftgs_scene_info of_none = info_of(copy);
  CHECK(of_none.count == 0 && of_none.lower[0] == 0 && of_none.upper[0] == 0);
  CHECK(arrays_of(copy).means.data == NULL);
  swiftgs_scene_free(copy);

  /* Colours become coefficients. */
  one.raw = SWIFTGS_PLAIN_COLOURS;
  copy = scene_of(&one);
  CHECK(arrays_of(copy).sh0.data[2] == (float)((3 - 0.5) / 0.28209479177387814));
  swiftgs_scene_free(copy);

  /* Means that are not finite have no part in the bounds. */
  const float means[] = {NAN, 0, 0, 1, 2, 3, INFINITY, 9, 9};
  const float twelve[12] = {0};
  swiftgs_gaussians three = {.size = sizeof(three), .count = 3};
  three.means.data = means;
  three.scales.data = three.rotations.data = three.opacities.data = three.sh0.data = twelve;
  copy = scene_of(&three);
  const swiftgs_scene_info of_three = info_of(copy);
  CHECK(of_three.count == 3 && of_three.lower[1] == 2 && of_three.upper[1] == 2);
  swiftgs_scene_free(copy), swiftgs_scene_free(scene);
}

static void refuse_arrays(const swiftgs_gaussians* arrays, const char* part) {
  swiftgs_scene* scene = NULL;
  CHECK_INVALID(swiftgs_scene_from_arrays(arrays, &scene), part);
  CHECK(scene == NULL);
}

static void test_array_errors(void) {
  swiftgs_gaussians arrays = arrays_in_rows();
  CHECK_INVALID(swiftgs_scene_from_arrays(&arrays, NULL), "scene is NULL");
  refuse_arrays(NULL, "swiftgs_gaussians is NULL");
#define REFUSE(change, part) arrays = arrays_in_rows(), arrays.change, refuse_arrays(&arrays, part)
  REFUSE(sh_degree = 4, "sh_degree is 4, expected 0 to 3");
  REFUSE(rotations.stride = 12, "rotations: stride is 12 bytes, expected 0 or a multiple of 4 from 16");
  REFUSE(count = (uint64_t)1 << 32, "4294967296 Gaussians, expected fewer than 2^32");
  REFUSE(memory = 2, "memory is 2, expected 0 to 1");
  REFUSE(raw = 16, "raw is 16, expected a sum of 1, 2, 4 and 8");
#undef REFUSE
}

void test_scene_errors(void) {
  swiftgs_scene* scene = NULL;
  CHECK_ERROR(swiftgs_scene_read("nowhere.ply", NULL, &scene), SWIFTGS_SYSTEM_ERROR, "nowhere.ply");
  write_text("c_errors.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n");
  CHECK_ERROR(swiftgs_scene_read("c_errors.ply", NULL, &scene), SWIFTGS_FORMAT_ERROR, "c_errors.ply: byte");
  CHECK_INVALID(swiftgs_scene_read(NULL, NULL, &scene), "path is NULL");
  CHECK_INVALID(swiftgs_scene_read("c_errors.ply", NULL, NULL), "scene is NULL");
  swiftgs_read_options read = {.size = sizeof(read), .spz_axes = 5};
  CHECK_INVALID(swiftgs_scene_read("c_errors.ply", &read, &scene),
                "swiftgs_read_options: spz_axes is 5, expected 0 to 4");
  read.spz_axes = 0, read.reserved = 1;
  CHECK_INVALID(swiftgs_scene_read("c_errors.ply", &read, &scene), "reserved is 1");

  swiftgs_file_bytes bytes = {.size = sizeof(bytes), .data = "none", .count = 4, .name = "memory"};
  CHECK_ERROR(swiftgs_scene_read_bytes(&bytes, NULL, &scene), SWIFTGS_FORMAT_ERROR, "memory: byte");
  CHECK_INVALID(swiftgs_scene_read_bytes(&bytes, NULL, NULL), "scene is NULL");
  bytes.data = NULL;
  CHECK_INVALID(swiftgs_scene_read_bytes(&bytes, NULL, &scene), "data is NULL");
  bytes.count = 0;
  CHECK_ERROR(swiftgs_scene_read_bytes(&bytes, NULL, &scene), SWIFTGS_FORMAT_ERROR, "memory: byte 0");
  bytes.reserved = 1;
  CHECK_INVALID(swiftgs_scene_read_bytes(&bytes, NULL, &scene), "reserved is 1");
  bytes.reserved = 0, bytes.name = NULL;
  CHECK_INVALID(swiftgs_scene_read_bytes(&bytes, NULL, &scene), "name is NULL");
  CHECK_INVALID(swiftgs_scene_read_bytes(NULL, NULL, &scene), "swiftgs_file_bytes is NULL");

  CHECK_INVALID(swiftgs_scene_builtin(1, NULL), "scene is NULL");
  CHECK_INVALID(swiftgs_scene_builtin((uint64_t)1 << 32, &scene), "fewer than 2^32");
  CHECK(scene == NULL);
  test_array_errors();

  scene = make_scene();
  swiftgs_scene_info info = {.size = sizeof(info)};
  CHECK_NULLS(swiftgs_scene_get_info, scene, "scene", &info, "swiftgs_scene_info");
  info.size = 4;
  CHECK_INVALID(swiftgs_scene_get_info(scene, &info), "swiftgs_scene_info: size is 4");
  swiftgs_gaussians arrays = {.size = sizeof(arrays)};
  CHECK_NULLS(swiftgs_scene_get_arrays, scene, "scene", &arrays, "swiftgs_gaussians");

  CHECK_INVALID(swiftgs_scene_write(NULL, "c_errors.ply", NULL), "scene is NULL");
  CHECK_INVALID(swiftgs_scene_write(scene, NULL, NULL), "path is NULL");
  CHECK_INVALID(swiftgs_scene_write(scene, "c_errors.obj", NULL), "c_errors.obj");
  CHECK_ERROR(swiftgs_scene_write(scene, "nowhere/c_errors.ply", NULL), SWIFTGS_SYSTEM_ERROR, "nowhere");
  swiftgs_write_options write = {.size = sizeof(write), .spz_version = 2};
  CHECK_INVALID(swiftgs_scene_write(scene, "c_errors.spz", &write), "2");
  write.spz_version = 0, write.spz_axes = -1;
  CHECK_INVALID(swiftgs_scene_write(scene, "c_errors.spz", &write), "swiftgs_write_options: spz_axes is -1");
  write.spz_axes = 0, write.reserved = 1;
  CHECK_INVALID(swiftgs_scene_write(scene, "c_errors.spz", &write), "reserved is 1");
  swiftgs_scene_free(scene);
}
