// Small parts of every step.
import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { chosen, dropped, save } from "./opened";
import type { Problem } from "./problems";
import { notice, type Files, type Judged } from "./visit";
import { t } from "./words";

export function Card(props: { title?: string; children: ComponentChildren; wide?: boolean }) {
  return (
    <section class={props.wide ? "card wide" : "card"}>
      {props.title && <h2>{props.title}</h2>}
      {props.children}
    </section>
  );
}

export function Problems(props: { of: Problem[] }) {
  return (
    <ul class="problems">
      {props.of.map((problem) => (
        <li>
          <strong>{problem.words}</strong>
          {problem.places[0] && ` (${problem.places[0].file}:${problem.places[0].line})`}
          {problem.help && <div class="soft">{problem.help}</div>}
        </li>
      ))}
    </ul>
  );
}

/** What was asked and what the verdict covers, in the program's words. */
export function Scope(props: { of: Judged }) {
  return <p class="scope">{props.of.scope.join("\n")}</p>;
}

/** What else is to be known, folded away. */
export function Notes(props: { of: string[] }) {
  return props.of.length ? (
    <details>
      <summary>{t("all_notes", { count: props.of.length })}</summary>
      <ul class="soft">
        {props.of.map((words) => (
          <li>{words}</li>
        ))}
      </ul>
    </details>
  ) : null;
}

export function Verdict(props: { of: string; forecast?: boolean }) {
  const word = t(props.of);
  return <span class={`verdict ${props.of}`}>{props.forecast ? t("forecast_word", { verdict: word }) : word}</span>;
}

/** A place where files can be dropped, or chosen. */
export function Drop(props: { words: string; folder?: boolean; take: (files: Files) => void | Promise<void> }) {
  const [over, setOver] = useState(false);
  const failed = (fault: Error) => (notice.value = fault.message);
  const choose = (folder: boolean) => {
    const input = document.createElement("input");
    input.type = "file";
    input.multiple = true;
    input.webkitdirectory = folder;
    input.onchange = () => void chosen(input.files).then(props.take).catch(failed);
    input.click();
  };
  return (
    <div
      class={over ? "drop over" : "drop"}
      onDragOver={(event) => {
        event.preventDefault();
        setOver(true);
      }}
      onDragLeave={() => setOver(false)}
      onDrop={async (event) => {
        event.preventDefault();
        setOver(false);
        if (event.dataTransfer) await dropped(event.dataTransfer).then(props.take).catch(failed);
      }}
    >
      <p>{props.words}</p>
      <button type="button" onClick={() => choose(false)}>
        {t("choose_files")}
      </button>
      {props.folder && (
        <button type="button" onClick={() => choose(true)}>
          {t("choose_folder")}
        </button>
      )}
    </div>
  );
}

/** A link to a place of the same page goes there: in a frame without an address it would leave the page. */
function withinItself(event: Event) {
  const page = (event.currentTarget as HTMLIFrameElement).contentDocument;
  page?.addEventListener("click", (click) => {
    const link = (click.target as Element).closest("a[href^='#']");
    if (!link) return;
    click.preventDefault();
    page.getElementById(link.getAttribute("href")!.slice(1))?.scrollIntoView();
  });
}

/** A page of the program in a frame of its own, to be read and printed. */
export function Framed(props: { html: string; title: string; name: string }) {
  return (
    <div>
      <div class="buttons">
        <button type="button" onClick={() => save(props.name, props.html, "text/html")}>
          {t("download")}: {props.name}
        </button>
        <button type="button" onClick={() => (document.getElementById(props.name) as HTMLIFrameElement).contentWindow?.print()}>
          {t("print")}
        </button>
      </div>
      <iframe id={props.name} title={props.title} srcdoc={props.html} sandbox="allow-same-origin allow-modals" onLoad={withinItself} />
    </div>
  );
}

/** A picture that the program drew (SVG), on paper whatever the colours around. */
export function Picture(props: { svg: string }) {
  return props.svg ? <div class="picture" tabIndex={0} dangerouslySetInnerHTML={{ __html: props.svg }} /> : null;
}
