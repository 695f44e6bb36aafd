// SPDX-License-Identifier: Apache-2.0
// The renderer and the camera of viewers that draw by three.js.
import * as THREE from 'three';

export function rendererOf(canvas, view) {
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: false, alpha: true });
  renderer.setPixelRatio(1);
  renderer.setSize(view.width, view.height, false);
  renderer.toneMapping = THREE.NoToneMapping;
  const [r, g, b] = view.background ?? [0, 0, 0];
  renderer.setClearColor(new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace), view.background ? 1 : 0);
  return renderer;
}

export function cameraOf(view) {
  const camera = new THREE.PerspectiveCamera(view.verticalFov, view.width / view.height, view.near, view.far);
  camera.matrixAutoUpdate = false;
  camera.matrix.fromArray(view.world);
  camera.matrix.decompose(camera.position, camera.quaternion, camera.scale);
  camera.updateMatrixWorld(true);
  camera.projectionMatrix.fromArray(view.projection);
  camera.projectionMatrixInverse.copy(camera.projectionMatrix).invert();
  return camera;
}
