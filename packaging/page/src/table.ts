// A table of values (CSV) as a grid: lines stay as they are until a cell of theirs is changed.

export interface Table {
  lines: string[];
  /** Line ends, as the file has them. */
  ends: string;
  /** Index of the header's line. */
  header: number;
  separator: string;
  names: string[];
  /** Lines with values, by their index. */
  rows: number[];
}

/** A table that can be shown as a grid, or nothing without a header. */
export function table(text: string): Table | null {
  const lines = text.replace(/^\ufeff/, "").split(/\r?\n/);
  const header = lines.findIndex((line) => line.trim() !== "" && !line.startsWith("#"));
  if (header < 0) return null;
  const separator = lines[header]!.includes(";") ? ";" : ",";
  const names = split(lines[header]!, separator).map(unquoted);
  const rows: number[] = [];
  lines.forEach((line, n) => {
    if (n > header && line.trim() !== "" && !line.startsWith("#")) rows.push(n);
  });
  return { lines, ends: text.includes("\r\n") ? "\r\n" : "\n", header, separator, names, rows };
}

/** The parts of a line as they stand; between quotation marks a separator is none. */
function split(line: string, separator: string): string[] {
  if (!line.includes('"')) return line.split(separator);
  const found: string[] = [];
  let [start, isQuoted] = [0, false];
  for (let n = 0; n <= line.length; n++) {
    if (line[n] === '"') isQuoted = !isQuoted;
    if (n < line.length && (line[n] !== separator || isQuoted)) continue;
    found.push(line.slice(start, n));
    start = n + 1;
  }
  return found;
}

/** What a part says: without the quotation marks around it. */
function unquoted(part: string): string {
  const text = part.trim();
  return /^".*"$/.test(text) ? text.slice(1, -1).replaceAll('""', '"').trim() : text;
}

export function cells(of: Table, line: number): string[] {
  return split(of.lines[line]!, of.separator).map(unquoted);
}

export function text(of: Table): string {
  return of.lines.join(of.ends);
}

/** Values written over a rectangle from a row and column on; rows are added where it is longer. */
export function pasted(of: Table, row: number, column: number, values: string[][]): Table {
  const lines = [...of.lines];
  const rows = [...of.rows];
  values.forEach((given, n) => {
    let line = rows[row + n];
    if (line === undefined) {
      line = (rows.at(-1) ?? of.header) + 1;
      lines.splice(line, 0, of.separator.repeat(of.names.length - 1));
      rows.push(line);
    }
    const now = split(lines[line]!, of.separator);
    given.forEach((value, m) => {
      if (column + m < of.names.length) now[column + m] = value;
    });
    lines[line] = now.join(of.separator);
  });
  return { ...of, lines, rows };
}

export function withoutRow(of: Table, row: number): Table {
  return { ...of, lines: of.lines.filter((_, line) => line !== of.rows[row]) };
}

/**
 * What stands in a cell for what was typed. A decimal comma becomes a point where commas separate; whatever else a separator, a
 * quotation mark or a # is part of is quoted, so that the reader refuses that cell: nothing is taken for something else.
 */
export function cell(given: string, separator: string): string {
  const text = unquoted(given).replace(/^\u2212/, "-");
  if (separator === "," && /^[-+]?\d*,\d*$/.test(text)) return text.replace(",", ".");
  return /["#]/.test(text) || text.includes(separator) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** A block of a spreadsheet, or a cell of it in which nobody can say what its comma means. */
export interface Block {
  values: string[][];
  /** A decimal comma that became a point. */
  comma: string;
  unclear: string;
}

const THOUSANDS = /^[-+\u2212]?[1-9]\d{0,2}(,\d{3})+$/;

/** Commas are decimal in the whole block where one of its cells shows it and none holds a point. */
export function block(copied: string, separator: string): Block {
  const rows = copied.replace(/\r/g, "").replace(/\n+$/, "").split("\n").map((line) => line.split("\t").map(unquoted));
  const numbers = rows.flat().filter((one) => /^[-+\u2212]?[\d.,]+$/.test(one));
  const commas = numbers.filter((one) => one.includes(","));
  const isDecimal = commas.some((one) => /^\D?\d*,\d*$/.test(one) && !THOUSANDS.test(one)) && !numbers.some((one) => one.includes("."));
  if (commas.length && !isDecimal) return { values: [], comma: "", unclear: commas[0]! };
  const values = rows.map((line) => line.map((one) => cell(/^\D?\d*,\d*$/.test(one) ? one.replace(",", ".") : one, separator)));
  return { values, comma: commas[0] ?? "", unclear: "" };
}

/** The cell of a line in which a character stands, counted from 1. */
export function cellAt(of: Table, line: number, column: number): number {
  let end = 0;
  const found = split(of.lines[line]!, of.separator).findIndex((part) => (end += part.length + 1) >= column);
  return Math.max(found, 0);
}

export interface Curve {
  name: string;
  points: [number, number][];
}

const number = (cell: string | undefined, separator: string) => {
  const value = cell ?? "";
  return value === "" ? NaN : Number(separator === ";" ? value.replace(",", ".") : value);
};

/** What a unit at the end of a column's name is in mm or µm. */
const MM: Record<string, number> = { mm: 1, in: 25.4 };
const UM: Record<string, number> = { um: 1, mm: 1000, in: 25_400, uin: 0.0254 };
const unit = (name: string, of: Record<string, number>) => of[name.slice(name.lastIndexOf("_") + 1)] ?? NaN;

/** The columns of deviations over the positions of each moving axis and direction, as far as they are filled in. */
export function curves(of: Table): Map<string, Curve[]> {
  const at = (name: RegExp) => of.names.findIndex((own) => name.test(own));
  const [axis, position, direction] = [at(/^axis$/i), at(/^position_/), at(/^direction$/)];
  const found = new Map<string, Curve[]>();
  if (axis < 0 || position < 0) return found;
  const columns = of.names.flatMap((name, n) => (/^e[xyz]_/.test(name) ? [n] : []));
  for (const line of of.rows) {
    const row = cells(of, line);
    const moving = (row[axis] ?? "").toUpperCase();
    const way = direction < 0 ? "" : row[direction] ?? "";
    for (const column of columns) {
      const mm = number(row[position], of.separator) * unit(of.names[position]!, MM);
      const point: [number, number] = [mm, number(row[column], of.separator) * unit(of.names[column]!, UM)];
      if (!point.every(Number.isFinite)) continue;
      const name = of.names[column]!.replace(/^e(.)_.*/, (_, of) => `E${of.toUpperCase()}${moving}`) + way;
      const panel = found.get(moving) ?? found.set(moving, []).get(moving)!;
      const curve = panel.find((one) => one.name === name);
      if (curve) curve.points.push(point);
      else panel.push({ name, points: [point] });
    }
  }
  return found;
}
