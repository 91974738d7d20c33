// After loading: the second measurement, its verdict with causes, the page to sign.
import { Decides, Figures } from "./figures";
import { JobForm } from "./form";
import { Grid } from "./grid";
import { ReportPage } from "./kit";
import { Card, Drop, Notes, Picture, Problems, Scope, Verdict } from "./ui";
import { after, asTable, files, isTable, isToml, kit, kitState, measured, measuredAfter, notice, putAfter, putSecondJob, second, type Files } from "./visit";
import { withTable } from "./measured";
import { t } from "./words";

/** A job with what it names, or one table: of the job that the second measurement has, or by itself. */
async function take(dropped: Files) {
  const jobs = [...dropped.keys()].filter(isToml);
  const [name, content] = [...dropped][0] ?? ["", new Uint8Array()];
  if (jobs.length > 1 || (!jobs.length && dropped.size !== 1)) notice.value = t("one_second");
  else if (jobs[0]) notice.value = putSecondJob(dropped, jobs[0]) ? "" : t("climbs", { file: jobs[0] });
  else if (isToml(after.value)) await withTable(after, dropped);
  else if (isTable(name)) {
    const table = await asTable(name, content);
    if (table) putAfter(...table);
  } else notice.value = t("not_taken", { file: name });
}

export function SecondStep() {
  if (!kit.value.length) return <Card wide>{t("first_kit")}</Card>;
  const now = second.value;
  const problems = now?.problems ?? [];
  const own = measuredAfter.value.filter((name) => files.value.has(name) && !measured.value.includes(name));
  return (
    <>
      <Card wide>
        {kitState.value !== "current" && <p class="state">{t(`kit_${kitState.value}`)}</p>}
        {now?.judged ? (
          <>
            <p class="head">
              <Verdict of={now.judged.verdict} /> {now.judged.diagnosis?.as_forecast && t("as_forecast")}
            </p>
            <Scope of={now.judged} />
            <Decides judged={now.judged} />
            <Figures judged={now.judged} />
            <Notes of={now.judged.notes} />
          </>
        ) : (
          <>
            <p class="head">{problems.length ? t("problems_count", { count: problems.length }) : t("no_second")}</p>
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
      {isToml(after.value) && files.value.has(after.value) && (
        <details>
          <summary>{after.value}</summary>
          <JobForm file={after.value} problems={problems} />
        </details>
      )}
      {own.map((name) => (
        <Card key={name} title={name} wide>
          <Grid file={name} problems={problems} />
        </Card>
      ))}
      <Card wide>
        <Drop words={t("drop_second")} take={take} />
      </Card>
    </>
  );
}
