// A job as a form: a row for each key, X, Y and Z side by side, the reader's own messages beside the field.
import { useState } from "preact/hooks";
import { choices, groups, sections, shown, withKey, without, withoutBlock, withProposed, withValue, written, type Field, type Group, type Section } from "./job";
import { at, said, type Problem } from "./problems";
import { Card, Problems } from "./ui";
import { absent, isPlain, isText, put, textOf, wordsOf } from "./visit";
import { t } from "./words";

/** `machine.axes` → Machine: axes. */
function heading(group: Group): string {
  const words = group.name.split(".").map((part) => part.replaceAll("_", " "));
  const [first, ...rest] = words;
  return [first!.charAt(0).toUpperCase() + first!.slice(1), ...rest].join(" · ");
}

function Input(props: { file: string; section: Section; field: Field; problems: Problem[]; label: string }) {
  const { file, section, field } = props;
  const isOpen = field.value === '""';
  const words = field.words || wordsOf(section.name, field.key);
  const offered = choices(words);
  const own = at(props.problems, file, field.line + 1).filter((problem) => !(isOpen && problem.words.includes("empty")));
  const name = `${file}:${field.line}`;
  const change = (typed: string) => {
    const value = typed.trim() === "" && !isOpen ? '""' : written(typed, isText(section.name, field.key) || /e\.g\. "/.test(field.words));
    put(file, withValue(textOf(file), field, value));
  };
  const common = {
    id: name,
    "aria-label": props.label,
    "aria-invalid": own.length > 0,
    "aria-describedby": own.length ? `${name}-told` : undefined,
    class: isOpen ? "open" : "",
  };
  const [draft, setDraft] = useState<string | null>(null);
  const now = shown(field.value);
  if (field.isLong) return <span class="soft">{t("as_text")}</span>;
  return (
    <>
      {offered.length && (offered.includes(now) || now === "") ? (
        <select {...common} value={now} onChange={(event) => change(event.currentTarget.value)}>
          <option value="">–</option>
          {offered.map((one) => (
            <option value={one}>{one}</option>
          ))}
        </select>
      ) : (
        <input
          {...common}
          autocomplete="off"
          spellcheck={false}
          value={draft ?? now}
          onBlur={() => setDraft(null)}
          onInput={(event) => {
            setDraft(event.currentTarget.value);
            change(event.currentTarget.value);
          }}
        />
      )}
      {own.length > 0 && (
        <p class="told" id={`${name}-told`} role="status">
          {own.map(said).join("; ")}
        </p>
      )}
    </>
  );
}

/** A key, with its value in each column. */
function Row(props: { file: string; group: Group; name: string; problems: Problem[] }) {
  const { file, group } = props;
  const found = group.columns.map((section) => section.fields.find((field) => field.key === props.name && !field.optional));
  const first = group.columns.flatMap((section, n) => (found[n] ? [{ section, field: found[n]! }] : []))[0];
  if (!first) return null;
  const words = first.field.words || wordsOf(first.section.name, props.name);
  const leaveOut = () => put(file, found.reduce((text, field) => (field ? without(text, field) : text), textOf(file)));
  return (
    <div class="row">
      <div class="key">
        <code>
          {props.name}
          <button type="button" class="link" title={t("leave_out")} aria-label={`${t("leave_out")} ${props.name}`} onClick={leaveOut}>
            ✕
          </button>
        </code>
        <span class="soft">{words}</span>
      </div>
      <div class="values">
        {group.columns.map((section, n) => {
          const field = found[n];
          const column = columnName(section, n, group);
          return (
            <div>
              {field ? (
                <Input file={file} section={section} field={field} problems={props.problems} label={`${props.name} ${column}`} />
              ) : (
                <span class="soft">–</span>
              )}
            </div>
          );
        })}
      </div>
    </div>
  );
}

function columnName(section: Section, n: number, group: Group): string {
  const axis = /\.([xyz])$/.exec(section.name)?.[1];
  if (axis) return axis.toUpperCase();
  const named = section.fields.find((field) => field.key === "axis");
  return named && section.many ? shown(named.value).toUpperCase() : group.columns.length > 1 ? String(n + 1) : "";
}

/** Keys behind a `# `, and those of the schema that the section does not have. */
function More(props: { file: string; group: Group }) {
  const { file, group } = props;
  const use = (key: string) => {
    let text = textOf(file);
    for (const column of group.columns) {
      // Each change moves lines: the section is looked up in the text as it is then.
      const section = sections(text).filter((one) => one.name === column.name)[group.columns.filter((one) => one.name === column.name).indexOf(column)];
      const field = section?.fields.find((one) => one.key === key && one.optional);
      if (section && field) text = withProposed(text, field);
      else if (section && !section.fields.some((one) => one.key === key)) text = withKey(text, section, key, '""');
    }
    put(file, text);
  };
  const first = group.columns[0]!;
  const proposed = first.fields.filter((field) => field.optional);
  const others = absent(first).filter((key) => !/^(x|y|z|axes)$/.test(key.key));
  if (!proposed.length && !others.length) return null;
  const row = (key: string, words: string) => (
    <div class="row">
      <div class="key">
        <code>{key}</code>
        <span class="soft">{words}</span>
      </div>
      <div class="values">
        <button type="button" aria-label={`${t("use")} ${key}`} onClick={() => use(key)}>
          {t("use")}
        </button>
      </div>
    </div>
  );
  return (
    <details>
      <summary>{t("show_optional", { count: proposed.length + others.length })}</summary>
      {proposed.map((field) => row(field.key, field.words || wordsOf(first.name, field.key)))}
      {others.map((key) => row(key.key, key.words))}
    </details>
  );
}

function Of(props: { file: string; group: Group; problems: Problem[] }) {
  const { file, group } = props;
  const names = [...new Set(group.columns.flatMap((section) => section.fields.filter((field) => !field.optional).map((field) => field.key)))];
  const several = group.columns.length > 1;
  const headers = group.columns.flatMap((section) => at(props.problems, file, section.line + 1));
  return (
    <Card title={heading(group)} wide>
      {group.intro && <p class="soft">{group.intro}</p>}
      <Problems of={[...new Set(headers)]} />
      <div>
        {several && (
          <div class="row heads">
            <div class="key" />
            <div class="values">
              {group.columns.map((section, n) => (
                <div>
                  {columnName(section, n, group)}
                  {section.many && (
                    <button type="button" class="small" onClick={() => put(file, withoutBlock(textOf(file), section))}>
                      {t("not_measured_block")}
                    </button>
                  )}
                </div>
              ))}
            </div>
          </div>
        )}
        {names.map((name) => (
          <Row file={file} group={group} name={name} problems={props.problems} />
        ))}
      </div>
      <More file={file} group={group} />
    </Card>
  );
}

/** How many keys of a job wait for a value. */
export function openKeys(text: string): number {
  return sections(text).flatMap((section) => section.fields).filter((field) => field.value === '""' && !field.optional).length;
}

/** Problems of a file that no field of the form shows. */
function elsewhere(all: Problem[], file: string): Problem[] {
  const text = textOf(file);
  const shownLines = new Set(sections(text).flatMap((section) => [section.line + 1, ...section.fields.map((field) => field.line + 1)]));
  return all.filter((problem) => !problem.places.some((place) => place.file === file && shownLines.has(place.line)));
}

export function JobForm(props: { file: string; problems: Problem[] }) {
  const [asText, setAsText] = useState(false);
  const text = textOf(props.file);
  const waiting = openKeys(text);
  const own = props.problems.filter((problem) => problem.places.length === 0 || problem.places.some((place) => place.file === props.file));
  const others = elsewhere(own, props.file);
  if (!isPlain(props.file)) {
    return (
      <Card title={props.file} wide>
        <p class="told">{t("not_plain", { file: props.file })}</p>
        <Problems of={own} />
      </Card>
    );
  }
  return (
    <>
      <div class="bar">
        <span class={waiting || own.length ? "state" : "state good"}>
          {waiting ? t("open_fields", { count: waiting }) : own.length ? t("problems_count", { count: own.length }) : t("complete")}
        </span>
        <button type="button" onClick={() => setAsText(!asText)}>
          {t(asText ? "as_form" : "as_text")}
        </button>
      </div>
      {asText ? (
        <Card title={props.file} wide>
          <Problems of={own} />
          <textarea
            aria-label={props.file}
            spellcheck={false}
            rows={Math.min(60, text.split("\n").length + 1)}
            value={text}
            onInput={(event) => put(props.file, event.currentTarget.value)}
          />
        </Card>
      ) : (
        <>
          {others.length > 0 && (
            <Card title={t("other_problems")} wide>
              <Problems of={others} />
            </Card>
          )}
          {groups(sections(text)).map((group) => (
            <Of key={group.name} file={props.file} group={group} problems={own} />
          ))}
        </>
      )}
    </>
  );
}

