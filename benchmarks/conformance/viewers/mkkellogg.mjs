// SPDX-License-Identifier: Apache-2.0
import * as Splats from '@mkkellogg/gaussian-splats-3d';
import { cameraOf, rendererOf } from '../three.mjs';

export async function open(canvas, view) {
  if (view.isGltf) throw Error('it reads no glTF');
  const renderer = rendererOf(canvas, view), camera = cameraOf(view);
  const viewer = new Splats.Viewer({
    renderer, camera, selfDrivenMode: false, useBuiltInControls: false, rootElement: document.body,
    sharedMemoryForWorkers: false, ignoreDevicePixelRatio: true, sceneRevealMode: Splats.SceneRevealMode.Instant,
    sphericalHarmonicsDegree: 2,
    ...(view.best ? { integerBasedSort: false, splatSortDistanceMapPrecision: 20 } : {}),
  });
  await viewer.addSplatScene(view.url, { showLoadingUI: false, progressiveLoad: false,
    ...(view.best ? { splatAlphaRemovalThreshold: 0 } : {}) });
  return () => {
    camera.projectionMatrix.fromArray(view.projection);
    camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
    viewer.update();
    viewer.render();
  };
}
