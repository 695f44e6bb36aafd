/* SPDX-License-Identifier: Apache-2.0 */

/* Cameras and images. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "check.h"

static const char* const two_cameras =
    "[{\"id\": 0, \"img_name\": \"a.png\", \"width\": 640, \"height\": 480, \"position\": [1, 2, 3],"
    " \"rotation\": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], \"fx\": 500, \"fy\": 510},"
    "{\"id\": 1, \"img_name\": \"b.png\", \"width\": 320, \"height\": 240, \"position\": [0, 0, -4],"
    " \"rotation\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"fx\": 250, \"fy\": 255}]";

/* From (0, 0, z) to the origin. */
static swiftgs_look_at look_from(double z) {
  swiftgs_look_at look = {.size = sizeof(look), .width = 200, .height = 100, .vertical_fov = 1};
  look.eye[2] = z, look.up[1] = -1;
  return look;
}

static swiftgs_cameras* read_cameras(const char* path, const char* text) {
  swiftgs_cameras* cameras = NULL;
  write_text(path, text);
  CHECK_OK(swiftgs_cameras_read(path, &cameras));
  return cameras;
}

void test_cameras(void) {
  swiftgs_cameras* const cameras = read_cameras("c_cameras.json", two_cameras);
  size_t count = 0;
  CHECK_OK(swiftgs_cameras_count(cameras, &count));
  CHECK(count == 2);
  const char* name = NULL;
  CHECK_OK(swiftgs_cameras_name(cameras, 1, &name));
  CHECK(name && strcmp(name, "b.png") == 0);
  CHECK_OK(swiftgs_cameras_note_count(cameras, &count));
  CHECK(count == 0);

  /* The file has the inverse: camera to world. Rows and columns must not change places. */
  swiftgs_camera camera = {.size = sizeof(camera)};
  CHECK_OK(swiftgs_cameras_get(cameras, 0, &camera));
  CHECK(camera.width == 640 && camera.height == 480 && camera.fx == 500 && camera.fy == 510);
  CHECK(camera.rotation[1] == 1 && camera.rotation[3] == -1 && camera.translation[0] == -2);

  CHECK_OK(swiftgs_camera_scale(&camera, 0.5));
  CHECK(camera.width == 320 && camera.height == 240 && camera.fx == 250 && camera.cy == 120);
  CHECK(camera.size == sizeof(camera));

  /* A lens stays what it is. */
  camera.lens = SWIFTGS_LENS_FISHEYE;
  for (int i = 0; i < 4; ++i) camera.radial[i] = 1 + i;
  for (int i = 0; i < 3; ++i) camera.rational[i] = 5 + i;
  for (int i = 0; i < 2; ++i) camera.tangential[i] = 8 + i, camera.prism[i] = 10 + i;
  const swiftgs_camera before = camera;
  CHECK_OK(swiftgs_camera_scale(&camera, 2));
  CHECK(camera.width == 640 && camera.lens == SWIFTGS_LENS_FISHEYE);
  const size_t from = offsetof(swiftgs_camera, radial);
  CHECK(memcmp((char*)&camera + from, (const char*)&before + from, sizeof(camera) - from) == 0);

  const swiftgs_look_at look = look_from(-5);
  CHECK_OK(swiftgs_camera_look_at(&look, &camera));
  CHECK(camera.width == 200 && camera.cx == 100 && fabs(camera.fy - 50 / tan(0.5)) < 1e-9);
  CHECK(fabs(camera.translation[2] - 5) < 1e-12 && fabs(camera.rotation[0] - 1) < 1e-12);
  CHECK(camera.lens == SWIFTGS_LENS_PERSPECTIVE && camera.radial[0] == 0);
  swiftgs_cameras_free(cameras);
  swiftgs_cameras_free(NULL);
}

void test_camera_notes(void) {
  swiftgs_cameras* const cameras =
      read_cameras("c_camera_notes.json",
                   "{\"applied_scale\": 0.5, \"exposure\": 2, \"w\": 64, \"h\": 48, \"fl_x\": 50,"
                   " \"frames\": [{\"file_path\": \"a.png\","
                   " \"transform_matrix\": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}]}");
  size_t count = 0;
  CHECK_OK(swiftgs_cameras_count(cameras, &count));
  CHECK(count == 1);
  CHECK_OK(swiftgs_cameras_note_count(cameras, &count));
  CHECK(count == 2);
  const char *first = NULL, *second = NULL;
  CHECK_OK(swiftgs_cameras_note(cameras, 0, &first));
  CHECK_OK(swiftgs_cameras_note(cameras, 1, &second));
  CHECK(first && strstr(first, "dataparser_transforms.json"));
  CHECK(second && strcmp(second, "Keys that may change the picture were not read: exposure.") == 0);

  const char* none = NULL;
  CHECK_INVALID(swiftgs_cameras_note(cameras, 2, &none), "notes: number 2, expected less than 2");
  CHECK_INVALID(swiftgs_cameras_note(cameras, 0, NULL), "note is NULL");
  CHECK_INVALID(swiftgs_cameras_note(NULL, 0, &none), "cameras is NULL");
  CHECK_NULLS(swiftgs_cameras_note_count, cameras, "cameras", &count, "count");
  CHECK(none == NULL);
  swiftgs_cameras_free(cameras);
}

void test_camera_errors(void) {
  swiftgs_cameras* cameras = NULL;
  CHECK_ERROR(swiftgs_cameras_read("nowhere.json", &cameras), SWIFTGS_SYSTEM_ERROR, "nowhere.json");
  write_text("c_bad_cameras.json", "[{\"id\": 0}]");
  CHECK_ERROR(swiftgs_cameras_read("c_bad_cameras.json", &cameras), SWIFTGS_FORMAT_ERROR,
              "c_bad_cameras.json");
  CHECK_NULLS(swiftgs_cameras_read, "c_bad_cameras.json", "path", &cameras, "cameras");
  CHECK(cameras == NULL);

  cameras = read_cameras("c_camera_errors.json", two_cameras);
  size_t count = 0;
  const char* name = NULL;
  swiftgs_camera camera = {.size = sizeof(camera)};
  CHECK_NULLS(swiftgs_cameras_count, cameras, "cameras", &count, "count");
  CHECK_INVALID(swiftgs_cameras_get(cameras, 2, &camera), "cameras: number 2, expected less than 2");
  CHECK_INVALID(swiftgs_cameras_get(cameras, 0, NULL), "swiftgs_camera is NULL");
  CHECK_INVALID(swiftgs_cameras_get(NULL, 0, &camera), "cameras is NULL");
  CHECK_INVALID(swiftgs_cameras_name(cameras, 2, &name), "number 2");
  CHECK_INVALID(swiftgs_cameras_name(cameras, 0, NULL), "name is NULL");
  CHECK_INVALID(swiftgs_cameras_name(NULL, 0, &name), "cameras is NULL");
  swiftgs_cameras_free(cameras);

  CHECK_INVALID(swiftgs_camera_scale(NULL, 1), "swiftgs_camera is NULL");
  camera = make_camera(64, 48);
  CHECK_INVALID(swiftgs_camera_scale(&camera, 0), "a finite scale above 0");
  camera.lens = 4;
  CHECK_INVALID(swiftgs_camera_scale(&camera, 1), "swiftgs_camera: lens is 4, expected 0 to 3");

  swiftgs_look_at look = look_from(0);
  CHECK_INVALID(swiftgs_camera_look_at(&look, &camera), "to span a frame");
  look.target[2] = 1, look.vertical_fov = 4;
  CHECK_INVALID(swiftgs_camera_look_at(&look, &camera), "vertical_fov is 4");
  look.vertical_fov = 1, look.reserved = 1;
  CHECK_INVALID(swiftgs_camera_look_at(&look, &camera), "reserved is 1");
  look.reserved = 0;
  CHECK_NULLS(swiftgs_camera_look_at, &look, "swiftgs_look_at", &camera, "swiftgs_camera");
}

void test_matrices(void) {
  /* OpenGL, symmetric, from (0, 0, 4) to the origin with y up: near 1, far 3, and 90 degrees of a square. */
  swiftgs_matrices from = {
      .size = sizeof(from), .clip_space = SWIFTGS_CLIP_OPENGL, .width = 200, .height = 200};
  from.view[0] = from.view[5] = from.view[10] = from.view[15] = 1, from.view[14] = -4;
  from.projection[0] = from.projection[5] = 1, from.projection[10] = -2, from.projection[11] = -1;
  from.projection[14] = -3;
  swiftgs_camera camera = {.size = sizeof(camera)};
  swiftgs_stored_depth depth = {0, 0, 0, 0};
  CHECK_OK(swiftgs_camera_from_matrices(&from, &camera, &depth));
  CHECK(camera.width == 200 && camera.fx == 100 && camera.translation[2] == 4 && camera.rotation[4] == -1);
  const swiftgs_stored_depth wanted = swiftgs_stored_perspective(1, 3);
  CHECK(depth.p == 0 && depth.q == 1 && fabs(depth.r - wanted.r) < 1e-12 && fabs(depth.s - wanted.s) < 1e-12);
  CHECK_OK(swiftgs_camera_from_matrices(&from, &camera, NULL));
  swiftgs_matrices back = {.size = sizeof(back)};
  CHECK_OK(swiftgs_camera_to_matrices(&camera, SWIFTGS_CLIP_OPENGL, 1, 3, &back));
  CHECK(back.size == sizeof(back) && back.clip_space == SWIFTGS_CLIP_OPENGL && back.width == 200);
  for (int i = 0; i < 16; ++i)
    CHECK(back.view[i] == from.view[i] && fabs(back.projection[i] - from.projection[i]) < 1e-12);

  CHECK_INVALID(swiftgs_camera_from_matrices(NULL, &camera, NULL), "swiftgs_matrices is NULL");
  CHECK_INVALID(swiftgs_camera_from_matrices(&from, NULL, NULL), "swiftgs_camera is NULL");
  CHECK_INVALID(swiftgs_camera_to_matrices(NULL, 0, 1, 3, &back), "swiftgs_camera is NULL");
  CHECK_INVALID(swiftgs_camera_to_matrices(&camera, 0, 1, 3, NULL), "swiftgs_matrices is NULL");
  CHECK_INVALID(swiftgs_camera_to_matrices(&camera, 3, 1, 3, &back), "clip_space is 3, expected 0 to 2");
  from.clip_space = -1;
  CHECK_INVALID(swiftgs_camera_from_matrices(&from, &camera, NULL), "swiftgs_matrices: clip_space is -1");
}

struct png {
  uint8_t bytes[1024];
  uint64_t count;
};

static void keep_bytes(void* context, const void* bytes, uint64_t count) {
  struct png* const png = context;
  CHECK(png->count == 0 && count > 0 && count <= sizeof(png->bytes));
  if (count <= sizeof(png->bytes)) memcpy(png->bytes, bytes, count);
  png->count = count;
}

static bool is_file(const struct png* png, const char* path) {
  uint8_t bytes[sizeof(png->bytes)];
  FILE* const file = fopen(path, "rb");
  const size_t count = file ? fread(bytes, 1, sizeof(bytes), file) : 0;
  if (file) fclose(file);
  return count == png->count && memcmp(bytes, png->bytes, count) == 0;
}

/* Pixels of 8 bits with blue first, of half their colours' alpha. */
static void test_png(void) {
  const uint8_t pixels[2][4] = {{10, 20, 30, 255}, {50, 100, 0, 128}};
  swiftgs_image image = {.size = sizeof(image), .width = 2, .height = 1, .format = SWIFTGS_BGRA_8};
  image.colour.data = (void*)pixels, image.colour.pitch = sizeof(pixels);
  struct png png = {.count = 0};
  CHECK_OK(swiftgs_png_encode(&image, keep_bytes, &png));
  CHECK_OK(swiftgs_image_write("c_bgra.png", &image));
  CHECK(is_file(&png, "c_bgra.png"));
  swiftgs_picture* picture = NULL;
  swiftgs_pixels read = {.size = sizeof(read)};
  CHECK_OK(swiftgs_picture_read("c_bgra.png", &picture));
  CHECK_OK(swiftgs_picture_get(picture, &read));
  const float expected[8] = {30, 20, 10, 255, 0, 199, 100, 128};
  CHECK(read.width == 2 && read.height == 1 && read.channels == 4);
  for (int i = 0; i < 8; ++i) CHECK(read.data[i] == expected[i] / 255);
  swiftgs_picture_free(picture);

  CHECK_INVALID(swiftgs_png_encode(&image, NULL, NULL), "take is NULL, expected a function");
  CHECK_INVALID(swiftgs_png_encode(NULL, keep_bytes, &png), "swiftgs_image is NULL");
  for (image.format = -1; image.format <= 5; image.format += 6)
    CHECK_INVALID(swiftgs_png_encode(&image, keep_bytes, &png), "swiftgs_image: format is");
  image.format = SWIFTGS_BGRA_8, image.colour.data = NULL;
  CHECK_INVALID(swiftgs_png_encode(&image, keep_bytes, &png), "colour is NULL");
}

void test_images(void) {
  test_png();
  /* Two rows of two pixels, in memory from the bottom up. */
  float pixels[2][8] = {{7, 8, 9, 10, 11, 12, -1, -1}, {1, 2, 3, 4, 5, 6, -1, -1}};
  float depth[2][2] = {{1, 2}, {3, 4}};
  swiftgs_image image = {.size = sizeof(image), .width = 2, .height = 2};
  image.colour.data = pixels[1];
  image.colour.pitch = -(int64_t)sizeof(pixels[0]);
  image.depth.data = depth;
  image.depth.pitch = sizeof(depth[0]);
  CHECK_OK(swiftgs_image_write("c_images.PFM", &image));
  CHECK_OK(swiftgs_image_write("c_images.png", &image));
  swiftgs_picture* picture = NULL;
  swiftgs_pixels read = {.size = sizeof(read)};
  CHECK_OK(swiftgs_picture_read("c_images.PFM", &picture));
  CHECK_OK(swiftgs_picture_get(picture, &read));
  CHECK(read.width == 2 && read.height == 2 && read.channels == 3);
  CHECK(memcmp(read.data, pixels[1], 6 * sizeof(float)) == 0);
  CHECK(memcmp(read.data + 6, pixels[0], 6 * sizeof(float)) == 0);
  CHECK_NULLS(swiftgs_picture_get, picture, "picture", &read, "swiftgs_pixels");
  swiftgs_picture_free(picture), swiftgs_picture_free(NULL);
  write_text("c_images.bad", "no image");
  CHECK_ERROR(swiftgs_picture_read("c_images.bad", &picture), SWIFTGS_FORMAT_ERROR, "c_images.bad");
  CHECK_ERROR(swiftgs_picture_read("c_images.none", &picture), SWIFTGS_SYSTEM_ERROR, "c_images.none");
  CHECK_INVALID(swiftgs_picture_read("c_images.PFM", NULL), "picture is NULL");

  const swiftgs_status exr = swiftgs_image_write("c_images.exr", &image);
  if (exr != SWIFTGS_OK) CHECK_ERROR(exr, SWIFTGS_UNAVAILABLE, "this build is without OpenEXR");
  /* A program that is older than other planes. */
  image.size = offsetof(swiftgs_image, squared_depth);
  CHECK_OK(swiftgs_image_write("c_images.png", &image));
  image.size = sizeof(image);

  CHECK_NULLS(swiftgs_image_write, "c_images.png", "path", &image, "swiftgs_image");
  CHECK_INVALID(swiftgs_image_write("c_images.bmp", &image), "c_images.bmp");
  CHECK_ERROR(swiftgs_image_write("nowhere/c_images.png", &image), SWIFTGS_SYSTEM_ERROR, "nowhere");
  image.colour.pitch = 8;
  CHECK_INVALID(swiftgs_image_write("c_images.png", &image), "the pitch of colour is 8");
  image.colour.data = NULL;
  CHECK_INVALID(swiftgs_image_write("c_images.png", &image), "colour is NULL");
}
