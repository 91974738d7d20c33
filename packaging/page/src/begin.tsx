// The first step: a control and its travel, or files of a visit.
import sampleAfterReadings from "../../../fixtures/start/readings/after.csv?raw";
import sampleAfter from "../../../fixtures/start/readings/after.toml?raw";
import sampleJob from "../../../fixtures/start/readings/job.toml?raw";
import sampleReadings from "../../../fixtures/start/readings/readings.csv?raw";
import { signal } from "@preact/signals";
import { useState } from "preact/hooks";
import { run } from "./core";
import { problems, type Problem } from "./problems";
import { step } from "./steps";
import { Card, Drop, Problems } from "./ui";
import { begun, clear, controls, job, jobsIn, notice, open, type Files } from "./visit";
import { withTable } from "./measured";
import { t } from "./words";

const sample = new Map(
  Object.entries({ "job.toml": sampleJob, "readings.csv": sampleReadings, "after.toml": sampleAfter, "after.csv": sampleAfterReadings }).map(
    ([name, text]) => [name, new TextEncoder().encode(text)],
  ),
);

/** Files with several jobs, of which the person takes one. */
const several = signal<Files | null>(null);

function begin(files: Files, name: string) {
  open(files, name);
  several.value = null;
  step.value = "result";
}

async function take(dropped: Files) {
  const jobs = jobsIn(dropped);
  if (jobs.length > 1) several.value = dropped;
  else if (jobs[0]) begin(dropped, jobs[0]);
  else if (begun.value) await withTable(job, dropped);
  else notice.value = t("begin_first");
}

function Begin() {
  const [control, setControl] = useState("siemens-840d-sl");
  const [travel, setTravel] = useState({ x: "", y: "", z: "" });
  const [readings, setReadings] = useState(false);
  const [both, setBoth] = useState(false);
  const [told, setTold] = useState<Problem[]>([]);
  const make = async (event: Event) => {
    event.preventDefault();
    const ends = [travel.x, travel.y, travel.z].map((end) => end.trim().replaceAll("−", "-")).join(",");
    const words = ["new", "--controller", control, `--travel=${ends}`, "-o", "visit"];
    if (readings) words.push("--readings");
    if (both) words.push("--both-directions");
    const answer = await run(words);
    // Usage can be wrong in the travel only: all else was chosen.
    setTold(answer.status === 2 && !answer.told.problems?.length ? [{ words: t("travel_wrong"), places: [], help: "" }] : problems(answer));
    if (answer.status !== 0) return;
    several.value = null;
    open(new Map(answer.files), "visit/job.toml");
    step.value = "job";
  };
  return (
    <form class="begin" onSubmit={make}>
      <label>
        {t("control")}
        <select value={control} onChange={(event) => setControl(event.currentTarget.value)}>
          {controls.map((one) => (
            <option value={one.id}>{one.name}</option>
          ))}
        </select>
      </label>
      <fieldset>
        <legend>{t("travel")}</legend>
        <div class="three">
          {(["x", "y", "z"] as const).map((axis) => (
            <label>
              {axis.toUpperCase()}
              <input
                required
                autocomplete="off"
                value={travel[axis]}
                onInput={(event) => setTravel({ ...travel, [axis]: event.currentTarget.value })}
              />
            </label>
          ))}
        </div>
        <p class="soft">{t("travel_hint")}</p>
      </fieldset>
      <fieldset>
        <legend>{t("measured_as")}</legend>
        <label class="choice">
          <input type="radio" name="what" checked={!readings} onChange={() => setReadings(false)} />
          {t("measured_errors")}
        </label>
        <label class="choice">
          <input type="radio" name="what" checked={readings} onChange={() => setReadings(true)} />
          {t("measured_readings")}
        </label>
        <label class="choice">
          <input type="checkbox" checked={both} onChange={(event) => setBoth(event.currentTarget.checked)} />
          {t("both_directions")}
        </label>
      </fieldset>
      <Problems of={told} />
      <button class="main">{t("begin_button")}</button>
    </form>
  );
}

export function BeginStep() {
  // Files that wait until the visit on the page may go; none = only that.
  const [waiting, setWaiting] = useState<Files | null>(null);
  if (begun.value) {
    const isVisit = (files: Files) => jobsIn(files).length > 0;
    return (
      <Card title={t("anew")}>
        {waiting ? (
          <>
            <p class="told">{t("anew_sure")}</p>
            <div class="buttons">
              <button
                type="button"
                class="bad"
                onClick={() => {
                  clear();
                  if (waiting.size) take(waiting);
                  setWaiting(null);
                }}
              >
                {t("remove")}
              </button>
              <button type="button" onClick={() => setWaiting(null)}>
                {t("cancel")}
              </button>
            </div>
          </>
        ) : (
          <button type="button" onClick={() => setWaiting(new Map())}>
            {t("anew")}
          </button>
        )}
        <Drop words={t("drop")} folder take={(dropped) => (isVisit(dropped) ? setWaiting(dropped) : take(dropped))} />
      </Card>
    );
  }
  return (
    <>
      <p class="wide promise">{t("promise")}</p>
      <Card title={t("begin")}>
        <Begin />
      </Card>
      <Card title={t("or_open")}>
        <Drop words={t("drop")} folder take={take} />
        {several.value && (
          <>
            <p>{t("several_jobs")}</p>
            <div class="buttons">
              {jobsIn(several.value).map((name) => (
                <button type="button" onClick={() => begin(several.value!, name)}>
                  {name}
                </button>
              ))}
            </div>
          </>
        )}
        <p>
          <button type="button" class="main" onClick={() => take(sample)}>
            {t("try_it")}
          </button>
        </p>
      </Card>
    </>
  );
}
