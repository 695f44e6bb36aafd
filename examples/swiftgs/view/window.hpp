// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include <swiftgs/frame.hpp>

#include "view/navigation.hpp"

struct GLFWwindow;

namespace swiftgs::cli {

/// The user's input since the last frame, without what panels took.
struct Events {
  Input input;                       ///< of which `move` is -1, 0 or 1 each, four times as much with Shift
  std::vector<char> keys;            ///< letters, digits and space that were pressed; capital letters
  std::vector<std::string> dropped;  ///< files
  bool clicked = false, double_clicked = false;
  bool escape = false;  ///< was pressed, and no text that is typed took it
  bool closes = false;  ///< the user closes the window, which stays
  int x = 0, y = 0;     ///< the mouse @units{pixels}
  double seconds = 0;
};

/// A window with a picture and panels of Dear ImGui before it.
class Window {
 public:
  /// Opens a window that is hidden until `show`. Throws `Unavailable` where there is no display.
  Window(const char* title, int width, int height);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  void show(const std::string& title);
  int width() const;  ///< @units{pixels}; 0 if minimised, as is the height
  int height() const;

  /// Begins a frame: waits for the user unless `busy`. Panels are drawn between this and `end_frame`.
  Events begin_frame(bool busy);
  void end_frame();
  /// Sets the picture behind the panels, which fills the window whatever its size.
  void set_picture(const Frame& picture);

 private:
  /// Makes text and controls as large as the display's dots ask for.
  void scale_panels();
  Input input(double seconds) const;

  GLFWwindow* window_ = nullptr;
  unsigned texture_ = 0;
  std::vector<unsigned char> bytes_;
  Events pending_;  ///< of callbacks
  int lively_frames_ = 0;
  double last_ = 0;
  bool dragged_ = false;
};

/// Seconds since some time before the window was opened.
double window_time();

}  // namespace swiftgs::cli
