// A table put in place of the one that a job names. What is there already keeps its name and its bytes.
import type { Signal } from "@preact/signals";
import { sections, withValue } from "./job";
import { files, isFilled, isSame, notice, put, textOf } from "./visit";
import { t } from "./words";

/** Stores a file without replacing another one; the name that it has now. */
function stored(path: string, content: Uint8Array): string {
  const name = path.slice(path.lastIndexOf("/") + 1);
  const [stem, end] = [name.replace(/\.[^.]*$/, ""), /\.[^.]*$/.exec(name)?.[0] ?? ""];
  for (let n = 1; ; n++) {
    const free = n === 1 ? name : `${stem}-${n}${end}`;
    const old = files.value.get(free);
    if (old && !isSame(old, content) && (isFilled(free) || !/\.csv$/i.test(free))) continue;
    put(free, content);
    return free;
  }
}

export const isTable = (name: string) => /\.(csv|txt|xlsx|xlsm|xls|ods)$/i.test(name);

/** `job` names this table from now on. */
export function withTable(job: Signal<string>, path: string, content: Uint8Array) {
  const text = textOf(job.value);
  const fields = sections(text).filter((one) => one.name === "measurement").flatMap((one) => one.fields);
  const field = fields.find((one) => !one.optional && /^(errors|readings)$/.test(one.key));
  if (!isTable(path) || !field || /^\[/.test(field.value)) {
    notice.value = t("not_taken", { file: path });
    return;
  }
  const name = stored(path, content);
  put(job.value, withValue(text, field, JSON.stringify(name)));
  notice.value = t("taken", { file: name, job: job.value });
}
