// A job as its own form: each line `key = value  # what it is` is a field; the text stays what its writer made of it.

export interface Field {
  /** Index of its line, and of the last one of a value over several lines. */
  line: number;
  last: number;
  key: string;
  /** As it stands in the text. */
  value: string;
  words: string;
  /** Behind a `# `: it does not count until it is filled in; the value is an example. */
  optional: boolean;
  /** Over several lines: only as text. */
  isLong: boolean;
}

export interface Section {
  /** As in the text: `machine.axes.x`; empty above the first header. */
  name: string;
  /** `[[name]]`: one of several. */
  many: boolean;
  /** Index of its header; −1 above the first. */
  line: number;
  intro: string;
  fields: Field[];
  /** Index of its last line that holds something. */
  last: number;
}

/** A key of the schema: what it says, and whether it takes a text. */
export interface Key {
  section: string;
  key: string;
  words: string;
  type: string;
}

const KEY = /^(# )?(\s*)([A-Za-z_][\w.]*)\s*=\s*/;
/** How an example behind a `# ` begins; other remarks hold an equal sign, too. */
const EXAMPLE = /^# \w+ = ["'\d+\-[{tf]/;

/** End of the value that begins at `at`: what follows is a comment, or nothing. `depth` of open brackets goes on. */
function ended(line: string, at: number, brackets = { depth: 0 }): number {
  let quote = "";
  for (let n = at; n < line.length; n++) {
    const letter = line[n]!;
    if (quote) {
      if (letter === "\\" && quote === '"') n++;
      else if (letter === quote) quote = "";
    } else if (letter === '"' || letter === "'") quote = letter;
    else if (letter === "#") return n;
    else if ("[{".includes(letter)) brackets.depth++;
    else if ("]}".includes(letter)) brackets.depth--;
  }
  return line.length;
}

export function sections(job: string): Section[] {
  const found: Section[] = [{ name: "", many: false, line: -1, intro: "", fields: [], last: -1 }];
  let intro: string[] = [];
  const brackets = { depth: 0 };
  job.split("\n").forEach((raw, line) => {
    const text = raw.replace(/\r$/, "");
    if (brackets.depth > 0) {
      const field = found.at(-1)!.fields.at(-1)!;
      field.value += text.slice(0, ended(text, 0, brackets)).trim();
      found.at(-1)!.last = field.last = line;
      return;
    }
    brackets.depth = 0;
    const header = /^\s*(\[\[?)([^\]]+)\]\]?\s*(?:#\s*(.*))?$/.exec(text);
    const key = !text.startsWith("#") || EXAMPLE.test(text) ? KEY.exec(text) : null;
    const section = found.at(-1)!;
    if (header) {
      const words = [...intro, header[3] ?? ""].filter(Boolean).join(" ");
      found.push({ name: header[2]!.trim(), many: header[1] === "[[", line, intro: words, fields: [], last: line });
      intro = [];
    } else if (key) {
      section.last = line;
      const isOptional = key[1] !== undefined;
      const end = ended(text, key[0].length, isOptional ? undefined : brackets);
      section.fields.push({
        line,
        last: line,
        key: key[3]!,
        value: text.slice(key[0].length, end).trim(),
        words: text.slice(end).replace(/^#\s*/, "").trim(),
        optional: isOptional,
        isLong: !isOptional && brackets.depth > 0,
      });
      intro = [];
    } else if (/^# \[/.test(text) || text.trim() === "") intro = [];
    else if (text.startsWith("# ")) intro.push(text.slice(2));
  });
  return found.filter((section) => section.fields.length > 0 && section.name !== "");
}

/** Sections side by side: the same keys of X, Y and Z, or of several blocks. */
export interface Group {
  /** What they share: `machine.axes`. */
  name: string;
  intro: string;
  columns: Section[];
}

export function groups(all: Section[]): Group[] {
  const found: Group[] = [];
  for (const section of all) {
    const name = section.name.replace(/\.[xyz]$/, "");
    const last = found.at(-1);
    const beside = section.many || name !== section.name;
    if (last && beside && last.name === name) last.columns.push(section);
    else found.push({ name, intro: section.intro, columns: [section] });
  }
  return found;
}

/** What a value shows of itself: a text without its quotes, nothing for `""`. */
export function shown(value: string): string {
  if (/^'[^']*'$/.test(value)) return value.slice(1, -1);
  if (!/^"(?:[^"\\]|\\.)*"$/.test(value)) return value;
  try {
    return JSON.parse(value);
  } catch {
    return value;
  }
}

/** What was typed, as it stands in a job. */
export function written(typed: string, isText: boolean): string {
  const value = typed.trim();
  if (/^"(?:[^"\\]|\\.)*"$/.test(value)) return value;
  const brackets = { depth: 0 };
  const isWhole = ended(value, 0, brackets) === value.length && brackets.depth === 0;
  const isBare = /^[-+]?\d+(\.\d+)?([eE][-+]?\d+)?$/.test(value) || /^(true|false|\[.*\]|\{.*\})$/.test(value);
  return isBare && isWhole && !isText ? value : JSON.stringify(typed);
}

/** The job with another value in a line. */
export function withValue(job: string, field: Field, value: string): string {
  const lines = job.split("\n");
  const was = lines[field.line]!;
  const key = KEY.exec(was)!;
  const end = ended(was, key[0].length);
  const comment = was.slice(end).trim();
  const bare = `${key[2]}${field.key} = ${value}`;
  const line = comment ? `${bare.padEnd(Math.max(35, bare.length + 1))} ${comment}` : bare;
  lines[field.line] = was.endsWith("\r") ? `${line}\r` : line;
  return lines.join("\n");
}

/** The job with a proposed field to be filled in; its example goes behind it. */
export function withProposed(job: string, field: Field): string {
  const lines = withValue(job, field, '""').split("\n");
  const [line, end] = /^(.*?)(\r?)$/.exec(lines[field.line]!)!.slice(1);
  if (!field.words.includes(field.value)) lines[field.line] = `${line}${field.words ? "," : " #"} e.g. ${field.value}${end}`;
  return lines.join("\n");
}

/** The job without what a field says, which stays as a proposal. */
export function without(job: string, field: Field): string {
  const lines = job.split("\n");
  for (let n = field.line; n <= field.last; n++) lines[n] = `# ${lines[n]}`;
  return lines.join("\n");
}

/** The job with a key more in a section. */
export function withKey(job: string, section: Section, key: string, value: string): string {
  const lines = job.split("\n");
  lines.splice(section.last + 1, 0, `${key} = ${value}`);
  return lines.join("\n");
}

/** The job without a block `[[…]]`. */
export function withoutBlock(job: string, section: Section): string {
  const lines = job.split("\n");
  lines.splice(section.line, section.last - section.line + 1);
  return lines.join("\n");
}

/** A value of the job, as text; nothing where it is absent or empty. */
export function valueOf(job: string, section: string, key: string): string {
  const of = sections(job).filter((one) => one.name === section);
  const field = of.flatMap((one) => one.fields).find((one) => one.key === key && !one.optional);
  return field ? shown(field.value) : "";
}

/** The values that the words of a key offer: `"mm" or "inch"`, `1 or 2:`, `true or false`. */
export function choices(words: string): string[] {
  const quoted = /^((?:"[^"]+"(?:,| or|, or)? ?)+)/.exec(words)?.[1];
  const texts = quoted ? [...quoted.matchAll(/"([^"]+)"/g)].map((one) => one[1]!) : [];
  if (texts.length > 1) return texts;
  const plain = /^(true|1) or (false|2)\b/.exec(words);
  return plain ? [plain[1]!, plain[2]!] : [];
}
