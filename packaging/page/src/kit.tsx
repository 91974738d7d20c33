// The files for the control, the checklist and the report.
import { useEffect, useState } from "preact/hooks";
import { valueOf } from "./job";
import { save, zip } from "./opened";
import { problems, type Problem } from "./problems";
import { Card, Framed, Problems } from "./ui";
import { files, jobText, kit, kitFolder, kitState, made, makeKit, manifest, report } from "./visit";
import { language, t } from "./words";

const decoder = new TextDecoder();

export function saveVisit() {
  const name = valueOf(jobText.value, "machine", "name").replace(/[^\p{L}\p{N}.-]+/gu, "-") || "visit";
  save(`${name}.zip`, zip([...files.value].map(([name, of]) => [`visit/${name}`, of])), "application/zip");
}

/** The report as the program writes it, in the language of the page. */
export function ReportPage(props: { withAfter: boolean; name: string }) {
  const [page, setPage] = useState("");
  const words = language.value;
  const of = files.value;
  useEffect(() => {
    const timer = setTimeout(() => void report(props.withAfter).then(setPage), 400);
    return () => clearTimeout(timer);
  }, [words, of, props.withAfter]);
  return page ? <Framed html={page} title={t("report")} name={props.name} /> : null;
}

function Content(props: { name: string; bytes: Uint8Array; role: string }) {
  const words = t(`role_${props.role}`);
  return (
    <details class="file">
      <summary>
        <code>{props.name}</code> <span class="soft">{words.startsWith("role_") ? "" : words}</span>
      </summary>
      {/\.html?$/i.test(props.name) ? null : <pre tabIndex={0}>{decoder.decode(props.bytes)}</pre>}
      <button type="button" onClick={() => save(props.name, props.bytes)}>
        {t("download")}
      </button>
    </details>
  );
}

export function KitStep() {
  const [told, setTold] = useState<Problem[]>([]);
  const state = kitState.value;
  const isMade = state !== "none";
  const make = async () => setTold(problems(await makeKit()));
  // Of the kit that is there, not of one that would be made now.
  const of = manifest.value ?? made.value?.manifest;
  const roles = new Map(of?.files.map((file) => [file.path, file.role]));
  const checklist = new Map(kit.value).get(`${kitFolder.value}/checklist.html`);
  const inKit = (name: string) => name.slice(kitFolder.value.length + 1);
  const assumed = (of?.assumptions ?? []).filter((one) => !one.without_effect);
  return (
    <>
      <Card wide>
        <p class="head">
          <span class={isMade ? `state ${state}` : ""}>{t(`kit_${state}`)}</span>
        </p>
        <Problems of={told} />
        <div class="buttons">
          {state !== "current" && (
            <button type="button" class="main" disabled={!made.value?.manifest} onClick={make}>
              {t(isMade ? "make_anew" : "make_kit", { folder: kitFolder.value })}
            </button>
          )}
          {(state === "current" || state === "old") && (
            <button type="button" class="main" onClick={() => save("kit.zip", zip(kit.value), "application/zip")}>
              {t("download_kit")}
            </button>
          )}
        </div>
        <Problems of={made.value?.problems ?? []} />
        {assumed.length > 0 && (
          <details>
            <summary>
              {t("assumptions")} ({assumed.length})
            </summary>
            <ul>
              {assumed.map((one) => (
                <li>
                  <code>
                    {one.fact} = {one.value}
                  </code>
                  . {t("if_wrong")}: {one.consequence}
                </li>
              ))}
            </ul>
          </details>
        )}
        {kit.value.map(([name, bytes]) => (
          <Content name={inKit(name)} bytes={bytes} role={roles.get(inKit(name)) ?? ""} />
        ))}
      </Card>
      {checklist && (
        <Card title={t("checklist")} wide>
          <Framed html={decoder.decode(checklist)} title={t("checklist")} name="checklist.html" />
        </Card>
      )}
      {isMade && (
        <Card title={t("report")} wide>
          <ReportPage withAfter={false} name="report.html" />
        </Card>
      )}
    </>
  );
}
