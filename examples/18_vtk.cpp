// SPDX-License-Identifier: Apache-2.0

// Splats in a window of VTK 9, as a prop among others: in the knot of the built-in scene is a box
// that VTK draws. The trackball turns both.
//
//     18_vtk
//     18_vtk --screenshot OUT.png  writes the first frame and ends
#include <cmath>
#include <exception>
#include <iostream>
#include <stdexcept>
#include <string_view>

#include <X11/Xlib.h>
#include <vtkActor.h>
#include <vtkBoundingBox.h>
#include <vtkCamera.h>
#include <vtkCellData.h>
#include <vtkCubeSource.h>
#include <vtkFloatArray.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkMath.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLCamera.h>
#include <vtkPNGWriter.h>
#include <vtkPolyDataMapper.h>
#include <vtkProp.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include <swiftgs/builtin_scene.hpp>
#include <swiftgs/camera_matrices.hpp>
#include <swiftgs/cpu.hpp>
#include <swiftgs/swiftgs.hpp>

using namespace swiftgs;

namespace {

/// Splats as a prop. VTK draws it after those of opaque and translucent surfaces.
class Splats : public vtkProp {
 public:
  static Splats* New();
  vtkTypeMacro(Splats, vtkProp)

      double* GetBounds() override {
    return bounds_;
  }

  int RenderVolumetricGeometry(vtkViewport* viewport) override {
    auto* const renderer = static_cast<vtkRenderer*>(viewport);
    vtkRenderWindow* const window = renderer->GetRenderWindow();
    int width = 0, height = 0, x = 0, y = 0;
    renderer->GetTiledSizeAndOrigin(&width, &height, &x, &y);
    const int right = x + width - 1, top = y + height - 1;
    window->GetRGBACharPixelData(x, y, right, top, 0, image_);
    window->GetZbufferData(x, y, right, top, depth_);
    vtkMatrix4x4 *view = nullptr, *projection = nullptr, *both = nullptr;  // column by column
    vtkMatrix3x3* normals = nullptr;
    auto* const camera = static_cast<vtkOpenGLCamera*>(renderer->GetActiveCamera());
    camera->GetKeyMatrices(renderer, view, normals, projection, both);

    const HostCamera host =
        camera_from(view->GetData(), projection->GetData(), width, height, ClipSpace::opengl);
    FrameView frame = host.frame(image_->GetPointer(0), depth_->GetPointer(0));
    frame.over = true;
    splats_.render_into(scene_.view(), host.camera, {}, frame);

    window->SetRGBACharPixelData(x, y, right, top, image_, 0);
    return 1;
  }

 protected:
  Splats() {
    const SceneView scene = scene_.view();
    vtkBoundingBox box;
    for (std::size_t i = 0; i < scene.size(); ++i)
      box.AddPoint(scene.means[i].x, scene.means[i].y, scene.means[i].z);
    box.GetBounds(bounds_);  // VTK puts the far plane behind them
  }

 private:
  vtkNew<vtkUnsignedCharArray> image_;
  vtkNew<vtkFloatArray> depth_;
  Renderer<Cpu> splats_;
  Cpu::SceneOn scene_ = splats_.backend().upload(make_builtin_scene());
  double bounds_[6] = {};
};
vtkStandardNewMacro(Splats)

    void run(const char* screenshot) {
  Display* const display = XOpenDisplay(nullptr);
  int code = 0, event = 0, error = 0;
  if (!display || !XQueryExtension(display, "GLX", &code, &event, &error))  // where VTK would abort
    throw std::runtime_error("found no OpenGL on DISPLAY, expected a display with OpenGL 3.2");
  XCloseDisplay(display);

  vtkNew<vtkCubeSource> cube;
  cube->SetBounds(0.02 - 0.55, 0.02 + 0.55, -1.16 - 0.2, -1.16 + 0.2, 0.02 - 0.2, 0.02 + 0.2);
  cube->Update();
  vtkNew<vtkUnsignedCharArray> colours;
  colours->SetNumberOfComponents(3);
  for (int face = 0; face < 6; ++face) {
    const double light = 255 * (0.4 + 0.1 * face);
    colours->InsertNextTuple3(0.9 * light, 0.55 * light, 0.15 * light);
  }
  cube->GetOutput()->GetCellData()->SetScalars(colours);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(cube->GetOutput());
  vtkNew<vtkActor> box;
  box->SetMapper(mapper);
  box->GetProperty()->LightingOff();

  vtkNew<Splats> splats;
  vtkNew<vtkRenderer> renderer;
  renderer->AddActor(box);
  renderer->AddViewProp(splats);
  vtkCamera* const camera = renderer->GetActiveCamera();
  const double turn = -0.26, rise = 0.2, level = 3 * std::cos(rise);  // y points down
  camera->SetFocalPoint(0.02, -1.16, 0.02);
  camera->SetPosition(0.02 + level * std::sin(turn), -1.16 - 3 * std::sin(rise),
                      0.02 - level * std::cos(turn));
  camera->SetViewUp(0, -1, 0);
  camera->SetViewAngle(vtkMath::DegreesFromRadians(0.76));
  renderer->SetNearClippingPlaneTolerance(0.0002);  // of the far plane, behind the sky
  renderer->ResetCameraClippingRange();
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);  // of several samples there is no single depth
  window->SetSize(960, 540);
  window->SetWindowName("Splats in VTK");
  window->AddRenderer(renderer);
  vtkNew<vtkRenderWindowInteractor> interactor;
  interactor->SetRenderWindow(window);
  vtkNew<vtkInteractorStyleTrackballCamera> trackball;
  interactor->SetInteractorStyle(trackball);
  window->Render();
  if (!screenshot) return interactor->Start();
  vtkNew<vtkWindowToImageFilter> image;
  image->SetInput(window);
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(image->GetOutputPort());
  writer->SetFileName(screenshot);
  writer->Write();
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc == 3 && std::string_view(argv[1]) == "--screenshot" ? argv[2] : nullptr);
  } catch (const std::exception& error) {
    std::cerr << "18_vtk: " << error.what() << '\n';
    return 1;
  }
}
