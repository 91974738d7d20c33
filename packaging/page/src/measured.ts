// A table put in place of the one that a job names. What is there already keeps its name and its bytes.
import type { Signal } from "@preact/signals";
import { sections, shown, withValue } from "./job";
import { asTable, files, folderOf, home, isFilled, isPlain, isSame, isTable, notice, put, textOf, type Files } from "./visit";
import { t } from "./words";

/** Stores a file in a folder without replacing another one; the name that it has there. */
function stored(folder: string, path: string, content: Uint8Array): string {
  const name = path.slice(path.lastIndexOf("/") + 1);
  const [stem, end] = [name.replace(/\.[^.]*$/, ""), /\.[^.]*$/.exec(name)?.[0] ?? ""];
  for (let n = 1; ; n++) {
    const free = n === 1 ? name : `${stem}-${n}${end}`;
    const old = files.value.get(folder + free);
    if (!old && folder === home.value && /^after\./.test(free)) continue; // a name of the second measurement
    if (old && !isSame(old, content) && (isFilled(folder + free) || !/\.csv$/i.test(free))) continue;
    put(folder + free, content);
    return free;
  }
}

/** `job` names this table from now on; of several a person has to choose. */
export async function withTable(job: Signal<string>, dropped: Files) {
  const [first] = dropped;
  if (!first || dropped.size > 1) {
    notice.value = t("one_table");
    return;
  }
  const [path] = first;
  const text = textOf(job.value);
  const fields = sections(text).filter((one) => one.name === "measurement").flatMap((one) => one.fields);
  const field = fields.find((one) => !one.optional && /^(errors|readings)$/.test(one.key));
  if (!isTable(path) || !field || /^\[/.test(field.value) || !isPlain(job.value)) {
    notice.value = t("not_taken", { file: path });
    return;
  }
  const table = await asTable(...first, field.key === "errors");
  if (!table) return;
  const folder = folderOf(job.value);
  const old = shown(field.value);
  const name = stored(folder, ...table);
  put(job.value, withValue(text, field, JSON.stringify(name)));
  const kept = old !== name && isFilled(folder + old) ? t("kept_table", { file: old }) : "";
  notice.value = [t("taken", { file: name, job: job.value }), kept].filter(Boolean).join(" ");
}
