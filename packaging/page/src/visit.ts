// The visit on this page: files by name, and what the program says of them.
import { batch, computed, effect, signal } from "@preact/signals";
import schema from "core:";
import list from "core:controllers list --format json";
import { run, type Answer } from "./core";
import { sections, shown, valueOf, withValue, type Key, type Section } from "./job";
import { problems, said, type Problem } from "./problems";
import { claim, kept, look, remember } from "./storage";
import { cells, table } from "./table";
import { language, t } from "./words";

export type Files = ReadonlyMap<string, Uint8Array>;

const decoder = new TextDecoder();
const encoder = new TextEncoder();

export const files = signal<Files>(new Map());
export const job = signal("job.toml");
/** The file of the second measurement: a table, or a job that names readings. */
export const after = signal("after.csv");
/** What has to be said to the person once: nothing could be stored, commas became points … */
export const notice = signal("");

export const begun = computed(() => files.value.has(job.value));

export function textOf(name: string): string {
  const bytes = files.value.get(name);
  return bytes ? decoder.decode(bytes) : "";
}

/** Whether a file is text that can be written back as it is: another encoding than UTF-8 is left alone. */
export function isPlain(name: string): boolean {
  try {
    new TextDecoder("utf-8", { fatal: true }).decode(files.value.get(name));
    return true;
  } catch {
    return false;
  }
}

/** Stores a file. Text of another encoding than UTF-8 is not changed: whoever offers that asks `isPlain` before. */
export function put(name: string, content: string | Uint8Array) {
  if (typeof content === "string" && files.value.has(name) && !isPlain(name)) return;
  const bytes = typeof content === "string" ? encoder.encode(content) : content;
  files.value = new Map(files.value).set(name, bytes);
}

/** Files of a folder, or a single one. */
export function inside(folder: string, all: Iterable<[string, Uint8Array]> = files.value): [string, Uint8Array][] {
  return [...all].filter(([name]) => name.startsWith(`${folder}/`));
}

export const jobText = computed(() => textOf(job.value));
export const isReadings = computed(() => valueOf(jobText.value, "measurement", "readings") !== "");

/** The folder of the visit: of its job, its kit and its second measurement, maybe among others. */
export const home = computed(() => folderOf(job.value));

/** The tables that a job names, one or a list, relative to it. */
function named(text: string): string[] {
  const value = valueOf(text, "measurement", "errors") || valueOf(text, "measurement", "readings");
  if (!value.startsWith("[")) return value ? [value] : [];
  return [...value.matchAll(/"([^"]+)"|'([^']+)'/g)].map((one) => one[1] ?? one[2]!);
}

/** The tables of a job, as they are called here. */
const tablesOf = (name: string) => named(textOf(name)).map((one) => folderOf(name) + one);

/** With its `/`; nothing for what lies beside the job. */
export const folderOf = (name: string) => name.slice(0, name.lastIndexOf("/") + 1);

export const controller = computed(() => valueOf(jobText.value, "compensation", "controller"));
export const measured = computed(() => tablesOf(job.value));
/** The tables of the second measurement. */
export const measuredAfter = computed(() => (isToml(after.value) ? tablesOf(after.value) : [after.value]));

export const isTable = (name: string) => /\.(csv|txt|xlsx|xlsm|xls|ods)$/i.test(name);
export const isToml = (name: string) => /\.toml$/i.test(name);
const text = (all: Files, name: string) => decoder.decode(all.get(name));

/** The jobs among these files; those of second measurements only where there are no others. */
export function jobsIn(all: Files): string[] {
  const jobs = [...all.keys()].filter((name) => isToml(name) && /^\s*\[machine/m.test(text(all, name)));
  const first = jobs.filter((name) => !/(^|\/)after(-\d+)?(\.toml$|\/)/i.test(name));
  return first.length ? first : jobs;
}

/** Files below a folder, by their names from there on. */
const below = (all: Files, folder: string) =>
  new Map([...all].filter(([name]) => name.startsWith(folder)).map(([name, of]) => [name.slice(folder.length), of]));

const climbs = (job: string) => named(job).some((one) => /^(\.\.[/\\]|[/\\]|[a-z]:)/i.test(one));

/** The folder that holds all that a job names: its own one, or one above it for each `../` that a value begins with. */
function rootOf(all: Files, name: string): string {
  const values = sections(text(all, name)).flatMap((one) => one.fields.map((field) => (field.optional ? "" : field.value)));
  const up = values.flatMap((value) => [...value.matchAll(/["']((?:\.\.[/\\]+)*)/g)].map((one) => one[1]!.split("..").length - 1));
  const folders = folderOf(name).split("/").slice(0, -1);
  return folders.slice(0, Math.max(0, folders.length - Math.max(0, ...up))).map((folder) => `${folder}/`).join("");
}

/**
 * A visit begins with this job and what lies beside it, and beside the folders that it names. The second measurement
 * is `after/…toml`, `after.toml` or a table `after`, but no table of the first.
 */
export function open(all: Files, name: string) {
  const root = rootOf(all, name);
  const own = below(all, root);
  const first = name.slice(root.length);
  const at = folderOf(first);
  const tables = named(text(all, name)).map((one) => folderOf(first) + one);
  const isSecond = (one: string) =>
    isToml(one) ? /^\s*\[measurement[\].]/m.test(text(own, one)) : isTable(one) && !/\.txt$/i.test(one) && !tables.includes(one);
  const kinds = [/^after\/[^/]+\.toml$/, /^after\.toml$/, /^after\.csv$/, /^after\.[a-z]+$/];
  const beside = [...below(own, at).keys()];
  const found = kinds.flatMap((kind) => beside.filter((one) => kind.test(one) && isSecond(at + one)).slice(0, 1));
  batch(() => {
    files.value = own;
    job.value = first;
    after.value = at + (found[0] ?? "after.csv");
  });
}

/** Names that nothing has: `after-1.csv`, `after-2/` … for what is called `after.csv`, `after/`. */
function free(all: Files, name: string): string {
  const isTaken = (one: string) => [...all.keys()].some((key) => (one.endsWith("/") ? key.startsWith(one) : key === one));
  for (let n = 1; ; n++) {
    const one = name.replace(/([^./]*)(\.[^/]*|\/)$/, `$1-${n}$2`);
    if (!isTaken(one)) return one;
  }
}

/** A table is the second measurement from now on. A filled one before it is kept under another name; an empty form goes. */
export function putAfter(name: string, content: Uint8Array) {
  const all = new Map(files.value);
  const at = home.value;
  const isBefore = (one: string) => one.startsWith(at) && /^after\.[a-z]+$/.test(one.slice(at.length)) && isTable(one) && !measured.value.includes(one);
  for (const old of [...all.keys()].filter(isBefore)) {
    if (isFilled(old) && !isSame(content, all.get(old))) all.set(free(all, old), all.get(old)!);
    all.delete(old);
  }
  const wanted = `${at}after${/\.[^.]*$/.exec(name)![0].toLowerCase()}`;
  const now = all.has(wanted) ? free(all, wanted) : wanted;
  batch(() => {
    files.value = all.set(now, content);
    after.value = now;
  });
}

/**
 * A job with what lies beside it is the second measurement from now on, in a folder of its own, as it is; only `kit`, where none
 * came along, is the one of this visit. Refused where its tables lie elsewhere.
 */
export function putSecondJob(dropped: Files, name: string): boolean {
  const own = below(dropped, folderOf(name));
  const job = name.slice(folderOf(name).length);
  const words = text(own, job);
  if (climbs(words)) return false;
  const active = sections(words).filter((one) => one.name === "measurement").flatMap((one) => one.fields);
  const field = active.find((one) => one.key === "active_while_measuring" && !one.optional);
  const kitAt = kitFolder.value.slice(home.value.length);
  const isHere = field && shown(field.value) === kitAt && !inside(kitAt, own).length;
  if (isHere) own.set(job, encoder.encode(withValue(words, field, JSON.stringify(`../${kitAt}`))));
  const at = `${home.value}after/`;
  const kept = free(files.value, at);
  const moved = [...files.value].map(([one, of]): [string, Uint8Array] => [one.startsWith(at) ? kept + one.slice(at.length) : one, of]);
  batch(() => {
    files.value = new Map([...moved, ...[...own].map(([one, of]): [string, Uint8Array] => [at + one, of])]);
    after.value = at + job;
  });
  return true;
}

export function clear() {
  batch(() => {
    files.value = new Map();
    job.value = "job.toml";
    after.value = "after.csv";
  });
}

/** What the program makes of the visit as it stands. */
export interface Made {
  problems: Problem[];
  /** The manifest of the kit that it would write; null where nothing is made. */
  manifest: Manifest | null;
  judged: Judged | null;
  kit: [string, Uint8Array][];
  /** Whether the kit that is there holds what its manifest lists, as it was made. */
  isIntact: boolean;
  picture: string;
  volume: Volume | null;
}

export interface Figure {
  before_um: number | null;
  forecast_um?: number | null;
  after_um?: number | null;
  at_most_um: number | null;
}

export interface Act {
  what: string;
  minutes: number | null;
  at_most_um: number;
  verdict: string;
}

export interface Judged {
  verdict: "pass" | "fail" | "undecided";
  /** What was asked, and what the verdict rests on. */
  scope: string[];
  terms: Record<string, Figure>;
  diagonals: Record<string, Figure> | null;
  squareness: Record<string, { before_um_per_m: number }>;
  max_residual_um: number | null;
  max_residual_at_most_um: number | null;
  causes: string[];
  notes: string[];
  what_decides?: { term: string; left_um: number; at_most_um: number; parts: { what: string; um: number }[]; acts: Act[] };
  /** Only with a second measurement. */
  diagnosis?: { as_forecast: boolean } | null;
}

export interface Manifest {
  controller: string;
  files: { path: string; role: string; sha256: string }[];
  assumptions: { fact: string; value: string; consequence: string; without_effect?: string | null }[];
  tables: { term: string; direction: string | null; place: string }[];
}

export interface Vectors {
  places_mm: [number, number, number][];
  um: [number, number, number][];
}

export interface Volume {
  vectors: Vectors;
  after: { vectors: Vectors } | null;
}

export interface Separated {
  errors: Record<string, { position_mm: number[]; deviation_um: number[] }>;
  doubts: string[];
}

export const made = signal<Made | null>(null);
/** The nine errors of readings, as soon as they can be separated. */
export const separated = signal<Separated | null>(null);
export const working = signal(false);

const json = <T,>(answer: Answer): T | null => (answer.status < 2 ? (JSON.parse(answer.out) as T) : null);

/** The folder of the kit; another one where the job names `kit` as active while measuring. */
export const kitFolder = computed(() => {
  const active = valueOf(jobText.value, "measurement", "active_while_measuring").replace(/^\.\/|\/$/g, "");
  return home.value + (active === "kit" ? "kit-2" : "kit");
});

/** Into the checklist people write; every other file of a kit stays as it was made. */
const stays = (file: { role: string }) => file.role !== "checklist";

async function isAsListed(all: Files, kitAt: string, manifest: Manifest | null): Promise<boolean> {
  for (const file of manifest?.files.filter(stays) ?? []) {
    const bytes = all.get(`${kitAt}/${file.path}`) as BufferSource | undefined;
    const hash = bytes ? [...new Uint8Array(await crypto.subtle.digest("SHA-256", bytes))] : [];
    if (hash.map((byte) => byte.toString(16).padStart(2, "0")).join("") !== file.sha256) return false;
  }
  return manifest !== null;
}

async function make(): Promise<Made> {
  const [kitAt, all, old] = [kitFolder.value, files.value, manifest.value];
  const isIntact = await isAsListed(all, kitAt, old);
  // The visit without its kit, which is made anew to be compared.
  const own = [...all].filter(([name]) => !name.startsWith(`${kitAt}/`));
  separated.value = isReadings.value ? json<Separated>(await run(["separate", job.value, "--format", "json"], own)) : null;
  const answer = await run(["generate", job.value, "-o", kitAt, "--format", "json", "--force"], own);
  const now = json<Manifest>(answer);
  if (!now) return { problems: problems(answer), manifest: null, judged: null, kit: [], isIntact, picture: "", volume: null };
  const kit = inside(kitAt, answer.files);
  // Judged is the kit that is there, as it stands; before there is one for this control, that which would be made.
  const isThere = inside(kitAt, all).length > 0 && (!old || old.controller === now.controller);
  const judgedWith = isThere ? all : [...own, ...kit];
  const verified = await run(["verify", job.value, "--tables", kitAt, "--format", "json", "--plot", "plot.svg", "--force"], judgedWith);
  const assessed = await run(["assess", job.value, "--tables", kitAt, "--vectors", "--grid", "4,4,4", "--format", "json"], judgedWith);
  return {
    problems: problems(verified),
    manifest: now,
    judged: json<Judged>(verified),
    kit,
    isIntact,
    picture: decoder.decode(new Map(verified.files).get("plot.svg")),
    volume: json<Volume>(assessed),
  };
}

/** The kit of the visit, as it was made last and goes to the machine. */
export const kit = computed(() => inside(kitFolder.value));
/** The manifest of the kit that is there. */
export const manifest = computed(() => {
  try {
    const of = JSON.parse(textOf(`${kitFolder.value}/manifest.json`)) as Manifest;
    return Array.isArray(of.files) ? of : null;
  } catch {
    return null; // none, or a damaged one: the program says so
  }
});
/**
 * What there is to say of the kit that is there: of another control than one that the program would make now, the same as that,
 * no more as it was made, or as it was made of another job.
 */
export const kitState = computed((): "none" | "foreign" | "current" | "changed" | "old" => {
  const [now, of] = [made.value, new Map(kit.value)];
  if (!of.size) return "none";
  if (now?.manifest && manifest.value && manifest.value.controller !== now.manifest.controller) return "foreign";
  const written = now?.manifest?.files.filter((file) => !stays(file)).map((file) => `${kitFolder.value}/${file.path}`);
  const isOwn = kit.value.every(([name]) => now?.kit.some(([own]) => own === name));
  if (isOwn && now?.kit.length && now.kit.every(([name, bytes]) => written?.includes(name) || isSame(bytes, of.get(name)))) return "current";
  return now && !now.isIntact ? "changed" : "old";
});

export function isSame(one: Uint8Array, other: Uint8Array | undefined): boolean {
  return one.length === other?.length && one.every((byte, n) => byte === other[n]);
}

/** Makes the kit; one that is there is kept as `kit.previous`, as the program does. */
export async function makeKit() {
  const begun = performance.now();
  const kitAt = kitFolder.value;
  const isKit = (name: string) => name.startsWith(`${kitAt}/`) || name.startsWith(`${kitAt}.previous`);
  const answer = await run(["generate", job.value, "-o", kitAt, "--force"], files.value);
  performance.measure("kit", { start: begun });
  if (answer.status < 2) {
    // Only what was made: the job may have been changed meanwhile.
    const others = [...files.value].filter(([name]) => !isKit(name));
    files.value = new Map([...others, ...answer.files.filter(([name]) => isKit(name))]);
  }
  return answer;
}

export interface Second {
  problems: Problem[];
  judged: Judged | null;
  picture: string;
}

export const second = signal<Second | null>(null);

/** Whether the second measurement is nothing but the forms that `new` wrote. */
const isEmpty = () => measuredAfter.value.length > 0 && measuredAfter.value.every((name) => files.value.has(name) && !isFilled(name));

async function judge(): Promise<Second | null> {
  if (!kit.value.length || !files.value.has(after.value) || isEmpty() || measuredAfter.value.some((name) => measured.value.includes(name))) return null;
  const asked = ["verify", job.value, "--tables", kitFolder.value, "--after", after.value, "--format", "json", "--plot", "plot.svg", "--force"];
  const answer = await run(asked, files.value);
  return {
    problems: problems(answer),
    judged: json<Judged>(answer),
    picture: decoder.decode(new Map(answer.files).get("plot.svg") ?? new Uint8Array()),
  };
}

/** Whether a table holds values, and not only what `new` wrote. */
export function isFilled(name: string): boolean {
  const bytes = files.value.get(name);
  if (!bytes) return false;
  if (!name.endsWith(".csv")) return true;
  const of = table(decoder.decode(bytes));
  if (!of) return true;
  const values = of.names.flatMap((column, n) => (/^(axis|position|target|diagonal|direction|node|moved|run)/i.test(column) ? [] : [n]));
  return of.rows.some((line) => values.some((n) => cells(of, line)[n]?.trim()));
}

/**
 * A table as a job takes it; of a spreadsheet with the columns of an error table the CSV that the program makes of it. Any other one
 * is refused here, with what the program says of it.
 */
export async function asTable(path: string, content: Uint8Array, takesErrors = true): Promise<[string, Uint8Array] | null> {
  const name = path.slice(path.lastIndexOf("/") + 1);
  if (!/\.(xls[xm]?|ods)$/i.test(name)) return [name, content];
  const csv = name.replace(/[^.]*$/, "csv");
  // What is understood of it has to be that each column is what it is called.
  const isOwn = (words: string) => /--columns "(\w+)=\1(,(\w+)=\3)*"/.test(words);
  const words = ["import", name, "-o", csv, "--sign", "as-error", "--yes", "--format", "json"];
  const answer = takesErrors ? await run(words, [[name, content]]) : null;
  const found = answer && json<{ facts: string[] }>(answer);
  const made = found?.facts.some(isOwn) && new Map(answer?.files).get(csv);
  if (made) return [csv, made];
  notice.value = t("sheet", { file: name, why: answer ? problems(answer).map(said).join("; ") : "" }).trim();
  return null;
}

/** The page that is handed over, in the language of this page. */
export async function report(withAfter: boolean): Promise<string> {
  const words = ["report", job.value, "--language", language.value, "-o", "report.html", "--force"];
  if (kit.value.length) words.push("--tables", kitFolder.value);
  if (withAfter) words.push("--after", after.value);
  const answer = await run(words, files.value);
  const page = new Map(answer.files).get("report.html");
  return answer.status < 2 && page ? decoder.decode(page) : `<pre>${answer.err.replace(/[&<]/g, (one) => `&#${one.charCodeAt(0)};`)}</pre>`;
}

export interface Control {
  id: string;
  name: string;
}

export const controls: Control[] = JSON.parse(list.out).controllers;
export const keys: Key[] = JSON.parse(schema.out);
/** What this control says of keys of the job, by `section.key`. */
export const hints = signal<Map<string, string>>(new Map());

/** Runs the newest question once the one before is answered. */
function latest(ask: () => Promise<void>) {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let busy = false;
  let again = false;
  const go = async () => {
    if (busy) {
      again = true;
      return;
    }
    busy = working.value = true;
    try {
      await ask();
    } catch (fault) {
      made.value = second.value = null; // nothing old beside what is new
      notice.value = String(fault);
    }
    busy = false;
    working.value = again;
    if (again) {
      again = false;
      await go();
    }
  };
  return () => {
    working.value = true;
    clearTimeout(timer);
    timer = setTimeout(go, 120);
  };
}

const makeLatest = latest(async () => {
  made.value = begun.value ? await make() : null;
  if (!begun.value) separated.value = null;
  second.value = begun.value ? await judge() : null;
});

export async function start() {
  const old = await kept();
  if (old) {
    batch(() => {
      language.value = old.language ?? language.value;
      files.value = old.files;
      job.value = old.job;
      after.value = old.after;
    });
  }
  effect(() => {
    files.value, job.value, after.value;
    makeLatest();
  });
  await claim();
  addEventListener("focus", () => void look());
  effect(() => void remember({ files: files.value, job: job.value, after: after.value, language: language.value }));
  effect(() => {
    const id = controller.value;
    hints.value = new Map();
    if (!controls.some((one) => one.id === id)) return;
    void run(["controllers", "show", id, "--format", "json"]).then((answer) => {
      const told: { section: string; key: string; text: string }[] = JSON.parse(answer.out).job ?? [];
      hints.value = new Map(told.map((one) => [`${one.section}.${one.key}`, one.text]));
    });
  });
}

/** The keys of a section that the schema knows; those of X, Y and Z are the same. */
const known = (section: string) => keys.filter((one) => one.section.replace(/\.x$/, "") === section.replace(/\.[xyz]$/, ""));
const keyOf = (section: string, key: string) => known(section).find((one) => one.key === key);

/** What is known of a key: the words of this control, or of the schema. */
export function wordsOf(section: string, key: string): string {
  return hints.value.get(`${section.replace(/\.[xyz]$/, "")}.${key}`) ?? keyOf(section, key)?.words ?? "";
}

export function isText(section: string, key: string): boolean {
  return /^(Option<)?String>?$/.test(keyOf(section, key)?.type ?? "") || /e\.g\. "/.test(wordsOf(section, key));
}

/** Keys that the schema knows and a section does not have. */
export function absent(section: Section): Key[] {
  return known(section.name).filter((one) => !section.fields.some((field) => field.key === one.key));
}
