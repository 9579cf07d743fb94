// One task for each demonstration: what is asked of the user, and by what the page sees that it is fulfilled (task_watch.ts). The names are those of
// the scene files in scenes/.
import type { Vec3 } from './vector';

// All that it names holds in one state, while the arm is armed.
export interface Goal {
  control?: { object: string; on?: boolean; moved?: number }; // its switch; metres or radians away from where it was
  // Of no name: any of them. Raised above the lowest place where it has been, which need not be where it was.
  body?: { object?: string; raised_m?: number; moved_m?: number; turned_deg?: number };
  tissue_m?: number; // the depth of a dimple
  torn?: number; // layers of a needle's way
  force_N?: number; // at least, on a tip
  where?: { least_m: Vec3; most_m: Vec3 }; // there that tip is
  stroked_m?: number; // and so far it has come in one touch, there
  touching?: number; // so many tips touch something
}

export interface Task {
  line: string; // of the scene
  task: string;
  goals: Goal[]; // in any order
  shown_s?: number; // of the scripted hand, after which the ghost has shown enough
}

const box = (x: [number, number], y: [number, number], z: [number, number]): Goal['where'] => ({
  least_m: [x[0], y[0], z[0]],
  most_m: [x[1], y[1], z[1]],
});
const kAny: [number, number] = [-1, 1];
const kRaised_m = 0.005; // one finger alone lifts a block by up to 7 mm, the other holding it back, before it slips: that is lifted, too

export const kTasks: Record<string, Task> = {
  buttons: {
    line: 'An instrument panel: buttons that click, a toggle, knobs and a fader.',
    task: 'Press the click button, at the back on the left, until it snaps in.',
    goals: [{ control: { object: 'click button', on: true } }],
    shown_s: 1.3,
  },
  blocks: {
    line: 'Two blocks on a table, and two fingertips.',
    task: 'Lift a block between two fingers: press it from both sides, then move both up.',
    goals: [{ body: { raised_m: kRaised_m }, touching: 2 }],
  },
  textures: {
    line: 'Six patches: egg boxes, ridges, noise, a grater.',
    task: 'Stroke all three patches at the back, a centimetre each.',
    goals: [
      { where: box([-0.05, -0.02], [0.005, 0.045], kAny), stroked_m: 0.01 },
      { where: box([-0.015, 0.015], [0.005, 0.045], kAny), stroked_m: 0.01 },
      { where: box([0.02, 0.05], [0.005, 0.045], kAny), stroked_m: 0.01 },
    ],
    shown_s: 4.5,
  },
  needle: {
    line: 'A biopsy needle in layers of tissue.',
    task: 'Push the needle down until the skin tears.',
    goals: [{ torn: 1 }],
    shown_s: 2,
  },
  deform: {
    line: 'A soft pad that yields, relaxes, and keeps a dimple.',
    task: 'Press a dimple of 8 mm into the pad.',
    goals: [{ tissue_m: 0.008 }],
    shown_s: 1.6,
  },
  walls: {
    line: 'Five walls around you, each with its own feel.',
    task: 'Touch the wall on the left, which clicks, and the rough one at the back.',
    goals: [
      { where: box([-1, -0.04], kAny, kAny), force_N: 0.3 },
      { where: box(kAny, [0.04, 1], kAny), force_N: 0.3 },
    ],
  },
  'stick-slip': {
    line: 'A rubber mat on which a sliding finger squeaks.',
    task: 'Drag the finger over the mat for 4 cm, and let it squeak.',
    goals: [{ stroked_m: 0.04 }],
    shown_s: 3,
  },
  multy3: {
    line: 'Three pucks on ice that look alike, and do not weigh alike.',
    task: 'Push the left puck so that it knocks the middle one away.',
    goals: [{ body: { object: 'middle puck', moved_m: 0.005 } }],
    shown_s: 2.1,
  },
  sliders: {
    line: 'Four handles on springs: soft, medium, stiff, and in honey.',
    task: 'Push the soft slider, the nearest one, 2 cm aside.',
    goals: [{ control: { object: 'soft slider', moved: 0.02 } }],
    shown_s: 1.5,
  },
  'spline-tissue': {
    line: 'A flat skin with a hard lump under it.',
    task: 'Find the hard lump, right of the middle, and press on it until you feel 1 N.',
    goals: [{ where: box([0, 0.02], [-0.005, 0.015], kAny), force_N: 1 }],
  },
  scan: {
    line: 'A pad that was measured by pressing it point by point: firm spots under a flat skin.',
    task: 'Find the firm spot on the right, and press on it until you feel 0.9 N.',
    goals: [{ where: box([0.008, 0.032], [-0.01, 0.018], kAny), force_N: 0.9 }],
  },
  potential: {
    line: 'A block of tissue with a lump, a ball of jelly, and a skin.',
    task: 'Find the hard lump in the middle block, near its right end, and press until you feel 1 N.',
    goals: [{ where: box([0.008, 0.032], [-0.012, 0.012], kAny), force_N: 1 }],
    shown_s: 3,
  },
  telephone: {
    line: 'A desk telephone with twelve keys and a handset.',
    task: 'Run the finger along a row of keys for 3 cm.',
    goals: [{ where: box([-0.045, 0.03], [-0.067, -0.002], kAny), stroked_m: 0.03 }],
    shown_s: 3.2,
  },
  ring: {
    line: 'A smooth ring of many facets on a table of ice.',
    task: 'Follow the ring for 5 cm without losing it.',
    goals: [{ stroked_m: 0.05 }],
  },
  ice: {
    line: 'A dome of ice, without any friction.',
    task: 'Slide over the dome for 4 cm without falling off.',
    goals: [{ stroked_m: 0.04 }],
  },
  asteroid: {
    line: 'A rough stone with facets and craters.',
    task: 'Stroke the stone for 5 cm without losing it.',
    goals: [{ stroked_m: 0.05 }],
  },
  pushed: {
    line: 'The stone on a spring: it yields and turns.',
    task: 'Push the stone 4 mm away.',
    goals: [{ body: { object: 'asteroid', moved_m: 0.004 } }],
    shown_s: 1.6,
  },
  'asteroid-inside': {
    line: 'A cave in the shape of the stone, around your finger.',
    task: 'Stroke the wall of the cave for 5 cm.',
    goals: [{ stroked_m: 0.05 }],
  },
  baboon: {
    line: "An ape's face: brightness as height.",
    task: 'Follow the ridge of the nose for 4 cm.',
    goals: [{ where: box([-0.01, 0.01], kAny, kAny), stroked_m: 0.04 }],
    shown_s: 4,
  },
  smooth: {
    line: 'The stone again, and a ball of 80 triangles, both smooth.',
    task: 'Stroke a smooth surface for 4 cm without losing it.',
    goals: [{ stroked_m: 0.04 }],
  },
  faceted: {
    line: 'The same stone and ball, with every edge.',
    task: 'Stroke an edgy surface for 4 cm without losing it.',
    goals: [{ stroked_m: 0.04 }],
  },
  'vector-fields': {
    line: 'Fields of force that look like solids, beside real solids.',
    task: 'Push the finger right through the thin plate of field, the second from the right.',
    goals: [{ where: box([0.037, 0.073], [-0.028, 0.028], [-1, -0.033]) }],
    shown_s: 7.3,
  },
  dribble: {
    line: 'A rubber block that bounces.',
    task: 'Lift the block between two fingers, by moving both up, then let it fall.',
    goals: [
      { body: { object: 'block', raised_m: kRaised_m }, touching: 2 },
      { body: { object: 'block', raised_m: 0.005 }, touching: 0 },
    ],
    shown_s: 4,
  },
  'blocks-6dof': {
    line: 'Blocks that turn and tip over.',
    task: 'Turn the low block by 20 degrees between two fingers.',
    goals: [{ body: { object: 'block', turned_deg: 20 }, touching: 2 }],
  },
};
