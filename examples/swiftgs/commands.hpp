// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The commands of `swiftgs` and what each is told. Every command throws on an error; `main` prints it.

#include <string>

namespace swiftgs::cli {

/// What says which scene to load.
struct SceneOptions {
  std::string scene;                    ///< a file, `builtin`, or `builtin:N`
  std::string spz_frame = "specified";  ///< as `SpzFrame` names them
};

/// What says which images to make of it.
struct ViewOptions {
  std::string cameras;  ///< a file or folder of cameras, or empty
  std::string views;    ///< such as `0,8`, `every:8` or `all`; empty for the command's own choice
  double scale = 1;     ///< of the images' sides
  std::string conventions = "gsplat";
  std::string background = "0,0,0";
};

struct RenderOptions {
  SceneOptions scene;
  ViewOptions view;
  std::string renderer;  ///< empty for `default_renderer()`
  std::string out = "renders";
  std::string format = "png";
  bool stats = false;
};

struct CheckOptions {
  SceneOptions scene;
  ViewOptions view;
  std::string renderers = "*";  ///< glob
  std::string photos;           ///< folder of photographs, or empty
  std::string json;             ///< file to write, or empty
  int repeats = 3;              ///< frames that are timed, after one that is not
};

struct CompareOptions {
  std::string a, b;
};

void info(const SceneOptions& options);
void list();
void render(const RenderOptions& options);
void compare(const CompareOptions& options);
void check(const CheckOptions& options);

}  // namespace swiftgs::cli
