// The path of a scripted hand (scenes/*/stroke.csv): where each hand is at each time.
import { type Vec3, add, scale, sub } from './vector';

interface Point {
  time_s: number;
  at_m: Vec3;
}

export class HandPath {
  private constructor(private readonly arms: Point[][]) {}

  // Columns time_s, x_m, y_m, z_m and perhaps arm, in any order.
  static parse(csv: string): HandPath {
    const [header, ...rows] = csv
      .trim()
      .split(/\r?\n/)
      .filter((line) => !line.startsWith('#'));
    const columns = header.split(',').map((name) => name.trim());
    const arms: Point[][] = [];
    for (const row of rows) {
      const numbers = row.split(',').map(Number);
      const get = (name: string): number => numbers[columns.indexOf(name)] ?? 0;
      (arms[get('arm')] ??= []).push({ time_s: get('time_s'), at_m: [get('x_m'), get('y_m'), get('z_m')] });
    }
    return new HandPath(arms);
  }

  get arm_count(): number {
    return this.arms.length;
  }
  get from_s(): number {
    return Math.min(...this.arms.map((points) => points[0].time_s));
  }
  get until_s(): number {
    return Math.max(...this.arms.map((points) => points[points.length - 1].time_s));
  }
  at(arm: number, time_s: number): Vec3 {
    const points = this.arms[arm];
    const next = points.findIndex((point) => point.time_s > time_s);
    if (next <= 0) return points[next === 0 ? 0 : points.length - 1].at_m;
    const [a, b] = [points[next - 1], points[next]];
    const part = (time_s - a.time_s) / (b.time_s - a.time_s);
    return add(a.at_m, scale(sub(b.at_m, a.at_m), part));
  }
}
