// The frame of the page: steps, verdict, language.
import packed from "licences:";
import type { JSX } from "preact";
import { useEffect, useState } from "preact/hooks";
import { BeginStep } from "./begin";
import { JobForm, openKeys } from "./form";
import { KitStep, saveVisit } from "./kit";
import { MeasurementStep } from "./measurement";
import { ResultStep } from "./result";
import { SecondStep } from "./second";
import { step, steps, type Step } from "./steps";
import { keeps } from "./storage";
import { Verdict } from "./ui";
import { begun, files, isFilled, job, jobText, kitState, made, measured, notice, second, working } from "./visit";
import { unpacked } from "./unpacked";
import { language, languages, t } from "./words";

const faults = (file: string) => made.value?.problems.some((problem) => problem.places.some((place) => place.file === file));

const mark = (isGood: boolean) => (isGood ? "✓" : "!");

/** A word about each step: what waits there, or that it is done. */
function state(of: Step): string {
  switch (of) {
    case "machine":
      return begun.value ? "✓" : "";
    case "job": {
      const waiting = openKeys(jobText.value);
      const isFaulty = made.value?.problems.some((problem) => !problem.places.length) || faults(job.value);
      return waiting ? String(waiting) : !begun.value ? "" : isFaulty ? "!" : "✓";
    }
    case "measurement":
      if (measured.value.some((name) => !files.value.has(name))) return "!";
      return !begun.value || !measured.value.some(isFilled) ? "" : measured.value.some(faults) ? "!" : "✓";
    case "result":
      return made.value?.judged ? mark(made.value.judged.verdict === "pass") : "";
    case "kit":
      return kitState.value === "none" ? "" : mark(kitState.value === "current");
    case "second":
      return second.value ? mark(second.value.judged?.verdict === "pass") : "";
  }
}

const shown: Record<Step, () => JSX.Element> = {
  machine: BeginStep,
  job: () => <JobForm file={job.value} problems={made.value?.problems ?? []} />,
  measurement: MeasurementStep,
  result: ResultStep,
  kit: KitStep,
  second: SecondStep,
};

function Licences() {
  const [text, setText] = useState("");
  return (
    <footer>
      <details onToggle={() => void new Response(unpacked(packed)).text().then(setText)}>
        <summary>{t("licences")}</summary>
        <pre tabIndex={0}>{text}</pre>
      </details>
    </footer>
  );
}

function walk(to: Step) {
  step.value = to;
  scrollTo(0, 0);
}

export function App() {
  const next = steps[steps.indexOf(step.value) + 1];
  useEffect(() => void (notice.value = ""), [step.value]);
  const Now = shown[step.value];
  const judged = second.value?.judged ?? made.value?.judged;
  document.documentElement.lang = language.value;
  return (
    <>
      <header>
        <h1>nonius</h1>
        <span class="now" aria-live="polite">
          {working.value ? <span class="soft">{t("working")}</span> : judged && (
            <>
              {second.value?.judged && `${t("left")}: `}
              {second.value && !second.value.judged && `${t("left")}: ${t("problems_count", { count: second.value.problems.length })} `}
              <Verdict of={judged.verdict} forecast={!second.value?.judged} />
            </>
          )}
        </span>
        {begun.value && (
          <button type="button" onClick={saveVisit}>
            {t("save_visit")}
          </button>
        )}
        <select aria-label="Language" value={language.value} onChange={(event) => (language.value = event.currentTarget.value)}>
          {languages.map((one) => (
            <option value={one}>{{ en: "English", de: "Deutsch", zh: "中文" }[one]}</option>
          ))}
        </select>
      </header>
      <nav aria-label="nonius">
        {steps.map((one, n) => (
          <button
            type="button"
            id={`step-${one}`}
            aria-current={step.value === one ? "step" : undefined}
            disabled={one !== "machine" && !begun.value}
            onClick={() => walk(one)}
          >
            <span>{n + 1}</span> {t(`step_${one}`)} <em>{state(one)}</em>
          </button>
        ))}
      </nav>
      {keeps.value !== "here" && <p class="notice">{t(`kept_${keeps.value}`)}</p>}
      {notice.value && (
        <p class="notice" role="status">
          {notice.value}{" "}
          <button type="button" class="small" onClick={() => (notice.value = "")}>
            ✕
          </button>
        </p>
      )}
      <main class={working.value ? "stale" : ""} aria-busy={working.value}>
        <Now />
        {begun.value && next && (
          <p class="wide">
            <button type="button" onClick={() => walk(next)}>
              {t(`step_${next}`)} →
            </button>
          </p>
        )}
      </main>
      <Licences />
    </>
  );
}
