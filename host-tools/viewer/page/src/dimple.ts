// How far the surface of a tissue sinks around a round flat tip: Boussinesq's flat punch (docs/scene-format.md).
export interface Dimple {
  x_m: number;
  y_m: number;
  depth_m: number;
}

export function sunk_m(x_m: number, y_m: number, dimple: Dimple, contact_radius_m: number): number {
  const r = Math.hypot(x_m - dimple.x_m, y_m - dimple.y_m);
  return r <= contact_radius_m ? dimple.depth_m : dimple.depth_m * (2 / Math.PI) * Math.asin(contact_radius_m / r);
}

// Each arm has a dimple of its own; where they overlap the picture shows the deeper one.
export function surface_m(x_m: number, y_m: number, dimples: readonly Dimple[], contact_radius_m: number): number {
  let sunk = 0;
  for (const dimple of dimples) sunk = Math.max(sunk, sunk_m(x_m, y_m, dimple, contact_radius_m));
  return -sunk;
}
