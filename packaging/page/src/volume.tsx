// The error vectors of the volume, before and with the tables, as one turns them.
import { useState } from "preact/hooks";
import type { Vectors, Volume } from "./visit";
import { figure, t } from "./words";

type Place = [number, number, number];

const SIZE = 360;

/** What of the largest edge the longest arrow takes. */
const LONGEST = 0.25;

export function VolumeView(props: { of: Volume }) {
  const { of } = props;
  const [[turn, tilt], setTurned] = useState([0.7, 0.5]);
  const drag = (event: PointerEvent) => {
    if (event.buttons !== 1) return;
    setTurned(([a, b]) => [a + event.movementX / 120, Math.max(-1.5, Math.min(1.5, b + event.movementY / 120))]);
  };
  const keys = (event: KeyboardEvent) => {
    const way: Record<string, [number, number]> = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    const by = way[event.key];
    if (!by) return;
    event.preventDefault();
    setTurned(([a, b]) => [a + by[0], Math.max(-1.5, Math.min(1.5, b + by[1]))]);
  };
  const sides: [string, string, Vectors][] = [[t("found"), "before", of.vectors]];
  if (of.after) sides.push([t("forecast"), "after", of.after.vectors]);
  const places = of.vectors.places_mm;
  const low = [0, 1, 2].map((n) => Math.min(...places.map((place) => place[n]!)));
  const high = [0, 1, 2].map((n) => Math.max(...places.map((place) => place[n]!)));
  const edge = Math.max(...high.map((end, n) => end - low[n]!), 1);
  const longest = Math.max(...of.vectors.um.map((um) => Math.hypot(...um)), 1e-9);
  const view = (place: Place): [number, number] => {
    const [x, y, z] = place.map((mm, n) => (mm - (low[n]! + high[n]!) / 2) / edge) as Place;
    const [right, deep] = [x * Math.cos(turn) + y * Math.sin(turn), -x * Math.sin(turn) + y * Math.cos(turn)];
    const up = z * Math.cos(tilt) + deep * Math.sin(tilt);
    return [SIZE / 2 + right * SIZE * 0.62, SIZE / 2 - up * SIZE * 0.62];
  };
  const corner = (n: number): Place => [n & 1 ? high[0]! : low[0]!, n & 2 ? high[1]! : low[1]!, n & 4 ? high[2]! : low[2]!];
  const edges = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((n) => [1, 2, 4].filter((bit) => !(n & bit)).map((bit) => [corner(n), corner(n | bit)] as const));
  const axisEnds = [1, 2, 4].map((bit) => view(corner(bit)));
  return (
    <div>
      <p class="soft">
        {t("volume_turn")}. {t("volume_scale", { um: figure(longest, 2) })}
      </p>
      <div class="views" tabIndex={0} role="application" aria-label={t("volume_turn")} onPointerMove={drag} onKeyDown={keys}>
        {sides.map(([name, kind, vectors]) => (
          <figure>
            <figcaption>{name}</figcaption>
            <svg viewBox={`0 0 ${SIZE} ${SIZE}`} role="img" aria-label={name}>
              {edges.map(([from, to]) => {
                const [a, b] = [view(from), view(to)];
                return <line class="edge" x1={a[0]} y1={a[1]} x2={b[0]} y2={b[1]} />;
              })}
              {axisEnds.map((end, n) => (
                <text x={end[0] + 4} y={end[1] - 4}>{"XYZ"[n]}</text>
              ))}
              {vectors.places_mm.map((place, n) => {
                const um = vectors.um[n]!;
                const to = place.map((mm, m) => mm + (um[m]! / longest) * LONGEST * edge) as Place;
                const [a, b] = [view(place), view(to)];
                return (
                  <g class={kind}>
                    <circle cx={a[0]} cy={a[1]} r="1.6" />
                    <line x1={a[0]} y1={a[1]} x2={b[0]} y2={b[1]} />
                  </g>
                );
              })}
            </svg>
          </figure>
        ))}
      </div>
    </div>
  );
}
