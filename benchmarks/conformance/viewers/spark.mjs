// SPDX-License-Identifier: Apache-2.0
import { SparkRenderer, SplatMesh } from '@sparkjsdev/spark';
import * as THREE from 'three';
import { cameraOf, rendererOf } from '../three.mjs';

export async function open(canvas, view) {
  if (view.isGltf) throw Error('it reads no glTF');
  const renderer = rendererOf(canvas, view), camera = cameraOf(view), scene = new THREE.Scene();
  // The blur that scenes are trained with, no splat left out, and none rounded more than it must be.
  const best = { preBlurAmount: 0.3, blurAmount: 0, maxStdDev: Math.sqrt(2 * Math.log(255)), minAlpha: 1 / 255,
    minPixelRadius: 0, sortRadial: false, clipXY: 10, accumExtSplats: true };
  scene.add(new SparkRenderer({ renderer, ...(view.best ? best : {}) }));
  const splats = new SplatMesh({ url: view.url, ...(view.best ? { extSplats: true } : {}) });
  await splats.initialized;
  scene.add(splats);
  return () => renderer.render(scene, camera);
}
