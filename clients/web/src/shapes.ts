// The parts' shapes: meshes as the server serves them, and the edges that a person recognises.

import { type BufferGeometry, Color, EdgesGeometry, Mesh, Vector3 } from "three";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";
import { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
import type { Api } from "./api";
import type { AssetInfo } from "./types";

/** Faces that meet at less than this make no edge, degrees. */
const EDGE_DEG = 32;

/** A part in its body frame, glTF's axes, metres. */
export interface PartShape {
  mesh: BufferGeometry;
  edges: BufferGeometry;
  /** The same for lines that are wider than a pixel; made when it is first asked for. */
  wideEdges: () => LineSegmentsGeometry;
  color: Color;
  /** Middle of its bounding box, and from there to its corners. */
  center: Vector3;
  radius: number;
}

export type Shapes = ReadonlyMap<string, PartShape>;

/**
 * The shapes of all parts of an asset.
 *
 * @throws ProblemError or TypeError where a mesh does not come.
 */
export async function loadShapes(api: Api, asset: AssetInfo): Promise<Shapes> {
  const loader = new GLTFLoader();
  const loaded = await Promise.all(
    asset.parts.map(async (part): Promise<[string, PartShape]> => {
      const gltf = await loader.loadAsync(api.file(part.mesh).href);
      const [red = 0, green = 0, blue = 0] = part.color_rgb;
      const color = new Color().setRGB(red / 255, green / 255, blue / 255, "srgb");
      return [part.part, shape(gltf.scene, color)];
    }),
  );
  return new Map(loaded);
}

function shape(scene: { traverse: (visit: (node: object) => void) => void }, color: Color) {
  const pieces: BufferGeometry[] = [];
  scene.traverse((node) => {
    if (!(node instanceof Mesh)) return;
    node.updateWorldMatrix(true, false);
    const piece = (node.geometry as BufferGeometry).clone().applyMatrix4(node.matrixWorld);
    for (const name of Object.keys(piece.attributes)) {
      if (name !== "position" && name !== "normal") piece.deleteAttribute(name);
    }
    pieces.push(piece);
  });
  const mesh = mergeGeometries(pieces);
  mesh.computeBoundingBox();
  const edges = new EdgesGeometry(mesh, EDGE_DEG);
  let wide: LineSegmentsGeometry | null = null;
  const wideEdges = () => (wide ??= new LineSegmentsGeometry().fromEdgesGeometry(edges));
  const center = mesh.boundingBox?.getCenter(new Vector3()) ?? new Vector3();
  const radius = (mesh.boundingBox?.getSize(new Vector3()).length() ?? 0) / 2;
  return { mesh, edges, wideEdges, color, center, radius };
}
