// After loading: the second measurement, its verdict with causes, the page to sign.
import { Decides, Figures } from "./figures";
import { JobForm } from "./form";
import { Grid } from "./grid";
import { ReportPage } from "./kit";
import { Card, Drop, Notes, Picture, Problems, Scope, Verdict } from "./ui";
import { after, files, kit, measuredAfter, put, second, type Files } from "./visit";
import { withTable } from "./measured";
import { t } from "./words";

function take(dropped: Files) {
  for (const [name, content] of dropped) {
    const bare = name.slice(name.lastIndexOf("/") + 1);
    if (/\.toml$/i.test(bare)) after.value = bare;
    if (after.value.endsWith(".toml") && !/\.toml$/i.test(bare)) withTable(after, bare, content);
    else put(bare, content);
    if (!after.value.endsWith(".toml")) after.value = bare;
  }
}

export function SecondStep() {
  if (!kit.value.length) return <Card wide>{t("first_kit")}</Card>;
  const now = second.value;
  const table = measuredAfter.value;
  const problems = now?.problems ?? [];
  return (
    <>
      <Card wide>
        {now?.judged ? (
          <>
            <p class="head">
              <Verdict of={now.judged.verdict} /> {now.judged.diagnosis?.as_forecast && t("as_forecast")}
            </p>
            <Scope of={now.scope} />
            <Decides judged={now.judged} />
            <Figures judged={now.judged} />
            <Notes of={now.judged.notes} />
          </>
        ) : (
          <>
            <p class="head">{t("no_second")}</p>
            <p>{t("second_hint")}</p>
            <Problems of={problems} />
          </>
        )}
      </Card>
      {now?.judged && (
        <Card title={t("curves")} wide>
          <Picture svg={now.picture} />
        </Card>
      )}
      {now?.judged && (
        <Card title={t("to_sign")} wide>
          <ReportPage withAfter name="report-after.html" />
        </Card>
      )}
      {after.value.endsWith(".toml") && files.value.has(after.value) && (
        <details>
          <summary>{after.value}</summary>
          <JobForm file={after.value} problems={problems} />
        </details>
      )}
      <Card title={table} wide>
        {files.value.has(table) && <Grid file={table} problems={problems} />}
        <Drop words={t("drop_table")} take={take} />
      </Card>
    </>
  );
}
