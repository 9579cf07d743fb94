// A hand that is led to a place by what a user has: mouse, or keys. Which way the picture is seen from is not asked: each way to move
// is tried, what it does to the hand is seen from the server's states, and so it is known how far to go.
import type { Page } from 'playwright-core';

import { type Vec3, add, cross, dot, length, scale, sub } from '../../src/vector';
import type { Watcher } from './watcher';

// What was done has been sent: the page sends once a frame.
const sent = (page: Page) => page.evaluate('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))');

type Move = (amount: number) => Promise<void>;

// In pixels to the right, pixels down, and clicks of the wheel.
export function by_mouse(page: Page): Move[] {
  const drag = async (dx: number, dy: number) => {
    const box = await page.getByTestId('view').boundingBox();
    if (box === null) throw new Error('there is no view');
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    // A drag begins again where the mouse would leave the window.
    const times = Math.ceil(Math.max(Math.abs(dx), Math.abs(dy)) / 150);
    for (let i = 0; i < times; ++i) {
      await page.mouse.move(x, y);
      await page.mouse.down();
      await page.mouse.move(x + dx / times, y + dy / times, { steps: 6 });
      await page.mouse.up();
    }
    await sent(page);
  };
  return [
    (pixels) => drag(pixels, 0),
    (pixels) => drag(0, pixels),
    async (clicks) => {
      await page.getByTestId('view').hover();
      await page.mouse.wheel(0, 50 * clicks);
      await sent(page);
    },
  ];
}

// In taps of a key of a millimetre each; the view has the focus.
export function by_keys(page: Page): Move[] {
  const pairs = [
    ['ArrowLeft', 'ArrowRight'],
    ['ArrowDown', 'ArrowUp'],
    ['PageDown', 'PageUp'],
  ];
  return pairs.map(([less, more]) => async (taps: number) => {
    for (let i = 0; i < Math.abs(Math.round(taps)); ++i) await page.keyboard.press(taps < 0 ? less : more);
    // Shift is a fifth of a tap.
    const rest = Math.round((taps - Math.round(taps)) * 5);
    for (let i = 0; i < Math.abs(rest); ++i) await page.keyboard.press(`Shift+${rest < 0 ? less : more}`);
    await sent(page);
  });
}

export class Steering {
  private ways: [Vec3, Vec3, Vec3] | null = null; // metres for one of each move

  constructor(
    private readonly moves: Move[],
    private readonly watcher: Watcher,
    private readonly trial: Vec3, // so much of each move is tried
  ) {}

  // Within `near_m` of the place. A loaded machine may take a hand for one at rest that still waits for a move; what was learned then is
  // wrong, does not lead nearer, and is learned anew.
  async lead(arm: number, to_m: Vec3, near_m = 0.0008): Promise<void> {
    let before_m = Infinity;
    for (let round = 0; round < 12; ++round) {
      const off = sub(to_m, await this.watcher.hand_at_rest(arm));
      if (length(off) < near_m) return;
      if (length(off) > before_m / 2) this.ways = null;
      before_m = length(off);
      const ways = await this.learn(arm);
      const left = sub(to_m, this.watcher.hand_m(arm));
      const volume = dot(ways[0], cross(ways[1], ways[2]));
      const amounts = [cross(ways[1], ways[2]), cross(ways[2], ways[0]), cross(ways[0], ways[1])].map((it) => dot(left, it) / volume);
      for (const [i, move] of this.moves.entries()) await move(amounts[i]);
    }
    throw new Error(`the hand of arm ${arm} does not come to ${to_m}: it is at ${this.watcher.hand_m(arm)}`);
  }

  private async learn(arm: number): Promise<[Vec3, Vec3, Vec3]> {
    if (this.ways !== null) return this.ways;
    const ways: Vec3[] = [];
    for (const [i, move] of this.moves.entries()) {
      const before = await this.watcher.hand_at_rest(arm);
      await move(this.trial[i]);
      const after = await this.watcher.hand_at_rest(arm);
      ways.push(scale(sub(after, before), 1 / this.trial[i]));
      if (length(ways[i]) < 1e-6) throw new Error(`move ${i} does not move the hand`);
    }
    this.ways = [ways[0], ways[1], ways[2]];
    return this.ways;
  }
}

export const above = (place: Vec3, by_m: number): Vec3 => add(place, [0, 0, by_m]);
