// Reads textures with ktx-parse and with three.js, for check_textures.py.
//
// usage: node read_textures.mjs MODULES FILE ...    MODULES: the node_modules folder that holds ktx-parse and three
// One line of JSON for each file: what the reader takes it for, and its texels as Base64.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [modules, ...files] = process.argv.slice(2);
const load = (path) => import(pathToFileURL(join(modules, path)).href);
const base64 = (array) => Buffer.from(array.buffer, array.byteOffset, array.byteLength).toString("base64");

const ktx = await load("ktx-parse/dist/index.mjs");
const three = await load("three/build/three.module.js");
const loaders = "three/examples/jsm/loaders/";
const { DDSLoader } = await load(loaders + "DDSLoader.js");
const { EXRLoader } = await load(loaders + "EXRLoader.js");
const { KTX2Loader } = await load(loaders + "KTX2Loader.js");

function parsed(bytes) {
  const file = ktx.read(bytes);
  const keys = Object.entries(file.keyValue).map(([key, value]) => [
    key, typeof value === "string" ? value : Buffer.from(value).toString("latin1")]);
  return { ...file, keyValue: keys, levels: file.levels.map((level) => ({ ...level, levelData: base64(level.levelData) })) };
}

const buffer = (bytes) => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);

async function loaded(file, bytes) {
  if (file.endsWith(".dds")) {
    const texture = new DDSLoader().parse(buffer(bytes), false);
    const [{ data, width, height }] = texture.mipmaps;
    const name = { [three.RGB_BPTC_UNSIGNED_Format]: "bc6h", [three.RGB_BPTC_SIGNED_Format]: "bc6h-signed" };
    return { format: name[texture.format], width, height, texels: base64(data) };
  }
  if (file.endsWith(".exr")) {
    const loader = new EXRLoader();
    loader.setDataType(file.includes("half") ? three.HalfFloatType : three.FloatType);
    const { data, width, height } = loader.parse(buffer(bytes));
    return { format: "exr", width, height, texels: base64(data) };
  }
  const loader = new KTX2Loader();
  loader.workerConfig = {};  // what a graphics card would have said
  const texture = await new Promise((resolve, reject) => loader.parse(buffer(bytes), resolve, reject));
  const name = { [three.HalfFloatType]: "rgba16f", [three.FloatType]: "rgba32f", [three.UnsignedInt5999Type]: "e5b9g9r9" };
  const { data, width, height } = texture.mipmaps?.length ? texture.mipmaps[0] : texture.image;
  return { format: name[texture.type], width, height, texels: base64(data), space: texture.colorSpace };
}

for (const file of files) {
  const bytes = new Uint8Array(readFileSync(file));
  const answer = { file };
  if (file.endsWith(".ktx2")) answer.parsed = parsed(bytes);
  try {
    answer.three = await loaded(file, bytes);
  } catch (error) {
    answer.refused = String(error);
  }
  console.log(JSON.stringify(answer));
}
