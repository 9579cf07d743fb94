// Every demonstration, the moment of its scripted hand at which its picture is taken, and what is seen in it.
export interface Picture {
  scene: string; // NAME of NAME.scene.json
  folder: string; // in scenes/
  at_s: number; // on the hand's path; there the hand stays until the picture is taken
  peak?: boolean; // then back to the moment of the greatest force: for a contact that does not last
  from_s?: number; // the path is followed from here on, where what comes before leaves nothing behind
  arms?: number;
  turns?: string; // of the view: l, r, u, d, +, - for 15 degrees to a side, and nearer and farther
  text: string;
}

export const kPictures: Picture[] = [
  {
    scene: 'asteroid',
    folder: 'asteroid',
    at_s: 2.4,
    text: 'A faceted stone of 320 triangles. The force is normal to the facet on which the god object lies.',
  },
  {
    scene: 'pushed',
    folder: 'asteroid',
    at_s: 1.5,
    text: 'The same stone as a mass on a spring, free to rotate, pushed away from its position.',
  },
  {
    scene: 'asteroid-inside',
    folder: 'asteroid-inside',
    at_s: 3,
    text: 'The same stone as a cave around the hand, seen through its near wall: the wall pushes inwards.',
  },
  {
    scene: 'baboon',
    folder: 'baboon',
    at_s: 2.3,
    turns: 'uu+',
    text: 'A height field from the brightness of an image: the finger moves along the ridge of the nose.',
  },
  {
    scene: 'blocks',
    folder: 'blocks',
    at_s: 2.5,
    arms: 2,
    text: 'Two fingertips carry a block by friction alone, towards the other block.',
  },
  {
    scene: 'dribble',
    folder: 'blocks',
    at_s: 2.2,
    arms: 2,
    text: 'Two fingertips lift a rubber block before it is released and dribbled.',
  },
  {
    scene: 'blocks-6dof',
    folder: 'blocks-6dof',
    at_s: 2.85,
    arms: 2,
    text: 'Two fingertips rotate a free block; behind it is a tall one that can be tipped over.',
  },
  {
    scene: 'buttons',
    folder: 'buttons',
    at_s: 1.75,
    text: 'The second of three push buttons is held down past its click; its switch is on, so it is green.',
  },
  {
    scene: 'deform',
    folder: 'deform',
    at_s: 1.2,
    turns: '+',
    text: 'A soft pad sinks under the finger; depth and width follow the closed form.',
  },
  {
    scene: 'ice',
    folder: 'ice',
    at_s: 1.58,
    text: 'Ice has no friction: the force is normal to the dome, in whichever direction the finger slides.',
  },
  {
    scene: 'multy3',
    folder: 'multy3',
    at_s: 1.5,
    peak: true,
    text: 'Three pucks that look alike slide on ice between boards. The light one is pushed against the next.',
  },
  {
    scene: 'needle',
    folder: 'needle',
    at_s: 2.6,
    text: 'A needle in layers of tissue. The force curve has a drop for each layer that tore.',
  },
  {
    scene: 'potential',
    folder: 'potential',
    at_s: 2.6,
    text: 'Solved potential fields: a block of tissue with a hard lump, pressed above it, a ball of jelly, and a skin.',
  },
  {
    scene: 'ring',
    folder: 'ring',
    at_s: 3.8,
    text: 'A mesh ring, smooth by force shading, on a table of ice: the finger is in the groove between the two.',
  },
  {
    scene: 'scan',
    folder: 'scan',
    at_s: 1.9,
    from_s: 0.4,
    text: 'A pad as measured by `thimble scan`. Darker is stiffer: two firm spots and a ridge under a flat skin.',
  },
  {
    scene: 'sliders',
    folder: 'sliders',
    at_s: 1.4,
    text: 'Four handles on springs. The soft one is displaced; the force points back to its rest position.',
  },
  {
    scene: 'faceted',
    folder: 'smooth',
    at_s: 7,
    from_s: 6.2,
    turns: '+',
    text: 'A stone and a ball of 80 triangles, without force shading: every edge is felt.',
  },
  {
    scene: 'smooth',
    folder: 'smooth',
    at_s: 7,
    from_s: 6.2,
    turns: '+',
    text: 'The same two with force shading: the edges are not felt, and 80 triangles push like a sphere.',
  },
  {
    scene: 'spline-tissue',
    folder: 'spline-tissue',
    at_s: 3.08,
    from_s: 2.1,
    text: 'Stiffness from a bicubic B-spline, darker where it is stiffer: a hard lump under a flat skin.',
  },
  {
    scene: 'stick-slip',
    folder: 'stick-slip',
    at_s: 4.4,
    text: 'A rubber mat: the sliding finger sticks and slips, so the force tilts against the motion and its curve is a saw-tooth.',
  },
  {
    scene: 'telephone',
    folder: 'telephone',
    at_s: 2.44,
    text: 'A telephone as a matrix of heights: twelve keys with concave tops, the slope behind them, the handset.',
  },
  {
    scene: 'textures',
    folder: 'textures',
    at_s: 2.45,
    from_s: 2,
    turns: 'u',
    text: 'Six textures, drawn by their heights: egg boxes, ridges, rough ridges, noise by normal and by force, a grater.',
  },
  {
    scene: 'vector-fields',
    folder: 'vector-fields',
    at_s: 3.2,
    from_s: 2.4,
    text: 'A transparent cube and ball of vector field, with solid ones beside them; a thin plate of each kind.',
  },
  {
    scene: 'walls',
    folder: 'walls',
    at_s: 3.6,
    text: 'Five planes around free space. In the corner of floor and rough back wall the god object lies on two planes.',
  },
];

const file = ({ scene, folder }: Picture): string => `[scene](../scenes/${folder}/${scene}.scene.json)`;

// docs/pictures.md.
export function page_of_pictures(): string {
  const head = `# What the demonstrations look like

The page of \`thimble view\` with each scene of [scenes/](../scenes/README.md), at one moment of its stroke; the display is paused there, so
the curves end at that moment. \`scripts/pictures\` takes the pictures. Blue is the tip (arm 1: violet), yellow the god object, green
the contact plane, orange the force on the hand, red the hand with a line to the tip.
`;
  return (
    head + kPictures.map((it) => `\n## ${it.scene}\n\n${it.text} (${file(it)})\n\n![${it.scene}](pictures/${it.scene}.png)\n`).join('')
  );
}
