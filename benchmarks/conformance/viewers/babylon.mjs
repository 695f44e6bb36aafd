// SPDX-License-Identifier: Apache-2.0
import { Camera } from '@babylonjs/core/Cameras/camera';
import { FreeCamera } from '@babylonjs/core/Cameras/freeCamera';
import { Engine } from '@babylonjs/core/Engines/engine';
import { ImportMeshAsync } from '@babylonjs/core/Loading/sceneLoader';
import { Color4 } from '@babylonjs/core/Maths/math.color';
import { Matrix, Vector3 } from '@babylonjs/core/Maths/math.vector';
import { Scene } from '@babylonjs/core/scene';
import '@babylonjs/loaders/SPLAT/splatFileLoader';
import '@babylonjs/loaders/glTF/2.0';

export async function open(canvas, view) {
  const engine = new Engine(canvas, false, { alpha: true, premultipliedAlpha: true });
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  scene.clearColor = view.background ? new Color4(...view.background, 1) : new Color4(0, 0, 0, 0);
  const camera = new FreeCamera('camera', new Vector3(...view.position), scene);
  Object.assign(camera, { minZ: view.near, maxZ: view.far });
  const toCamera = Matrix.FromArray(view.world).invert();
  camera.freezeProjectionMatrix(Matrix.FromArray(view.projection));
  camera.getViewMatrix = () => {
    camera._computedViewMatrix = toCamera;
    camera._globalPosition.copyFromFloats(...view.position);
    return toCamera;
  };
  const { meshes } = await ImportMeshAsync(view.url, scene);
  if (!view.isGltf) for (const mesh of meshes) {  // undo the turn that its loader of PLY files makes
    mesh.scaling.set(1, 1, 1);
    mesh.rotationQuaternion = null;
    mesh.rotation.setAll(0);
  }
  return () => scene.render();
}
