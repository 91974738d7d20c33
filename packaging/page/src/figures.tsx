// The figures of a verdict as a table, and what decides it.
import type { Figure, Judged, Manifest } from "./visit";
import { figure, t } from "./words";

function Rows(props: { of: Record<string, Figure>; isAfter: boolean; table?: (name: string) => string }) {
  return (
    <>
      {Object.entries(props.of).map(([name, one]) => (
        <tr>
          <th scope="row">{name}</th>
          <td>{figure(one.before_um)}</td>
          <td>{figure(one.forecast_um)}</td>
          {props.isAfter && <td>{figure(one.after_um)}</td>}
          <td>{one.at_most_um === null ? t("u_not_stated") : figure(one.at_most_um)}</td>
          {props.table && <td class="left">{props.table(name)}</td>}
        </tr>
      ))}
    </>
  );
}

export function Figures(props: { judged: Judged; manifest?: Manifest | null }) {
  const { judged, manifest } = props;
  const isAfter = judged.diagnosis !== undefined;
  const place = (term: string) =>
    (manifest?.tables ?? [])
      .filter((table) => table.term === term)
      .map((table) => `${table.place}${table.direction ? ` ${table.direction}` : ""}`)
      .join(", ") || "–";
  const where = manifest ? place : undefined;
  return (
    <div class="scroll" tabIndex={0} role="region" aria-label={t("errors")}>
      <table>
        <thead>
          <tr>
            <th scope="col">{t("error")}, µm</th>
            <th scope="col">{t("found")}</th>
            <th scope="col">{t("forecast")}</th>
            {isAfter && <th scope="col">{t("left")}</th>}
            <th scope="col">{t("at_most_heading")}</th>
            {where && <th scope="col" class="left">{t("table")}</th>}
          </tr>
        </thead>
        <tbody>
          <Rows of={judged.terms} isAfter={isAfter} table={where} />
          <tr class="all">
            <th scope="row">{t("all_errors")}</th>
            <td />
            {isAfter && <td />}
            <td>{figure(judged.max_residual_um)}</td>
            <td>{judged.max_residual_at_most_um === null ? t("u_not_stated") : figure(judged.max_residual_at_most_um)}</td>
            {where && <td />}
          </tr>
          <Rows of={judged.diagonals ?? {}} isAfter={isAfter} table={where && (() => t("range"))} />
        </tbody>
      </table>
    </div>
  );
}

export function Decides(props: { judged: Judged }) {
  const decides = props.judged.what_decides;
  const { causes } = props.judged;
  return (
    <>
      {causes.length > 0 && (
        <>
          <h3>{t("findings")}</h3>
          <ul>{causes.map((words) => <li>{words}</li>)}</ul>
        </>
      )}
      {decides && (
        <>
          <h3>{t("what_next")}</h3>
          <p>
            {t("decides", {
              what: decides.term,
              left: `${figure(decides.left_um)} µm`,
              parts: decides.parts.map((part) => `${part.what} ${figure(part.um)} µm`).join(", "),
              um: `${figure(decides.at_most_um)} µm`,
            })}
          </p>
          {decides.acts.length > 0 && (
            <>
              <h3>{t("acts")}</h3>
              <ol>
                {decides.acts.map((act) => (
                  <li>
                    {t("act", { what: act.what, um: `${figure(act.at_most_um)} µm`, verdict: t(act.verdict) })}{" "}
                    {act.minutes !== null && t("act_minutes", { min: figure(act.minutes, 0), minutes: figure(act.minutes, 0) })}
                  </li>
                ))}
              </ol>
            </>
          )}
        </>
      )}
    </>
  );
}
