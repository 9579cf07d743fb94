// The task of every demonstration: its own ghost fulfils it with the device of the site, and nothing does before. And what a user does who has one
// mouse for two fingers.
import assert from 'node:assert/strict';
import { existsSync, readFileSync } from 'node:fs';
import { basename, dirname, join } from 'node:path';
import { test } from 'node:test';

import { Ghost } from '../../src/ghost';
import { HandPath } from '../../src/hand_path';
import type { State } from '../../src/protocol';
import { TaskWatch } from '../../src/task_watch';
import { kTasks } from '../../src/tasks';
import type { Vec3 } from '../../src/vector';
import { Bench } from '../site/bench';
import { all_files, kScenes } from '../site/modules';

const scenes = all_files(kScenes).filter((file) => file.endsWith('.scene.json'));
const name_of = (file: string): string => basename(file, '.scene.json');

function path_of(scene: string): HandPath {
  const own = join(dirname(scene), `${name_of(scene)}.stroke.csv`);
  return HandPath.parse(readFileSync(existsSync(own) ? own : join(dirname(scene), 'stroke.csv'), 'utf8'));
}

test('every scene has a task, and every task a scene', () => {
  assert.deepEqual(Object.keys(kTasks).sort(), scenes.map(name_of).sort());
});

for (const scene of scenes) {
  const name = name_of(scene);
  const task = kTasks[name];
  test(name, () => {
    const path = path_of(scene);
    const bench = new Bench({ arms: path.arm_count });
    bench.post({ type: 'pick', scene: name });
    bench.until('armed', () => bench.newest?.mode === 'armed');
    const watch = new TaskWatch(
      task,
      (bench.scenes.at(-1)?.objects ?? []).map((object) => object.name),
    );
    let last: State | undefined;
    const look = () => {
      for (const state of bench.states.splice(0)) watch.take((last = state));
    };
    bench.run(0.5);
    look();
    assert.equal(watch.goals_met, 0, 'fulfilled by nothing');

    const ghost = new Ghost(path, task.shown_s ?? Infinity, (arm, position_m) => bench.post({ type: 'hand', arm, position_m }));
    const hands = (): Vec3[] => (last?.arms ?? []).map((arm) => arm?.hand_m ?? arm?.tip_m ?? [0, 0, 0]);
    let time_s = 0;
    for (; ghost.step(time_s, hands()) && !watch.done; time_s += 0.016) {
      bench.run(0.016);
      look();
    }
    assert.ok(watch.done && task.goals.length > 0, `${watch.goals_met} of ${task.goals.length}`);
    assert.deepEqual(
      bench.events.filter((event) => event.level === 'error'),
      [],
    );
  });
}

for (const [how, lifts] of [
  ['one finger, while the other one stays', [0]],
  ['both fingers together', [0, 1]],
] as const)
  test(`a block that is pressed with 4 N from both sides and lifted by ${how} is lifted`, () => {
    const bench = new Bench({ arms: 2 });
    bench.post({ type: 'pick', scene: 'blocks' });
    bench.until('armed', () => bench.newest?.mode === 'armed');
    const watch = new TaskWatch(
      kTasks.blocks,
      (bench.scenes.at(-1)?.objects ?? []).map((object) => object.name),
    );
    const look = () => bench.states.splice(0).forEach((state) => watch.take(state));
    const y = -0.03;
    const beside = [-0.04, 0.04];
    const pressed = [-0.001, 0.001];
    for (const arm of [0, 1]) bench.go(1, [2.5 * beside[arm], 0, 0], [beside[arm], y, -0.035], arm);
    for (const arm of [0, 1]) bench.go(0.6, [beside[arm], y, -0.035], [pressed[arm], y, -0.035], arm);
    bench.run(0.2);
    look();
    assert.ok(!watch.done, 'pressed, not lifted');
    for (let z = -0.035; z < -0.011; z += 0.001) {
      for (const arm of lifts) bench.post({ type: 'hand', arm, position_m: [pressed[arm], y, z] });
      bench.run(0.04);
      look();
    }
    assert.ok(watch.done);
  });
