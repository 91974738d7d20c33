// The table that was measured: as a grid, with what grows from it.
import { Charts } from "./chart";
import { Grid } from "./grid";
import { withTable } from "./measured";
import { curves, table, type Curve } from "./table";
import { Card, Drop, Problems } from "./ui";
import { isReadings, job, made, measured, separated, textOf } from "./visit";
import { t } from "./words";

/** The nine errors as `separate` gives them, by their moving axis. */
function ofReadings(errors: Record<string, { position_mm: number[]; deviation_um: number[] }>): Map<string, Curve[]> {
  const found = new Map<string, Curve[]>();
  for (const [name, { position_mm, deviation_um }] of Object.entries(errors)) {
    const axis = name.charAt(2);
    const panel = found.get(axis) ?? found.set(axis, []).get(axis)!;
    panel.push({ name, points: position_mm.map((mm, n) => [mm, deviation_um[n]!]) });
  }
  return found;
}

export function MeasurementStep() {
  const all = made.value?.problems ?? [];
  const single = measured.value.length === 1;
  return (
    <>
      {measured.value.map((file) => {
        const of = table(textOf(file));
        const own = all.filter((problem) => problem.places.some((place) => place.file === file));
        const grown = separated.value ? ofReadings(separated.value.errors) : of ? curves(of) : new Map();
        return (
          <Card key={file} title={file} wide>
            <Problems of={own} />
            <div class="beside">
              <Grid file={file} problems={own} />
              <div>
                <h3>{t(isReadings.value ? "separated" : "curves_grow")}</h3>
                {grown.size ? <Charts of={grown} /> : <p class="soft">{t("not_yet")}</p>}
                {separated.value?.doubts.map((words) => <p class="told">{words}</p>)}
              </div>
            </div>
          </Card>
        );
      })}
      {single && (
        <Card wide>
          <Drop words={t("drop_table")} take={(dropped) => withTable(job, dropped)} />
        </Card>
      )}
    </>
  );
}
