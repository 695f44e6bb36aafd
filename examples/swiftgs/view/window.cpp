// SPDX-License-Identifier: Apache-2.0
#include "view/window.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl2.h>
#include <imgui.h>

#include "draw/rgb_bytes.hpp"

namespace swiftgs::cli {
namespace {

/// Panels take some frames to answer an event: a button that is hovered, pressed and released.
constexpr int frames_an_event = 4;
/// Between looks at what no event tells of.
constexpr double longest_wait = 0.25;

[[noreturn]] void fail() {
  const char* reason = "";
  glfwGetError(&reason);
  throw std::runtime_error("view: " + std::string(reason ? reason : "no window") +
                           "; expected a display with OpenGL");
}

}  // namespace

Window::Window(const char* title, int width, int height) {
  if (!glfwInit()) fail();
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  window_ = glfwCreateWindow(width, height, title, nullptr, nullptr);
  if (!window_) glfwTerminate(), fail();
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, this);
  // Dear ImGui calls those that are there before it.
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
    Events& pending = static_cast<Window*>(glfwGetWindowUserPointer(window))->pending_;
    if (action == GLFW_PRESS && key >= GLFW_KEY_SPACE && key <= GLFW_KEY_Z) pending.keys.push_back(char(key));
    if (action == GLFW_PRESS && key == GLFW_KEY_ESCAPE) pending.escape = true;
  });
  glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** names) {
    auto& dropped = static_cast<Window*>(glfwGetWindowUserPointer(window))->pending_.dropped;
    dropped.insert(dropped.end(), names, names + count);
  });
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // panels are where they are: no file in the user's folder
  scale_panels();
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL2_Init();
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  last_ = glfwGetTime();
}

void Window::scale_panels() {
  float content = 1;  // pixels of a dot of 1/96 inch
  glfwGetWindowContentScale(window_, &content, nullptr);
  int dots = 1;  // of the window, which Dear ImGui counts in; on some systems each has several pixels
  glfwGetWindowSize(window_, &dots, nullptr);
  const float scale = std::max(1.0f, content * float(dots) / float(std::max(width(), 1)));
  ImFontConfig font;
  font.SizePixels = std::round(13 * scale);
  ImGui::GetIO().Fonts->AddFontDefault(&font);
  ImGui::GetStyle().ScaleAllSizes(scale);
}

Window::~Window() {
  ImGui_ImplOpenGL2_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwTerminate();
}

void Window::show(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
  glfwShowWindow(window_);
}

int Window::width() const {
  int width = 0;
  glfwGetFramebufferSize(window_, &width, nullptr);
  return width;
}

int Window::height() const {
  int height = 0;
  glfwGetFramebufferSize(window_, nullptr, &height);
  return height;
}

Input Window::input(double seconds) const {
  const ImGuiIO& io = ImGui::GetIO();
  Input input;
  if (!io.WantCaptureMouse) {
    const vec2 moved(io.MouseDelta.x, io.MouseDelta.y);
    if (ImGui::IsMouseDragging(0)) input.turn = moved;  // not by the hand that clicks
    if (io.MouseDown[1] || io.MouseDown[2]) input.pan = moved;
    input.wheel = double(io.MouseWheel);
  }
  if (io.WantTextInput) return input;
  const auto way = [&](int more, int less) {
    return (glfwGetKey(window_, more) == GLFW_PRESS) - (glfwGetKey(window_, less) == GLFW_PRESS);
  };
  const double fast = io.KeyShift ? 4 : 1;
  input.move = fast * seconds *
               dvec3(way(GLFW_KEY_D, GLFW_KEY_A), way(GLFW_KEY_E, GLFW_KEY_Q), way(GLFW_KEY_W, GLFW_KEY_S));
  return input;
}

Events Window::begin_frame(bool busy) {
  if (busy || lively_frames_ > 0) {
    glfwPollEvents();
    --lively_frames_;
  } else {
    const double before = glfwGetTime();
    glfwWaitEventsTimeout(longest_wait);
    if (glfwGetTime() - before < longest_wait) lively_frames_ = frames_an_event;
  }
  ImGui_ImplOpenGL2_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();

  const double now = glfwGetTime();
  Events events = std::exchange(pending_, {});
  events.seconds = now - last_, last_ = now;
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) events.keys.clear(), events.escape = false;
  events.closes = glfwWindowShouldClose(window_);
  glfwSetWindowShouldClose(window_, GLFW_FALSE);
  // A key that was pressed while nothing was drawn is held since then at most.
  events.input = input(events.seconds < longest_wait ? events.seconds : 0);
  events.x = int(io.MousePos.x * io.DisplayFramebufferScale.x);
  events.y = int(io.MousePos.y * io.DisplayFramebufferScale.y);
  // A press, and a release without a way in between.
  if (ImGui::IsMouseClicked(0)) dragged_ = io.WantCaptureMouse;
  if (ImGui::IsMouseDragging(0)) dragged_ = true;
  events.clicked = ImGui::IsMouseReleased(0) && !dragged_;
  events.double_clicked = ImGui::IsMouseDoubleClicked(0) && !io.WantCaptureMouse;
  if (events.input.moves()) lively_frames_ = frames_an_event;
  ImGui::GetBackgroundDrawList()->AddImage(std::bit_cast<ImTextureID>(std::uintptr_t(texture_)), ImVec2(0, 0),
                                           io.DisplaySize);
  return events;
}

void Window::end_frame() {
  ImGui::Render();
  glViewport(0, 0, width(), height());
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL2_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window_);
}

void Window::set_picture(const Frame& picture) {
  to_rgb_bytes(picture, bytes_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, picture.width, picture.height, 0, GL_RGB, GL_UNSIGNED_BYTE,
               bytes_.data());
}

double window_time() { return glfwGetTime(); }

}  // namespace swiftgs::cli
