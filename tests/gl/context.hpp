// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// OpenGL without a window, and a box that it draws with depth.

#include <stdexcept>
#include <utility>
#include <vector>

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <glm/ext/matrix_transform.hpp>

#include "support/among_splats.hpp"

namespace swiftgs::test {

/// A current context of OpenGL 3.3: on the GPU that has number `cuda_device` in CUDA, or by default on any
/// device. `current` is false where there is none.
class Context {
 public:
  static constexpr int any = -1;

  explicit Context(int cuda_device = any) {
    const auto devices = function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto attribute = function<PFNEGLQUERYDEVICEATTRIBEXTPROC>("eglQueryDeviceAttribEXT");
    const auto display = function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    if (!devices || !attribute || !display) return;
    EGLDeviceEXT found[32];
    EGLint count = 0;
    devices(32, found, &count);
    for (EGLint i = 0; i < count && !current; ++i) {
      EGLAttrib number = any;
      if (cuda_device != any && (!attribute(found[i], EGL_CUDA_DEVICE_NV, &number) || number != cuda_device))
        continue;
      open(display(EGL_PLATFORM_DEVICE_EXT, found[i], nullptr));
    }
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  ~Context() {
    if (!current) return;
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglTerminate(display_);
  }

  bool current = false;

 private:
  template <class F>
  static F function(const char* name) {
    return reinterpret_cast<F>(eglGetProcAddress(name));
  }

  void open(EGLDisplay display) {
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, nullptr, nullptr)) return;
    eglBindAPI(EGL_OPENGL_API);
    const EGLint any_config[] = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                 EGL_NONE};
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint configs = 0;
    if (eglChooseConfig(display, any_config, &config, 1, &configs) && configs == 1) {
      display_ = display, context_ = eglCreateContext(display, config, EGL_NO_CONTEXT, version);
      current = context_ != EGL_NO_CONTEXT &&
                eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
    }
    if (!current) eglTerminate(display);
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

/// Draws the box, and images over it, into a framebuffer of its own. Of a current context.
class Canvas {
 public:
  Canvas() {
    const char* const cube = R"(#version 330 core
      uniform mat4 matrix;
      void main() {
        int axis = gl_VertexID / 12, corner = int[](0, 1, 2, 2, 1, 3)[gl_VertexID % 6];
        vec3 at = 2 * vec3(corner % 2, corner / 2, gl_VertexID / 6 % 2) - 1;
        gl_Position = matrix * vec4(axis == 0 ? at : axis == 1 ? at.yzx : at.zxy, 1);
      })";
    const char* const orange = R"(#version 330 core
      out vec4 pixel;
      void main() { pixel = vec4(0.9, 0.55, 0.15, 1); })";
    const char* const everywhere = R"(#version 330 core
      void main() { gl_Position = vec4(gl_VertexID % 2 * 4 - 1, gl_VertexID / 2 * 4 - 1, 0, 1); })";
    const char* const texels = R"(#version 330 core
      uniform sampler2D image;
      out vec4 pixel;
      void main() { pixel = texelFetch(image, ivec2(gl_FragCoord.xy), 0); })";
    box_ = link(cube, orange), image_ = link(everywhere, texels);
    GLuint vertex_array = 0, framebuffer = 0, attachments[2] = {};
    glGenVertexArrays(1, &vertex_array), glBindVertexArray(vertex_array);
    glGenFramebuffers(1, &framebuffer), glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glGenRenderbuffers(2, attachments);
    attach(attachments[0], GL_RGBA8, GL_COLOR_ATTACHMENT0);
    attach(attachments[1], GL_DEPTH_COMPONENT32F, GL_DEPTH_ATTACHMENT);
    glViewport(0, 0, width, height);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      throw std::runtime_error("the framebuffer is not complete");
  }

  /// Gives a renderbuffer storage.
  static void attach(GLuint renderbuffer, GLenum format, GLenum attachment) {
    glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, renderbuffer);
  }

  void draw_box(const glm::mat4& matrix) const {
    glEnable(GL_DEPTH_TEST), glDisable(GL_BLEND);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glUseProgram(box_);
    const glm::mat4 box =
        glm::scale(glm::translate(matrix, glm::vec3(0.02, -1.16, 0.02)), glm::vec3(0.55, 0.2, 0.2));
    glUniformMatrix4fv(glGetUniformLocation(box_, "matrix"), 1, GL_FALSE, &box[0][0]);
    glDrawArrays(GL_TRIANGLES, 0, 36);
  }
  /// Draws a texture with premultiplied colours over what is there.
  void draw_over(GLuint texture) const {
    glDisable(GL_DEPTH_TEST), glEnable(GL_BLEND), glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glUseProgram(image_);
    glBindTexture(GL_TEXTURE_2D, texture);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  }

  static Bytes colours() {
    Bytes out(4 * pixels);
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, out.data());
    return out;
  }
  static std::vector<float> depths() {
    std::vector<float> out(pixels);
    glReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, out.data());
    return out;
  }

 private:
  static GLuint link(const char* vertices, const char* colours) {
    const GLuint program = glCreateProgram();
    for (const auto& [kind, source] :
         {std::pair{GL_VERTEX_SHADER, vertices}, std::pair{GL_FRAGMENT_SHADER, colours}}) {
      const GLuint shader = glCreateShader(GLenum(kind));
      glShaderSource(shader, 1, &source, nullptr);
      glCompileShader(shader), glAttachShader(program, shader);
    }
    glLinkProgram(program);
    GLint linked = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) throw std::runtime_error("the shaders do not link");
    return program;
  }

  GLuint box_ = 0, image_ = 0;
};

}  // namespace swiftgs::test
