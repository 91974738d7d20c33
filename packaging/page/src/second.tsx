// After loading: the second measurement, its verdict with causes, the page to sign.
import { Decides, Figures } from "./figures";
import { JobForm } from "./form";
import { Grid } from "./grid";
import { ReportPage } from "./kit";
import { Card, Drop, Notes, Picture, Problems, Scope, Verdict } from "./ui";
import { after, files, isCurrent, kit, measuredAfter, notice, putAfter, second, type Files } from "./visit";
import { isTable, withTable } from "./measured";
import { t } from "./words";

/** A job comes before the tables that it names. */
function take(dropped: Files) {
  const isJob = ([name]: [string, Uint8Array]) => /\.toml$/i.test(name);
  for (const [name, content] of [...dropped].sort((a, b) => Number(isJob(b)) - Number(isJob(a)))) {
    if (!isJob([name, content]) && after.value.endsWith(".toml")) withTable(after, name, content);
    else if (isJob([name, content]) || isTable(name)) {
      putAfter(name, content);
      notice.value = t("taken", { file: after.value, job: name });
    } else notice.value = t("not_taken", { file: name });
  }
}

export function SecondStep() {
  if (!kit.value.length) return <Card wide>{t("first_kit")}</Card>;
  const now = second.value;
  const problems = now?.problems ?? [];
  return (
    <>
      <Card wide>
        {!isCurrent.value && <p class="state">{t("kit_old")}</p>}
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
      {after.value.endsWith(".toml") && files.value.has(after.value) && (
        <details>
          <summary>{after.value}</summary>
          <JobForm file={after.value} problems={problems} />
        </details>
      )}
      {measuredAfter.value.filter((name) => files.value.has(name)).map((name) => (
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
