// SPDX-License-Identifier: Apache-2.0
import * as SPLAT from 'gsplat';

export async function open(canvas, view) {
  if (view.isGltf) throw Error('it reads no glTF');
  if (2 * view.cx !== view.width || 2 * view.cy !== view.height) throw Error('it has no principal point');
  if (view.isMirrored) throw Error('it has no mirrored cameras');
  if (view.background) throw Error('its background is the style of the canvas');
  const scene = new SPLAT.Scene(), data = new SPLAT.CameraData(), camera = new SPLAT.Camera(data);
  const renderer = new SPLAT.WebGLRenderer(canvas, []);
  renderer.setSize(view.width, view.height);
  await SPLAT.PLYLoader.LoadAsync(view.url, scene, () => {});
  Object.assign(data, { fx: view.fx, fy: view.fy, near: view.near, far: view.far });
  data.setSize(view.width, view.height);
  camera.position = new SPLAT.Vector3(...view.position);
  camera.rotation = SPLAT.Quaternion.FromMatrix3(new SPLAT.Matrix3(...view.rotation.flat()));
  return () => renderer.render(scene, camera);
}
