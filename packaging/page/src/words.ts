// Words of this page in the reader's language: those of the report, and its own.
import { signal } from "@preact/signals";
import reportDe from "../../../templates/report/de.toml";
import reportEn from "../../../templates/report/en.toml";
import reportZh from "../../../templates/report/zh.toml";
import de from "../texts/de.toml";
import en from "../texts/en.toml";
import zh from "../texts/zh.toml";

const all: Record<string, Record<string, string>> = {
  en: { ...reportEn, ...en },
  de: { ...reportDe, ...de },
  zh: { ...reportZh, ...zh },
};

const wanted = navigator.language.slice(0, 2);
export const language = signal(wanted in all ? wanted : "en");
export const languages = Object.keys(all);

/** Words with `{…}` replaced by these. */
export function t(key: string, with_: Record<string, string | number> = {}): string {
  const words = all[language.value]![key] ?? all.en![key] ?? key;
  return words.replace(/\{(\w+)\}/g, (whole, name) => String(with_[name] ?? whole));
}

/** A figure with the decimal mark of the language; nothing where there is none. */
export function figure(value: number | null | undefined, decimals = 3): string {
  return value === null || value === undefined ? "–" : value.toFixed(decimals).replace(".", t("decimal")).replace("-", "−");
}
