// A solid as a file of each format of meshes.
export interface Solid {
  points: [number, number, number][];
  faces: [number, number, number][];
}

// A ball of 3 N^2 / 2 * 4 triangles with unequal radii, wound outwards.
export function bumpy_ball(rings: number): Solid {
  const points: Solid['points'] = [[0, 0, 1.1]];
  const around = 2 * rings;
  for (let ring = 1; ring < rings; ++ring)
    for (let step = 0; step < around; ++step) {
      const [down, turn] = [(Math.PI * ring) / rings, (Math.PI * step) / rings];
      const radius = 1 + 0.1 * Math.sin(5 * turn) * Math.sin(3 * down);
      points.push([radius * Math.sin(down) * Math.cos(turn), radius * Math.sin(down) * Math.sin(turn), radius * Math.cos(down)]);
    }
  points.push([0, 0, -0.9]);
  const at = (ring: number, step: number): number => 1 + (ring - 1) * around + (step % around);
  const faces: Solid['faces'] = [];
  for (let step = 0; step < around; ++step) {
    faces.push([0, at(1, step), at(1, step + 1)], [points.length - 1, at(rings - 1, step + 1), at(rings - 1, step)]);
    for (let ring = 1; ring < rings - 1; ++ring)
      faces.push(
        [at(ring, step), at(ring + 1, step), at(ring + 1, step + 1)],
        [at(ring, step), at(ring + 1, step + 1), at(ring, step + 1)],
      );
  }
  return { points, faces };
}

const floats = (solid: Solid): Buffer => Buffer.from(new Float32Array(solid.points.flat()).buffer);
const indices = (solid: Solid): Buffer => Buffer.from(new Uint32Array(solid.faces.flat()).buffer);

function obj({ points, faces }: Solid): Buffer {
  const lines = [...points.map((point) => `v ${point.join(' ')}`), ...faces.map((face) => `f ${face.map((at) => at + 1).join(' ')}`)];
  return Buffer.from(lines.join('\n') + '\n');
}

function off({ points, faces }: Solid): Buffer {
  return Buffer.from(
    [`OFF`, `${points.length} ${faces.length} 0`, ...points.map((p) => p.join(' ')), ...faces.map((f) => `3 ${f.join(' ')}`)].join('\n') +
      '\n',
  );
}

function plg({ points, faces }: Solid): Buffer {
  const lines = [...points.map((p) => p.join(' ')), ...faces.map((f) => `0x1 3 ${[...f].reverse().join(' ')}`)];
  return Buffer.from([`ball ${points.length} ${faces.length}`, ...lines].join('\n') + '\n');
}

function stl_text({ points, faces }: Solid): Buffer {
  const facet = (face: number[]): string =>
    `facet normal 0 0 0\nouter loop\n${face.map((at) => `vertex ${points[at].join(' ')}`).join('\n')}\nendloop\nendfacet\n`;
  return Buffer.from(`solid ball\n${faces.map(facet).join('')}endsolid ball\n`);
}

function stl_binary({ points, faces }: Solid): Buffer {
  const bytes = Buffer.alloc(84 + 50 * faces.length);
  bytes.writeUInt32LE(faces.length, 80);
  faces.forEach((face, k) =>
    face.forEach((at, corner) =>
      points[at].forEach((value, axis) => bytes.writeFloatLE(value, 84 + 50 * k + 12 * (corner + 1) + 4 * axis)),
    ),
  );
  return bytes;
}

function ply(solid: Solid, format: string, body: Buffer): Buffer {
  const header = [
    'ply',
    `format ${format} 1.0`,
    `element vertex ${solid.points.length}`,
    ...['x', 'y', 'z'].map((axis) => `property float ${axis}`),
    `element face ${solid.faces.length}`,
    'property list uchar int vertex_indices',
    'end_header\n',
  ];
  return Buffer.concat([Buffer.from(header.join('\n')), body]);
}
const ply_text = (solid: Solid): Buffer =>
  ply(
    solid,
    'ascii',
    Buffer.from([...solid.points.map((p) => p.join(' ')), ...solid.faces.map((f) => `3 ${f.join(' ')}`)].join('\n') + '\n'),
  );
function ply_binary(solid: Solid): Buffer {
  const faces = solid.faces.map((face) => Buffer.concat([Buffer.from([3]), Buffer.from(new Int32Array(face).buffer)]));
  return ply(solid, 'binary_little_endian', Buffer.concat([floats(solid), ...faces]));
}

function gltf_document(solid: Solid, uri?: string): object {
  const [points, faces] = [floats(solid), indices(solid)];
  return {
    asset: { version: '2.0' },
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      {
        bufferView: 0,
        componentType: 5126,
        count: solid.points.length,
        type: 'VEC3',
        min: [0, 1, 2].map((axis) => Math.min(...solid.points.map((p) => Math.fround(p[axis])))),
        max: [0, 1, 2].map((axis) => Math.max(...solid.points.map((p) => Math.fround(p[axis])))),
      },
      { bufferView: 1, componentType: 5125, count: 3 * solid.faces.length, type: 'SCALAR' },
    ],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: points.length },
      { buffer: 0, byteOffset: points.length, byteLength: faces.length },
    ],
    buffers: [{ byteLength: points.length + faces.length, ...(uri === undefined ? {} : { uri }) }],
  };
}
const gltf_body = (solid: Solid): Buffer => Buffer.concat([floats(solid), indices(solid)]);
const gltf_inside = (solid: Solid): Buffer =>
  Buffer.from(JSON.stringify(gltf_document(solid, `data:application/octet-stream;base64,${gltf_body(solid).toString('base64')}`)));
const gltf_beside = (solid: Solid): Buffer => Buffer.from(JSON.stringify(gltf_document(solid, 'ball.bin')));
function glb(solid: Solid): Buffer {
  const chunk = (type: string, bytes: Buffer, fill: number): Buffer => {
    const body = Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);
    const head = Buffer.alloc(8);
    head.writeUInt32LE(body.length, 0);
    head.write(type, 4, 'latin1');
    return Buffer.concat([head, body]);
  };
  const chunks = [chunk('JSON', Buffer.from(JSON.stringify(gltf_document(solid))), 0x20), chunk('BIN\0', gltf_body(solid), 0)];
  const head = Buffer.alloc(12);
  head.write('glTF', 0, 'latin1');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks[0].length + chunks[1].length, 8);
  return Buffer.concat([head, ...chunks]);
}

// By the name of the file: the formats, and the files that they need beside them.
export const kFormats: Record<string, { bytes(solid: Solid): Buffer; beside?: Record<string, (solid: Solid) => Buffer> }> = {
  'ball.obj': { bytes: obj },
  'ball.off': { bytes: off },
  'ball.plg': { bytes: plg },
  'text.stl': { bytes: stl_text },
  'binary.stl': { bytes: stl_binary },
  'text.ply': { bytes: ply_text },
  'binary.ply': { bytes: ply_binary },
  'inside.gltf': { bytes: gltf_inside },
  'beside.gltf': { bytes: gltf_beside, beside: { 'ball.bin': gltf_body } },
  'ball.glb': { bytes: glb },
};
