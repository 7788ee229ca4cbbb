import { LinearFilter, NoColorSpace } from "three";
import { DDSLoader } from "three/addons/loaders/DDSLoader.js";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { KTX2Loader } from "three/addons/loaders/KTX2Loader.js";

const loaders = {
  dds: () => new DDSLoader(),
  exr: () => new EXRLoader(),
  ktx2: (renderer) => new KTX2Loader().detectSupport(renderer),
};

// The texture of an atlas as its shader wants it: filtered, clamped to its edges (three.js does it anyway), without
// mip levels or a colour space, its first row at v = 0. And the text of the shader, the .glsl file beside it.
export async function loadAtlas(url, renderer) {
  const extension = url.split(".").pop();
  const texture = await loaders[extension](renderer).loadAsync(url);
  texture.colorSpace = NoColorSpace;
  texture.minFilter = LinearFilter;
  texture.magFilter = LinearFilter;
  texture.generateMipmaps = false;
  texture.flipY = extension === "exr";  // EXRLoader puts the last row first
  const response = await fetch(`${url.slice(0, -extension.length)}glsl`);
  if (!response.ok) throw new Error(`${response.url}: ${response.statusText}`);
  return { texture, shader: await response.text() };
}
