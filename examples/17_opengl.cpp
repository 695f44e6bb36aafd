// SPDX-License-Identifier: Apache-2.0

// Splats in a window of OpenGL. The program draws a box with its own matrices and depth buffer; the
// knot of the built-in scene winds around and through it. Drag to turn.
//
//     17_opengl
//     17_opengl --screenshot OUT.png  writes the first frame and ends
#include <cmath>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#define GL_GLEXT_PROTOTYPES
#define GLFW_INCLUDE_GLCOREARB
#include <GLFW/glfw3.h>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera_matrices.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/io/image.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

namespace {

const char* const box_vertices = R"(#version 330 core
uniform mat4 matrix;
flat out vec3 colour;
void main() {
  const int corners[6] = int[](0, 1, 2, 2, 1, 3);
  int face = gl_VertexID / 6, axis = face / 2, corner = corners[gl_VertexID % 6];
  vec3 at;
  at[axis] = face % 2 * 2 - 1;
  at[(axis + 1) % 3] = corner % 2 * 2 - 1;
  at[(axis + 2) % 3] = corner / 2 * 2 - 1;
  colour = vec3(0.9, 0.55, 0.15) * (0.4 + 0.1 * face);
  gl_Position = matrix * vec4(vec3(0.02, -1.16, 0.02) + vec3(0.55, 0.2, 0.2) * at, 1);
})";
const char* const box_colours = R"(#version 330 core
flat in vec3 colour;
out vec4 pixel;
void main() { pixel = vec4(colour, 1); })";

const char* const whole_window = R"(#version 330 core
void main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); })";
const char* const splat_colours = R"(#version 330 core
uniform sampler2D splats;
out vec4 pixel;
void main() { pixel = texelFetch(splats, ivec2(gl_FragCoord.xy), 0); })";

GLuint link(const char* vertices, const char* colours) {
  const GLuint program = glCreateProgram();
  const auto add = [&](GLenum kind, const char* source) {
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &source, nullptr);
    glCompileShader(shader);
    glAttachShader(program, shader);
  };
  add(GL_VERTEX_SHADER, vertices), add(GL_FRAGMENT_SHADER, colours);
  glLinkProgram(program);
  GLint linked = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (!linked) throw std::runtime_error("the shaders do not link");
  return program;
}

GLFWwindow* open_window() {
  GLFWwindow* window = nullptr;
  if (glfwInit()) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3), glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    window = glfwCreateWindow(960, 540, "Splats in OpenGL", nullptr, nullptr);
  }
  if (window) return window;
  const char* reason = "";
  glfwGetError(&reason);
  throw std::runtime_error(std::string(reason) + "; expected a display with OpenGL 3.3");
}

void write_window(const char* path, int width, int height) {
  Frame frame;
  frame.width = width, frame.height = height, frame.colour.resize(3 * frame.pixels());
  for (int y = 0; y < height; ++y)
    glReadPixels(0, height - 1 - y, width, 1, GL_RGB, GL_FLOAT, &frame.colour[3 * width * y]);
  write_png(path, frame);
}

void run(const char* screenshot) {
  GLFWwindow* const window = open_window();
  glfwMakeContextCurrent(window);
  const GLuint box = link(box_vertices, box_colours), splats = link(whole_window, splat_colours);
  GLuint no_vertices = 0, texture = 0;
  glGenVertexArrays(1, &no_vertices), glBindVertexArray(no_vertices);
  glGenTextures(1, &texture), glBindTexture(GL_TEXTURE_2D, texture);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);

  Renderer<Cpu> renderer;
  const Cpu::SceneOn scene = renderer.backend().upload(make_builtin_scene());
  const glm::vec3 target(0.02f, -1.16f, 0.02f), up(0, -1, 0);
  float turn = -0.26f, rise = 0.2f;
  for (double last_x = 0, last_y = 0; !glfwWindowShouldClose(window); glfwWaitEvents()) {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window, &width, &height);
    if (width == 0 || height == 0) continue;  // minimised
    double x = 0, y = 0;
    glfwGetCursorPos(window, &x, &y);
    if (glfwGetMouseButton(window, GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS)
      turn -= float(x - last_x) / 200, rise += float(y - last_y) / 200;
    last_x = x, last_y = y, rise = glm::clamp(rise, -1.5f, 1.5f);

    const float level = 3 * std::cos(rise);  // y points down
    const glm::vec3 away(level * std::sin(turn), -3 * std::sin(rise), -level * std::cos(turn));
    const glm::mat4 view = glm::lookAt(target + away, target, up);
    const float aspect = float(width) / float(height);
    const glm::mat4 projection = glm::perspective(0.76f, aspect, 0.1f, 500.0f);
    const glm::mat4 matrix = projection * view;
    glViewport(0, 0, width, height);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST), glDisable(GL_BLEND);
    glUseProgram(box);
    glUniformMatrix4fv(glGetUniformLocation(box, "matrix"), 1, GL_FALSE, &matrix[0][0]);
    glDrawArrays(GL_TRIANGLES, 0, 36);
    std::vector<float> depth(std::size_t(width) * height);
    glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());

    std::vector<unsigned char> image(4 * depth.size());
    const HostCamera host = camera_from(view, projection, width, height, ClipSpace::opengl);
    renderer.render_into(scene.view(), host.camera, {}, host.frame(image.data(), depth.data()));

    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, &image[0]);
    glDisable(GL_DEPTH_TEST), glEnable(GL_BLEND);
    glUseProgram(splats);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    if (screenshot) return write_window(screenshot, width, height);
    glfwSwapBuffers(window);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc == 3 && std::string_view(argv[1]) == "--screenshot" ? argv[2] : nullptr);
  } catch (const std::exception& error) {
    std::cerr << "17_opengl: " << error.what() << '\n';
    return 1;
  }
}
