// The steps of a visit.
import { signal } from "@preact/signals";

export const steps = ["machine", "job", "measurement", "result", "kit", "second"] as const;
export type Step = (typeof steps)[number];
export const step = signal<Step>("machine");
