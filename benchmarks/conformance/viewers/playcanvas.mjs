// SPDX-License-Identifier: Apache-2.0
import * as pc from 'playcanvas';

export async function open(canvas, view) {
  const device = await pc.createGraphicsDevice(canvas, { deviceTypes: ['webgl2'], antialias: false });
  device.maxPixelRatio = 1;
  const options = new pc.AppOptions();
  options.graphicsDevice = device;
  options.componentSystems = [pc.RenderComponentSystem, pc.CameraComponentSystem, pc.GSplatComponentSystem];
  options.resourceHandlers = [pc.TextureHandler, pc.ContainerHandler, pc.GSplatHandler];
  const app = new pc.AppBase(canvas);
  app.init(options);
  app.setCanvasResolution(pc.RESOLUTION_FIXED, view.width, view.height);
  app.start();

  const asset = new pc.Asset('scene', view.isGltf ? 'container' : 'gsplat', { url: view.url });
  app.assets.add(asset);
  await new Promise((loaded, failed) => {
    asset.once('load', loaded);
    asset.once('error', error => failed(new Error(error)));
    app.assets.load(asset);
  });
  const splats = view.isGltf ? asset.resource.instantiateRenderEntity() : new pc.Entity();
  if (!view.isGltf) splats.addComponent('gsplat', { asset });
  app.root.addChild(splats);

  const camera = new pc.Entity();
  camera.addComponent('camera', {
    clearColor: view.background ? new pc.Color(...view.background, 1) : new pc.Color(0, 0, 0, 0),
    nearClip: view.near, farClip: view.far, fov: view.verticalFov, toneMapping: pc.TONEMAP_NONE,
    gammaCorrection: pc.GAMMA_SRGB,
  });
  const world = new pc.Mat4();
  world.data.set(view.world);
  camera.setLocalPosition(world.getTranslation());
  camera.setLocalRotation(new pc.Quat().setFromMat4(world));
  camera.camera.calculateProjection = matrix => matrix.data.set(view.projection);
  camera.camera.calculateTransform = matrix => matrix.copy(world);
  app.root.addChild(camera);
  const best = { minPixelSize: 0, minContribution: 0, alphaClipForward: 1 / 255, dataFormat: pc.GSPLATDATA_LARGE };
  if (view.best) Object.assign(app.scene.gsplat, best);
  return () => new Promise(drawn => app.once('frameend', drawn));
}
