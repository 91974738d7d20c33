import { render } from "preact";
import { App } from "./app";
import { ready } from "./core";
import { start } from "./visit";
import "./style.css";

render(<App />, document.getElementById("app")!);
performance.mark("shown");
void ready.then(() => performance.mark("core"));
void start();
