// Problems as the program prints them, with their places.

export interface Place {
  file: string;
  line: number;
  /** Counted from 1, in characters; 0 = the whole line. */
  column: number;
}

export interface Problem {
  words: string;
  places: Place[];
  help: string;
}

/** The problems on standard error; blocks with an empty line between them. */
export function problems(err: string): Problem[] {
  const found: Problem[] = [];
  for (const block of err.split(/\n(?=problem: )/)) {
    const [first, ...rest] = block.split("\n");
    if (!first?.startsWith("problem: ")) continue;
    const more: string[] = [];
    const places: Place[] = [];
    const help: string[] = [];
    let part = "words";
    for (const line of rest) {
      const place = /^\s*(?:-->|:::) (.*):(\d+):(\d+)$/.exec(line);
      const also = /^\s+line (\d+): /.exec(line);
      const note = /^\s*= (help|note): (.*)$/.exec(line);
      if (place) {
        places.push({ file: place[1]!, line: Number(place[2]), column: Number(place[3]) });
        part = "source";
      } else if (note) {
        part = note[1]!;
        if (part === "help") help.push(note[2]!);
        else if (note[2] !== "also") help.push(note[2]!);
      } else if (also && places[0]) {
        places.push({ file: places[0].file, line: Number(also[1]), column: 0 });
      } else if (part === "words" && line.trim()) {
        more.push(line.trim());
      } else if (part === "help" && line.trim() && !/^\s*\|/.test(line)) {
        help.push(line.trim());
      }
    }
    found.push({ words: [first.slice("problem: ".length), ...more].join(" "), places, help: help.join("; ") });
  }
  return found;
}

/** Those that a line of a file is among. */
export function at(all: Problem[], file: string, line: number): Problem[] {
  return all.filter((problem) => problem.places.some((place) => place.file === file && place.line === line));
}
