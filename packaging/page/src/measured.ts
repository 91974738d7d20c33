// A table put in place of the one that a job names.
import type { Signal } from "@preact/signals";
import { sections, withValue } from "./job";
import { put, textOf } from "./visit";

/** `job` names this table from now on; one of the same kind takes the name of the old one. */
export function withTable(job: Signal<string>, name: string, content: Uint8Array) {
  const text = textOf(job.value);
  const measurement = sections(text).find((one) => one.name === "measurement");
  const isReadings = /\.csv$/i.test(name) && /^(?!#)\s*diagonal\s*[,;]/im.test(new TextDecoder().decode(content.slice(0, 4096)));
  const field = measurement?.fields.find((one) => !one.optional && one.key === (isReadings ? "readings" : "errors"))
    ?? measurement?.fields.find((one) => !one.optional && /^(errors|readings)$/.test(one.key));
  const bare = name.slice(name.lastIndexOf("/") + 1);
  put(bare, content);
  if (field) put(job.value, withValue(text, field, JSON.stringify(bare)));
}
