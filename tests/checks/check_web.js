// What check_web.py asks a browser for: jobs.json lists what is to be drawn, and the bytes go back by POST.
import * as THREE from "three";
import { loadAtlas } from "./atlas.js";

const post = (path, body) => fetch(path, { method: "POST", body });

function check(error, what) {
  if (error) throw new Error(what);
}

// The example itself, as a frame of this page: its canvas, RGBA, from the top.
async function drawSphere({ atlas }) {
  const frame = document.createElement("iframe");
  frame.src = `index.html?atlas=${atlas}`;
  frame.width = frame.height = 600;
  const loaded = new Promise((resolve) => frame.addEventListener("load", resolve));
  document.body.append(frame);
  await loaded;
  const { drawn } = await frame.contentWindow.eval('import("./main.js")');
  const { renderer, scene, camera } = await drawn;
  renderer.render(scene, camera);  // what is drawn can be read until the browser shows it
  const { width, height } = renderer.domElement;
  const pixels = new Uint8Array(4 * width * height);
  const gl = renderer.getContext();
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  check(gl.getError(), "WebGL reports an error");
  frame.remove();
  return pixels;
}

function pointTexture(points, width) {
  const height = points.length / 4 / width;
  const texture = new THREE.DataTexture(points, width, height, THREE.RGBAFormat, THREE.FloatType);
  texture.needsUpdate = true;
  return texture;
}

// f_r of pairs of unit vectors, RGBA32F each, one fragment for each pair.
async function evaluate({ atlas, pairs, width, height }) {
  const points = new Float32Array(await (await fetch(pairs)).arrayBuffer());
  const renderer = new THREE.WebGLRenderer();
  const { texture, shader } = await loadAtlas(atlas, renderer);
  const gl = renderer.getContext();
  for (const name of ["EXT_color_buffer_float", "OES_texture_float_linear"]) {
    check(!gl.getExtension(name), `there is no ${name}`);
  }
  const material = new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: {
      sbrdf_atlas: { value: texture },
      all_i: { value: pointTexture(points.subarray(0, points.length / 2), width) },
      all_v: { value: pointTexture(points.subarray(points.length / 2), width) },
    },
    vertexShader: "in vec3 position;\nvoid main() { gl_Position = vec4(position, 1.0); }",
    fragmentShader: `precision highp float;
      precision highp int;
      ${shader}
      uniform highp sampler2D all_i;
      uniform highp sampler2D all_v;
      out vec4 value;
      void main() {
        ivec2 at = ivec2(gl_FragCoord.xy);
        value = vec4(sbrdf_eval(texelFetch(all_i, at, 0).xyz, texelFetch(all_v, at, 0).xyz), 1.0);
      }`,
  });
  const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, depthBuffer: false });
  renderer.setRenderTarget(target);
  const plane = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
  plane.frustumCulled = false;
  renderer.render(plane, new THREE.Camera());
  const values = new Float32Array(4 * width * height);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, values);
  check(gl.getError(), "WebGL reports an error");
  renderer.dispose();
  return values;
}

function rendererName() {
  const gl = document.createElement("canvas").getContext("webgl2");
  check(!gl, "there is no WebGL 2");
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  return gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
}

try {
  await post("renderer", rendererName());
  for (const job of await (await fetch("jobs.json")).json()) {
    await post(`result/${job.name}`, await (job.pairs ? evaluate(job) : drawSphere(job)));
  }
  await post("end", "");
} catch (error) {
  await post("error", `${error.stack ?? error}`);
}
