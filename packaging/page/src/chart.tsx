// Curves over the travel, drawn as their values grow.
import type { Curve } from "./table";
import { figure, t } from "./words";

const [WIDTH, HEIGHT, LEFT, BELOW, ABOVE] = [420, 190, 44, 22, 10];
const dashes = ["", "7 4", "2 3", "9 3 2 3", "1 4", "12 3"];

function ends(values: number[]): [number, number] {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return low === high ? [low - 1, high + 1] : [low, high];
}

function Chart(props: { title: string; curves: Curve[] }) {
  const all = props.curves.flatMap((curve) => curve.points);
  if (!all.length) return null;
  const [from, to] = ends(all.map((point) => point[0]));
  const [low, high] = ends([0, ...all.map((point) => point[1])]);
  const x = (mm: number) => LEFT + ((mm - from) / (to - from)) * (WIDTH - LEFT - 8);
  const y = (um: number) => ABOVE + ((high - um) / (high - low)) * (HEIGHT - ABOVE - BELOW);
  return (
    <figure class="chart">
      <figcaption>
        {props.title}
        {props.curves.map((curve, n) => (
          <span class={`ink${n % 6}`}>
            <svg width="24" height="8" aria-hidden="true">
              <line x1="0" x2="24" y1="4" y2="4" stroke-dasharray={dashes[n % 6]} />
            </svg>
            {curve.name}
          </span>
        ))}
      </figcaption>
      <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={`${props.title}: ${props.curves.map((curve) => curve.name).join(", ")}`}>
        <line class="axis" x1={LEFT} x2={WIDTH - 8} y1={y(0)} y2={y(0)} />
        {[low, high].map((um) => (
          <text x={LEFT - 6} y={y(um) + 4} text-anchor="end">
            {figure(um, Math.abs(high - low) < 5 ? 2 : 1)}
          </text>
        ))}
        <text x={LEFT} y={HEIGHT - 5}>{figure(from, 0)}</text>
        <text x={WIDTH - 8} y={HEIGHT - 5} text-anchor="end">{`${figure(to, 0)} mm`}</text>
        <text x={LEFT - 6} y={y(0) + 4} text-anchor="end">0</text>
        {props.curves.map((curve, n) => (
          <polyline class={`ink${n % 6}`} stroke-dasharray={dashes[n % 6]} points={curve.points.map(([mm, um]) => `${x(mm).toFixed(1)},${y(um).toFixed(1)}`).join(" ")} />
        ))}
      </svg>
    </figure>
  );
}

export function Charts(props: { of: Map<string, Curve[]> }) {
  if (!props.of.size) return null;
  return (
    <div class="charts">
      {[...props.of].map(([axis, curves]) => (
        <Chart key={axis} title={axis.length === 1 ? `${t("curve_of", { axis })}` : axis} curves={curves} />
      ))}
    </div>
  );
}
