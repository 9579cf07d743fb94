// Every demonstration, and the moment of its scripted hand at which its picture is taken.
export interface Picture {
  scene: string; // NAME of NAME.scene.json
  folder: string; // in scenes/
  at_s: number; // on the hand's path; there the hand stays until the picture is taken
  from_s?: number; // the path is followed from here on, where what comes before leaves nothing behind
  arms?: number;
  turns?: string; // of the view: l, r, u, d, +, - for 15 degrees to a side, and nearer and farther
  text: string; // what is seen
}

export const kPictures: Picture[] = [
  { scene: 'asteroid', folder: 'asteroid', at_s: 2.4, text: '' },
  { scene: 'pushed', folder: 'asteroid', at_s: 2.4, text: '' },
  { scene: 'asteroid-inside', folder: 'asteroid-inside', at_s: 3, text: '' },
  { scene: 'baboon', folder: 'baboon', at_s: 2.3, text: '' },
  { scene: 'blocks', folder: 'blocks', at_s: 2.4, arms: 2, text: '' },
  { scene: 'dribble', folder: 'blocks', at_s: 2.2, arms: 2, text: '' },
  { scene: 'blocks-6dof', folder: 'blocks-6dof', at_s: 2.8, arms: 2, text: '' },
  { scene: 'buttons', folder: 'buttons', at_s: 1.75, text: '' },
  { scene: 'deform', folder: 'deform', at_s: 1.2, text: '' },
  { scene: 'ice', folder: 'ice', at_s: 1.5, text: '' },
  { scene: 'multy3', folder: 'multy3', at_s: 1.2, text: '' },
  { scene: 'needle', folder: 'needle', at_s: 2.6, text: '' },
  { scene: 'potential', folder: 'potential', at_s: 2.6, text: '' },
  { scene: 'ring', folder: 'ring', at_s: 3.1, text: '' },
  { scene: 'scan', folder: 'scan', at_s: 1.6, text: '' },
  { scene: 'sliders', folder: 'sliders', at_s: 1.4, text: '' },
  { scene: 'faceted', folder: 'smooth', at_s: 7, from_s: 6.2, text: '' },
  { scene: 'smooth', folder: 'smooth', at_s: 7, from_s: 6.2, text: '' },
  { scene: 'spline-tissue', folder: 'spline-tissue', at_s: 2.5, from_s: 2.1, text: '' },
  { scene: 'stick-slip', folder: 'stick-slip', at_s: 2.5, text: '' },
  { scene: 'telephone', folder: 'telephone', at_s: 1.9, text: '' },
  { scene: 'textures', folder: 'textures', at_s: 2.5, from_s: 2, text: '' },
  { scene: 'vector-fields', folder: 'vector-fields', at_s: 3.2, from_s: 2.4, text: '' },
  { scene: 'walls', folder: 'walls', at_s: 2.6, text: '' },
];
