// SPDX-License-Identifier: Apache-2.0

// Splats in OpenSceneGraph, as a drawable among others: in the knot of the built-in scene is a box
// of the scene graph. The trackball turns both.
//
//     20_openscenegraph
//     20_openscenegraph --screenshot OUT.png  writes the first frame and ends
#include <algorithm>
#include <cmath>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string_view>
#include <vector>

#define GL_GLEXT_PROTOTYPES
#include <osg/BlendFunc>
#include <osg/Drawable>
#include <osg/Geometry>
#include <osg/Group>
#include <osg/Math>
#include <osg/Notify>
#include <osgDB/WriteFile>
#include <osgGA/TrackballManipulator>
#include <osgViewer/Viewer>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera_matrices.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

namespace {

constexpr int width = 960, height = 540;

/// Draws splats over the picture so far.
class Splats : public osg::Drawable {
 public:
  Splats() {
    setUseDisplayList(false);
    setCullingActive(false);
    osg::StateSet* const state = getOrCreateStateSet();
    state->setRenderBinDetails(100, "RenderBin");  // after all others
    state->setMode(GL_DEPTH_TEST, osg::StateAttribute::OFF);
    state->setAttributeAndModes(new osg::BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA));
  }

  void drawImplementation(osg::RenderInfo& info) const override {
    const osg::State& state = *info.getState();
    const osg::Viewport& window = *state.getCurrentViewport();
    const int x = int(window.x()), y = int(window.y());
    const int columns = int(window.width()), rows = int(window.height());
    std::vector<float> depth(std::size_t(columns) * rows);
    glReadPixels(x, y, columns, rows, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());

    std::vector<unsigned char> image(4 * depth.size());
    const double* const view = state.getModelViewMatrix().ptr();  // for row vectors, row by row
    const double* const projection = state.getProjectionMatrix().ptr();
    const HostCamera host = camera_from(view, projection, columns, rows, ClipSpace::opengl);
    renderer_.render_into(scene_.view(), host.camera, {}, host.frame(image.data(), depth.data()));

    glWindowPos2i(x, y);
    glDrawPixels(columns, rows, GL_RGBA, GL_UNSIGNED_BYTE, image.data());
  }

 private:
  mutable Renderer<Cpu, EarlySort, AxisSharedThreshold<FloatCholesky>, Ellipse> renderer_;
  Cpu::SceneOn scene_ = renderer_.backend().upload(make_builtin_scene());
};

osg::ref_ptr<osg::Geometry> make_box() {
  const osg::ref_ptr<osg::Vec3Array> corners = new osg::Vec3Array;
  const osg::ref_ptr<osg::Vec4Array> colours = new osg::Vec4Array;
  for (int face = 0; face < 6; ++face)
    for (const int corner : {0, 1, 3, 2}) {
      const int axis = face / 2;
      osg::Vec3f at;
      at[axis] = face % 2 ? 1 : -1;
      at[(axis + 1) % 3] = corner % 2 ? 1 : -1;
      at[(axis + 2) % 3] = corner / 2 ? 1 : -1;
      const float light = 0.4f + 0.1f * float(face);
      corners->push_back(osg::Vec3f(0.02f, -1.16f, 0.02f) +
                         osg::componentMultiply(osg::Vec3f(0.55f, 0.2f, 0.2f), at));
      colours->push_back({0.9f * light, 0.55f * light, 0.15f * light, 1});
    }
  const osg::ref_ptr<osg::Geometry> box = new osg::Geometry;
  box->setVertexArray(corners);
  box->setColorArray(colours, osg::Array::BIND_PER_VERTEX);
  box->addPrimitiveSet(new osg::DrawArrays(GL_QUADS, 0, 24));
  return box;
}

struct Screenshot : osg::Camera::DrawCallback {
  const char* path;
  explicit Screenshot(const char* to) : path(to) {}
  void operator()(osg::RenderInfo&) const override {
    const osg::ref_ptr<osg::Image> image = new osg::Image;
    image->readPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE);
    osgDB::writeImageFile(*image, path);
  }
};

void run(const char* screenshot) {
  osg::setNotifyLevel(osg::ALWAYS);  // errors are told below
  const osg::ref_ptr<osg::Group> root = new osg::Group;
  root->getOrCreateStateSet()->setMode(GL_LIGHTING, osg::StateAttribute::OFF);
  root->addChild(make_box());
  root->addChild(new Splats);

  osgViewer::Viewer viewer;
  viewer.setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
  viewer.setUpViewInWindow(0, 0, width, height);
  viewer.setSceneData(root);
  osg::Camera* const camera = viewer.getCamera();
  camera->setComputeNearFarMode(osg::CullSettings::DO_NOT_COMPUTE_NEAR_FAR);
  const double aspect = double(width) / height;
  camera->setProjectionMatrixAsPerspective(osg::RadiansToDegrees(0.76), aspect, 0.1, 500);
  camera->setClearColor(osg::Vec4(0, 0, 0, 1));
  const double turn = -0.26, rise = 0.2, level = 3 * std::cos(rise);  // y points down
  const osg::Vec3d target(0.02, -1.16, 0.02);
  const osg::Vec3d away(level * std::sin(turn), -3 * std::sin(rise), -level * std::cos(turn));
  const osg::ref_ptr<osgGA::TrackballManipulator> trackball = new osgGA::TrackballManipulator;
  trackball->setHomePosition(target + away, target, osg::Vec3d(0, -1, 0));
  viewer.setCameraManipulator(trackball);
  viewer.realize();
  if (!viewer.isRealized()) throw std::runtime_error("no window, expected a display with OpenGL");
  if (!screenshot) {
    viewer.run();
    return;
  }
  camera->setFinalDrawCallback(new Screenshot(screenshot));
  viewer.frame();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc == 3 && std::string_view(argv[1]) == "--screenshot" ? argv[2] : nullptr);
  } catch (const std::exception& error) {
    std::cerr << "20_openscenegraph: " << error.what() << '\n';
    return 1;
  }
}
