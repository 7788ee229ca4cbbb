import * as THREE from "three";
import { loadAtlas } from "./atlas.js";

const vertexShader = `
attribute vec4 tangent;
varying vec3 position_world;
varying vec3 normal_world;
varying vec4 tangent_world;

void main() {
  vec4 place = modelMatrix * vec4(position, 1.0);
  position_world = place.xyz;
  normal_world = mat3(modelMatrix) * normal;  // where the mesh is turned and moved, not stretched
  tangent_world = vec4(mat3(modelMatrix) * tangent.xyz, tangent.w);
  gl_Position = projectionMatrix * viewMatrix * place;
}`;

// sbrdf_eval wants directions in the frame of the surface: x the tangent, z the normal. A vector before the matrix is
// turned into that frame, as the columns are its axes.
const fragmentShader = (sbrdf_eval) => `
${sbrdf_eval}
uniform vec3 to_light;
uniform vec3 light_colour;
varying vec3 position_world;
varying vec3 normal_world;
varying vec4 tangent_world;

void main() {
  vec3 z = normalize(normal_world);
  vec3 x = normalize(tangent_world.xyz - z * dot(z, tangent_world.xyz));
  mat3 frame = mat3(x, cross(z, x) * tangent_world.w, z);
  vec3 w_i = to_light * frame;
  vec3 w_v = normalize(cameraPosition - position_world) * frame;
  gl_FragColor = vec4(sbrdf_eval(w_i, w_v) * max(w_i.z, 0.0) * light_colour, 1.0);
  #include <colorspace_fragment>
}`;

function sphere(material) {
  const geometry = new THREE.SphereGeometry(1, 512, 256);
  geometry.computeTangents();
  return new THREE.Mesh(geometry, material);
}

async function main() {
  const url = new URLSearchParams(location.search).get("atlas") ?? "material.ktx2";
  const renderer = new THREE.WebGLRenderer();
  renderer.setSize(512, 512);
  document.body.append(renderer.domElement);

  const light = new THREE.DirectionalLight("white", Math.PI);  // a white surface is white, as with Lambert's material
  light.position.set(-2, 3, 4);
  const { texture, shader } = await loadAtlas(url, renderer);
  const material = new THREE.ShaderMaterial({
    uniforms: {
      sbrdf_atlas: { value: texture },
      to_light: { value: light.position.clone().normalize() },
      light_colour: { value: light.color.clone().multiplyScalar(light.intensity) },
    },
    vertexShader,
    fragmentShader: fragmentShader(shader),
  });

  const scene = new THREE.Scene();
  scene.add(light, sphere(material));
  const camera = new THREE.PerspectiveCamera(32, 1, 0.1, 10);
  camera.position.z = 4;
  renderer.render(scene, camera);
  return { renderer, scene, camera };
}

export const drawn = main();
