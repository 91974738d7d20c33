// Problems of the program, with their places.
import type { Answer } from "./core";
import { t } from "./words";

export interface Place {
  file: string;
  line: number;
  /** Counted from 1, in characters; 0 = the cell of the first place, in another row. */
  column: number;
}

export interface Problem {
  words: string;
  places: Place[];
  help: string;
}

/** As the core tells them: `lines` are those where the same problem stands once more, `more` is only counted. */
export interface Told {
  problems?: { message: string; place: Place | null; also: Place[]; help: string | null; lines: number[] }[];
  more?: number;
}

export function problems(of: Answer): Problem[] {
  const found = (of.told.problems ?? []).map(({ message, place, also, help, lines }) => {
    const again = lines.map((line) => ({ file: place!.file, line, column: 0 }));
    return { words: message, places: place ? [place, ...also, ...again] : also, help: help ?? "" };
  });
  const loose = (words: string): Problem => ({ words, places: [], help: "" });
  if (of.told.more) found.push(loose(t("more_problems", { count: of.told.more })));
  if (of.status === 2 && !found.length) found.push(loose(of.err.trim())); // wrong usage
  return found;
}

/** Those that a line of a file is among. */
export function at(all: Problem[], file: string, line: number): Problem[] {
  return all.filter((problem) => problem.places.some((place) => place.file === file && place.line === line));
}

/** What is wrong, and what to do, in one sentence. */
export function said(problem: Problem): string {
  return [problem.words, problem.help].filter(Boolean).join(": ");
}
