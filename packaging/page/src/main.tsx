import { render } from "preact";
import { App } from "./app";
import { ready } from "./core";
import { start } from "./visit";
import "./style.css";

render(<App />, document.getElementById("app")!);
// A file dropped beside its place is not opened in place of the page.
for (const event of ["dragover", "drop"]) addEventListener(event, (one) => one.preventDefault());
performance.mark("shown");
void ready.then(() => performance.mark("core"));
void start();
