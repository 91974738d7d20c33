// A table of values as a grid: the rows in view, cells that can be typed in, pasted into and walked through.
import { options } from "preact";
import { useRef, useState } from "preact/hooks";
import { at, said, type Problem } from "./problems";
import { block, cell, cellAt, cells, pasted, table, text, withoutRow, type Table } from "./table";
import { files, isPlain, notice, put, textOf } from "./visit";
import { t } from "./words";

const ROW_PX = 34;
const IN_VIEW = 24;

/** The cells of a line that are wrong, and what is. */
function told(of: Table, file: string, problems: Problem[], line: number): { cells: number[]; words: string } | null {
  const all = at(problems, file, line + 1).flatMap((problem) => {
    const place = problem.places.find((one) => one.file === file && one.line === line + 1)!;
    const first = problem.places[0]!;
    if (place.column) return { cell: cellAt(of, line, place.column), words: said(problem) };
    return { cell: cellAt(of, first.line - 1, first.column), words: `${t("as_in_row", { row: first.line })}: ${said(problem)}` };
  });
  return all.length ? { cells: all.map((one) => one.cell), words: all.map((one) => one.words).join("; ") } : null;
}

/** Draws a change before the next key comes. */
function atOnce(change: () => void) {
  const before = options.debounceRendering;
  options.debounceRendering = (render) => render();
  change();
  options.debounceRendering = before;
}

export function Grid(props: { file: string; problems: Problem[] }) {
  const { file } = props;
  const of = isPlain(file) ? table(textOf(file)) : null;
  const [top, setTop] = useState(0);
  const [now, setNow] = useState(-1);
  // What is being typed, as it is typed.
  const [draft, setDraft] = useState<{ cell: string; text: string } | null>(null);
  const frame = useRef<HTMLDivElement>(null);
  if (!of) return <p>{t(files.value.has(file) ? "no_grid" : "not_here", { file })}</p>;
  const first = Math.max(0, Math.min(Math.floor(top / ROW_PX) - 4, of.rows.length - IN_VIEW - 8));
  const last = Math.min(of.rows.length, first + IN_VIEW + 8);
  const write = (row: number, column: number, values: string[][]) => put(file, text(pasted(table(textOf(file))!, row, column, values)));
  const go = (row: number, column: number) => {
    const there = () => frame.current?.querySelector<HTMLInputElement>(`[data-cell="${row}:${column}"]`);
    if (row < 0 || row >= table(textOf(file))!.rows.length || column < 0 || column >= of.names.length) return;
    if (!there()) {
      frame.current!.scrollTop = row * ROW_PX;
      atOnce(() => setTop(row * ROW_PX));
    }
    there()?.focus();
    there()?.select(); // what is typed replaces, as in a spreadsheet
  };
  const walk = (event: KeyboardEvent, row: number, column: number) => {
    const input = event.currentTarget as HTMLInputElement;
    const end = event.key === "ArrowRight" ? input.value.length : 0;
    const isAtEnd = input.selectionStart === end && input.selectionEnd === end;
    const to: Record<string, [number, number]> = { ArrowUp: [-1, 0], ArrowDown: [1, 0], Enter: [1, 0] };
    if (isAtEnd) Object.assign(to, { ArrowLeft: [0, -1], ArrowRight: [0, 1] });
    const way = to[event.key];
    if (!way) return;
    event.preventDefault();
    setDraft(null);
    go(row + way[0], column + way[1]);
    if (document.activeElement === input) atOnce(() => input.select()); // at an end
  };
  const paste = (event: ClipboardEvent, row: number, column: number) => {
    event.preventDefault();
    const { values, comma, unclear } = block(event.clipboardData?.getData("text/plain") ?? "", of.separator);
    const isTooWide = values.some((line) => column + line.length > of.names.length);
    if (unclear || isTooWide) {
      notice.value = unclear ? t("unclear_comma", { example: unclear }) : t("too_wide");
      return;
    }
    const axis = (n: number) => (of.rows[n] === undefined ? "" : cells(of, of.rows[n]!)[0]!);
    const end = row + values.length - 1;
    const added = end + 1 - of.rows.length;
    const told = [comma && t("commas", { example: comma, point: comma.replace(",", ".") })];
    if (added > 0) told.push(t("rows_added", { count: added }));
    else if (axis(end) !== axis(row)) told.push(t("crosses", { from: axis(row), to: axis(end) }));
    notice.value = told.filter(Boolean).join(" ");
    setDraft(null);
    write(row, column, values);
  };
  const addRow = () => {
    const end = of.rows.length;
    atOnce(() => write(end, 0, [[""]]));
    go(end, 0);
  };
  const isWord = (name: string) => /^(axis|direction|diagonal|node|moved|run)$/i.test(name);
  const widths = of.names.map((name) => (isWord(name) ? "minmax(3.6rem, .6fr)" : "minmax(5.5rem, 1fr)"));
  const columns = { gridTemplateColumns: `2.6rem ${widths.join(" ")}` };
  const header = told(of, file, props.problems, of.header);
  return (
    <div>
      <p class="soft">
        {t("rows", { count: of.rows.length })}. {t("paste_hint")}
      </p>
      {header && <p class="told" role="status">{header.words}</p>}
      <div class="grid" ref={frame} role="grid" aria-label={file} aria-rowcount={of.rows.length + 1} onScroll={(event) => setTop(event.currentTarget.scrollTop)}>
        <div class="line head" role="row" style={columns}>
          <span role="columnheader">{" "}</span>
          {of.names.map((name) => (
            <span role="columnheader">{name}</span>
          ))}
        </div>
        <div role="presentation" style={{ height: `${first * ROW_PX}px` }} />
        {of.rows.slice(first, last).map((line, n) => {
          const row = first + n;
          const own = cells(of, line);
          const fault = told(of, file, props.problems, line);
          return (
            <div class={fault ? "line fault" : "line"} role="row" key={row} style={columns} aria-rowindex={row + 2}>
              <span role="rowheader" class="soft" title={fault?.words}>
                {line + 1}
              </span>
              {of.names.map((name, column) => (
                <span role="gridcell">
                  <input
                    data-cell={`${row}:${column}`}
                    aria-label={`${name}, ${line + 1}`}
                    aria-invalid={fault?.cells.includes(column) ?? false}
                    autocomplete="off"
                    value={draft?.cell === `${row}:${column}` ? draft.text : own[column] ?? ""}
                    onFocus={() => setNow(row)}
                    onBlur={() => setDraft(null)}
                    onInput={(event) => {
                      setDraft({ cell: `${row}:${column}`, text: event.currentTarget.value });
                      write(row, column, [[cell(event.currentTarget.value, of.separator)]]);
                    }}
                    onKeyDown={(event) => walk(event, row, column)}
                    onPaste={(event) => paste(event, row, column)}
                  />
                </span>
              ))}
              {fault && <p class="told" role="status">{fault.words}</p>}
            </div>
          );
        })}
        <div role="presentation" style={{ height: `${(of.rows.length - last) * ROW_PX}px` }} />
      </div>
      <button type="button" onClick={addRow}>
        {t("add_row")}
      </button>{" "}
      {now >= 0 && now < of.rows.length && (
        <button type="button" onClick={() => put(file, text(withoutRow(of, now)))}>
          {t("remove_row", { row: of.rows[now]! + 1 })}
        </button>
      )}
    </div>
  );
}
