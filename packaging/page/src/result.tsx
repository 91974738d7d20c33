// What the tables would leave: verdict, figures, what decides, pictures.
import { Decides, Figures } from "./figures";
import { step } from "./steps";
import { Card, Notes, Picture, Problems, Scope, Verdict } from "./ui";
import { kitState, made, manifest as manifestThere } from "./visit";
import { VolumeView } from "./volume";
import { figure, t } from "./words";

export function ResultStep() {
  const now = made.value;
  if (!now?.judged || !now.manifest) {
    return (
      <Card title={t("not_yet")} wide>
        <p>{t("see_problems")}</p>
        <Problems of={now?.problems ?? []} />
        <button type="button" onClick={() => (step.value = "job")}>
          {t("step_job")}
        </button>
      </Card>
    );
  }
  const { judged } = now;
  const state = kitState.value;
  const manifest = (state !== "foreign" && manifestThere.value) || now.manifest;
  return (
    <>
      <Card wide>
        <p class="head">
          <Verdict of={judged.verdict} forecast />
        </p>
        {state !== "none" && state !== "current" && <p class="state">{t(`kit_${state}`)}</p>}
        <Scope of={judged} />
        <Decides judged={judged} />
        <Figures judged={judged} manifest={manifest} />
        <p class="soft">{t("names")}</p>
        {Object.keys(judged.squareness ?? {}).length > 0 && (
          <p>
            {t("squareness")}, µm/m:{" "}
            {Object.entries(judged.squareness)
              .map(([plane, one]) => `${plane.toUpperCase()} ${figure(one.before_um_per_m, 2)}`)
              .join(" · ")}
            . <span class="soft">{t("squareness_sign")}</span>
          </p>
        )}
        <Notes of={judged.notes} />
      </Card>
      <Card title={t("curves")} wide>
        <Picture svg={now.picture} />
      </Card>
      {now.volume?.vectors && (
        <Card title={t("volume")} wide>
          <VolumeView of={now.volume} />
        </Card>
      )}
    </>
  );
}
