// The page as a person uses it, in a browser without a window; the program beside it, whose files must be the same.
//   NONIUS_PAGE     the page          NONIUS_PROGRAM  the program
//   NONIUS_BROWSER  its program, of Chromium (the default) or Firefox
//   NONIUS_PICTURES a folder: pictures of each step in three widths, light and dark
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, mkdtempSync, readdirSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, dirname, join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath, pathToFileURL } from "node:url";
import { unzipSync, zipSync } from "fflate";
import puppeteer from "puppeteer-core";

const root = resolve(fileURLToPath(import.meta.url), "../../../..");
const program = resolve(process.env.NONIUS_PROGRAM ?? join(root, "target/debug/nonius"));
const file = resolve(process.env.NONIUS_PAGE ?? join(root, "target/package/nonius.html"));
const pictures = process.env.NONIUS_PICTURES;
const isFirefox = /firefox/.test(process.env.NONIUS_BROWSER ?? "");
const axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

let browser;
let page;
const asked = [];
const said = [];
const scratch = mkdtempSync(join(tmpdir(), "nonius-page-"));
const downloads = join(scratch, "downloads");

before(async () => {
  mkdirSync(downloads);
  const directory = { "browser.download.folderList": 2, "browser.download.dir": downloads };
  browser = await puppeteer.launch({
    browser: isFirefox ? "firefox" : "chrome",
    executablePath: process.env.NONIUS_BROWSER ?? "/usr/bin/chromium",
    args: isFirefox ? [] : ["--no-sandbox"],
    extraPrefsFirefox: directory,
    protocolTimeout: 120_000,
  });
});
after(async () => {
  await browser?.close();
  rmSync(scratch, { recursive: true, force: true });
});

/** A window with the page; nothing of an earlier visit. */
async function opened() {
  await page?.close();
  const context = await browser.createBrowserContext();
  page = await context.newPage();
  await page.setViewport({ width: 1280, height: 900 });
  page.on("request", (request) => asked.push(request.url()));
  page.on("console", (message) => message.type() === "error" && said.push(message.text()));
  page.on("pageerror", (fault) => said.push(String(fault)));
  await page.goto(pathToFileURL(file).href);
  await page.waitForSelector(".card select");
  await page.select("select[aria-label=Language]", "en");
}

const settled = () => page.waitForFunction(() => !document.querySelector("header .now")?.textContent?.includes("…"), { timeout: 60_000 });

async function go(step) {
  await page.click(`#step-${step}`);
  await new Promise((done) => setTimeout(done, 200));
  await settled();
}

/** Presses the first button with these words. */
async function press(words, inside = "main, header") {
  const found = await page.evaluateHandle(
    (words, inside) => [...document.querySelectorAll(inside)].flatMap((one) => [...one.querySelectorAll("button")]).find((one) => one.textContent.trim().startsWith(words)),
    words,
    inside,
  );
  assert.ok(found.asElement(), `no button "${words}"`);
  await found.asElement().click();
}

/** Chooses these files, as through the dialogue. */
async function choose(paths) {
  const [chooser] = await Promise.all([page.waitForFileChooser(), press("Choose files")]);
  await chooser.accept(paths);
  await new Promise((done) => setTimeout(done, 400));
  await settled();
}

/** Drops files by name onto the first place for it. */
async function drop(files) {
  await page.evaluate((files) => {
    const data = new DataTransfer();
    for (const [name, text] of files) data.items.add(new File([text], name));
    document.querySelector(".drop").dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, files);
  await new Promise((done) => setTimeout(done, 400));
  await settled();
}

async function type(label, value) {
  const field = await page.waitForSelector(`[aria-label="${label}"]`);
  const isSelect = await field.evaluate((one) => one.tagName === "SELECT");
  if (isSelect) await page.select(`[aria-label="${label}"]`, value);
  else {
    await field.click({ count: 3 });
    await field.press("Backspace");
    await field.type(value);
  }
}

/** Pastes cells of a spreadsheet. */
async function paste(cell, text) {
  await page.focus(`[data-cell="${cell}"]`);
  await page.evaluate((text) => {
    const data = new DataTransfer();
    data.setData("text/plain", text);
    const event = new ClipboardEvent("paste", { bubbles: true, cancelable: true });
    Object.defineProperty(event, "clipboardData", { value: data }); // Firefox takes none from a script
    document.activeElement.dispatchEvent(event);
  }, text);
}

/** What the page says once, above its step. */
const noticed = () => page.$eval(".notice", (one) => one.innerText);

/** Packs files into a zip and chooses it. */
async function chooseZip(files) {
  writeFileSync(join(scratch, "packed.zip"), zipSync(files));
  await choose([join(scratch, "packed.zip")]);
}

/** A workbook whose only sheet holds these cells. */
function workbook(rows) {
  const cell = (text) => (text !== "" && Number.isFinite(Number(text)) ? `<c><v>${text}</v></c>` : `<c t="inlineStr"><is><t>${text}</t></is></c>`);
  const sheet = rows.map((row) => `<row>${row.map(cell).join("")}</row>`).join("");
  const [main, office] = ["http://schemas.openxmlformats.org/spreadsheetml/2006/main", "http://schemas.openxmlformats.org/officeDocument/2006/relationships"];
  const relations = (type, target) =>
    `<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Id="r1" Type="${office}/${type}" Target="${target}"/></Relationships>`;
  const parts = {
    "[Content_Types].xml": '<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"/>',
    "_rels/.rels": relations("officeDocument", "xl/workbook.xml"),
    "xl/_rels/workbook.xml.rels": relations("worksheet", "worksheets/sheet1.xml"),
    "xl/workbook.xml": `<workbook xmlns="${main}" xmlns:r="${office}"><sheets><sheet name="errors" sheetId="1" r:id="r1"/></sheets></workbook>`,
    "xl/worksheets/sheet1.xml": `<worksheet xmlns="${main}"><sheetData>${sheet}</sheetData></worksheet>`,
  };
  return zipSync(Object.fromEntries(Object.entries(parts).map(([name, text]) => [name, Buffer.from(text)])));
}

const shown = () => page.$eval("main", (one) => one.innerText);

/** Waits until the page shows these words; what it shows instead is in the message. */
async function shows(words) {
  const found = page.waitForFunction((words) => new RegExp(words, "i").test(document.querySelector("main").innerText), { timeout: 30_000 }, words);
  await found.catch(async () => assert.fail(`no "${words}" in: ${await shown()}`));
}

/** What is shown, light and dark, on a desk, a tablet and a phone. */
async function inEachWindow(look) {
  for (const scheme of ["light", "dark"]) {
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    for (const width of [1280, 820, 390]) {
      await page.setViewport({ width, height: 900 });
      await page.evaluate(() => scrollTo(0, 0));
      await look(`${width}-${scheme}`);
    }
  }
  await page.emulateMediaFeatures([]);
  await page.setViewport({ width: 1280, height: 900 });
}

async function pictured(name) {
  if (!pictures) return;
  mkdirSync(pictures, { recursive: true });
  await inEachWindow((window) => page.screenshot({ path: join(pictures, `${name}-${window}.png`), fullPage: true }));
}

/** Serious faults that axe finds in what is shown. */
async function accessible(name) {
  await page.evaluate(axe);
  await inEachWindow(async (window) => {
    const found = await page.evaluate(() =>
      axe
        .run(document, { iframes: false })
        .then((all) => all.violations.filter((one) => ["serious", "critical"].includes(one.impact)))
        .then((all) => all.map((one) => `${one.id}: ${one.nodes.slice(0, 3).map((node) => node.html.slice(0, 120)).join(" | ")}`)),
    );
    assert.deepEqual(found, [], `${name}, ${window}: ${found}`);
  });
}

/** The kit that the program makes of a job. */
function programKit(folder, job) {
  const kit = join(scratch, `kit-${job}`);
  rmSync(kit, { recursive: true, force: true });
  try {
    execFileSync(program, ["generate", job, "-o", kit], { cwd: folder, stdio: "ignore" });
  } catch (ended) {
    assert.equal(ended.status, 1);
  }
  return new Map(readdirSync(kit).map((name) => [name, readFileSync(join(kit, name))]));
}

/** What a button saves. */
async function saved(button) {
  rmSync(downloads, { recursive: true });
  mkdirSync(downloads);
  if (!isFirefox) {
    const session = await page.createCDPSession();
    await session.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: downloads, browserContextId: page.browserContext().id });
  }
  await press(button);
  const isThere = (name) => name.endsWith(".zip") && statSync(join(downloads, name)).size > 0;
  for (let n = 0; n < 100 && !readdirSync(downloads).some(isThere); n++) await new Promise((done) => setTimeout(done, 100));
  return readFileSync(join(downloads, readdirSync(downloads).find(isThere)));
}

/** The kit as the page saves it. */
async function pageKit() {
  const all = unzipSync(await saved("Download the kit"));
  return new Map(Object.entries(all).map(([name, bytes]) => [name.replace(/^kit\//, ""), Buffer.from(bytes)]));
}

test("one file of at most 4 MB", async () => {
  await opened();
  await page.waitForFunction(() => performance.getEntriesByName("core").length);
  const [shownAt, coreAt] = await page.evaluate(() => ["shown", "core"].map((name) => performance.getEntriesByName(name)[0].startTime));
  const megabytes = readFileSync(file).length / 1e6;
  console.log(`# shown after ${shownAt.toFixed(0)} ms, core ready after ${coreAt.toFixed(0)} ms, ${megabytes.toFixed(2)} MB`);
  assert.ok(megabytes <= 4);
  await accessible("begin");
  await pictured("1-begin");
});

test("a visit from the first click to the page that is signed", async () => {
  await opened();
  await press("Try it");
  await settled();
  await page.waitForSelector(".verdict.pass");
  assert.match(await shown(), /EXX/);
  await accessible("result");
  await pictured("4-result");
  await go("job");
  await accessible("job");
  await pictured("2-job");
  await type("angle_urad ", "ten");
  await settled();
  await page.waitForSelector(".told");
  assert.match(await shown(), /angle_urad/);
  await pictured("2-job-wrong");
  await type("angle_urad ", "10");
  await settled();
  await go("measurement");
  await accessible("measurement");
  await pictured("3-measurement");
  await go("kit");
  await press("Make the kit");
  await page.waitForSelector(".file");
  await settled();
  await accessible("kit");
  await pictured("5-kit");
  const own = join(scratch, "start");
  cpSync(join(root, "fixtures/start/readings"), own, { recursive: true });
  assert.deepEqual([...(await pageKit()).keys()].sort(), [...programKit(own, "job.toml").keys()].sort());
  await go("second");
  await shows("pass");
  await shows("as left");
  await page.waitForSelector("iframe");
  await accessible("second");
  await pictured("6-second");
});

test("a new visit: what is empty is counted, a wrong cell is told at its cell, a block is pasted", async () => {
  await opened();
  await page.select(".begin select", "fanuc-30i");
  for (const [n, travel] of ["800", "500", "-400,0"].entries()) await page.type(`.three label:nth-child(${n + 1}) input`, travel);
  await press("Begin");
  await shows("write each travel as");
  await page.$eval(".three label:nth-child(3) input", (one) => one.select());
  await page.type(".three label:nth-child(3) input", "-400:0");
  await press("Begin");
  await page.waitForSelector(".row");
  await settled();
  assert.match(await shown(), /\d+ to fill in/);
  await pictured("2-job-new");
  // A list, key by key.
  await type("max_deviation_um ", "1 2");
  await settled();
  await shows('"1 2"');
  await type("max_deviation_um ", "10");
  await type("reserved_points ", "[]");
  assert.equal(await page.$eval('[aria-label="reserved_points "]', (one) => one.value), "[]");
  await go("measurement");
  const rows = await page.$$eval('[data-cell$=":1"]', (all) => all.length);
  await paste("0:2", Array.from({ length: Math.min(10, rows) }, (_, n) => `${n},5\t0,${n}\t0`).join("\r\n"));
  await settled();
  assert.match(await page.$eval(".notice", (one) => one.innerText), /0,5 became 0\.5/);
  assert.equal(await page.$eval('[data-cell="3:2"]', (one) => one.value), "3.5");
  assert.ok(await page.$(".chart polyline"));
  // Typed as fast as a gauge does: each value into its cell; a decimal comma is a point; what was there is replaced.
  const cell = (at) => page.$eval(`[data-cell="${at}"]`, (one) => one.value);
  await page.focus('[data-cell="5:2"]');
  await page.keyboard.press("ArrowDown");
  await page.keyboard.type("-12,8\n13\n14\n");
  assert.deepEqual([await cell("6:2"), await cell("7:2"), await cell("8:2")], ["-12.8", "13", "14"]);
  await page.focus('[data-cell="8:2"]');
  await page.keyboard.press("Home");
  await page.keyboard.type("2,"); // before what is there
  await page.focus('[data-cell="5:2"]');
  assert.equal(await cell("8:2"), "2.14");
  await paste("7:2", "1,234\t,5");
  assert.deepEqual([await cell("7:2"), await cell("7:3")], ["1.234", ".5"]);
  // A quotation mark is a fault of its cell; around a value it is none.
  await page.focus('[data-cell="9:2"]');
  await page.keyboard.type('1"');
  await settled();
  await page.waitForSelector('[data-cell="9:2"][aria-invalid=true]');
  assert.equal(await cell("9:2"), '1"');
  await paste("9:2", '"1.5"');
  assert.equal(await cell("9:2"), "1.5");
  for (const unclear of ["1,234\t2,345", "0,5\t1.234", "1,250.5"]) {
    await paste("7:2", unclear);
    assert.match(await page.$eval(".notice", (one) => one.innerText), /Nothing was pasted/);
  }
  await paste("7:3", "1\t2\t3");
  assert.match(await page.$eval(".notice", (one) => one.innerText), /more columns/);
  assert.deepEqual([await cell("7:2"), await cell("7:3")], ["1.234", ".5"]);
  await paste("7:3", "7");
  assert.equal(await cell("7:3"), "7");
  const last = await page.$eval(".grid", (one) => one.ariaRowCount - 1);
  await press("Add a row");
  await page.keyboard.type("9");
  assert.equal(await page.evaluate(() => document.activeElement.dataset.cell), `${last}:0`);
  assert.deepEqual([await cell(`${last}:0`), await cell(`${last - 1}:0`)], ["9", "z"]);
  await page.keyboard.type("\n8\n7"); // one value too many stays one value
  assert.equal(await cell(`${last}:0`), "7");
  await press("Remove row");
  await page.$eval(".grid", (one) => one.scrollTo(0, 0));
  await page.waitForSelector('[data-cell="4:3"]');
  await page.focus('[data-cell="4:3"]');
  await page.keyboard.type("x");
  await settled();
  await page.waitForSelector('[data-cell="4:3"][aria-invalid=true]');
  await pictured("3-measurement-wrong");
  await paste("0:2", Array(rows + 5).fill("0,5").join("\n"));
  assert.match(await noticed(), /became 0\.5.*(goes on from|rows were added)/);
  await paste("0:2", "1");
  await settled();
  assert.equal(await page.$(".notice"), null);
});

/** A job of each profile: the fixture, or that of the 840D sl with another control, which for some has a detection unit. */
function everyJob() {
  const from = join(root, "fixtures/nine_errors_900");
  const folder = join(scratch, "every-control");
  cpSync(from, folder, { recursive: true });
  const usual = readFileSync(join(from, "siemens-840d-sl.toml"), "utf8");
  const unit = usual.replace(/^\[(compensation\.axes\.[yz]|acceptance)\]/gm, "detection_unit_um = 1.0\n[$1]");
  const { controllers } = JSON.parse(execFileSync(program, ["controllers", "list", "--format", "json"], { encoding: "utf8" }));
  for (const { id } of controllers) {
    if (!existsSync(join(folder, `${id}.toml`))) writeFileSync(join(folder, `${id}.toml`), unit.replace("siemens-840d-sl", id));
  }
  return [folder, controllers.map(({ id }) => `${id}.toml`)];
}

const [folder, jobs] = everyJob();
for (const job of jobs) {
  test(`the kit is that of the program: ${basename(job, ".toml")}`, async () => {
    await opened();
    await choose([join(folder, job), join(folder, "errors.csv")]);
    await page.waitForFunction(() => document.querySelector("header .verdict"));
    await go("kit");
    await press("Make the kit");
    await page.waitForSelector(".file");
    const ms = await page.evaluate(() => performance.getEntriesByName("kit").at(-1).duration);
    console.log(`# ${job}: kit after ${ms.toFixed(0)} ms`);
    const [ours, theirs] = [await pageKit(), programKit(folder, job)];
    assert.deepEqual([...ours.keys()].sort(), [...theirs.keys()].sort());
    for (const [name, bytes] of theirs) assert.ok(bytes.equals(ours.get(name)), `${name} differs`);
  });
}

test("the visit is kept, saved as a folder that the program takes, and opened again; its volume turns", async () => {
  await opened();
  await press("Try it");
  await page.waitForSelector(".verdict.pass");
  await page.waitForSelector(".views");
  const arrows = () => page.$$eval(".views .before line", (all) => all.map((one) => one.getAttribute("x2")).join());
  const still = await arrows();
  await page.focus(".views");
  await page.keyboard.press("ArrowRight");
  assert.notEqual(await arrows(), still);
  await new Promise((done) => setTimeout(done, 300));
  await page.select("select[aria-label=Language]", "de");
  await new Promise((done) => setTimeout(done, 300));
  await page.reload();
  await page.waitForSelector("header .verdict.pass");
  assert.equal(await page.$eval("select[aria-label=Language]", (one) => one.value), "de");
  await page.select("select[aria-label=Language]", "en");
  const zip = await saved("Save the visit");
  for (const [name, bytes] of Object.entries(unzipSync(zip))) {
    mkdirSync(join(scratch, "again", dirname(name)), { recursive: true });
    writeFileSync(join(scratch, "again", name), bytes);
  }
  assert.ok(programKit(join(scratch, "again/visit"), "job.toml").has("manifest.json"));
  await opened();
  writeFileSync(join(scratch, "visit.zip"), zip);
  await choose([join(scratch, "visit.zip")]);
  await page.waitForSelector(".verdict.pass");
});

test("a job by hand keeps every byte but the value that is typed", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  const own = readFileSync(join(folder, "fanuc-30i.toml"), "utf8");
  const job = own
    .replace(/^name = .*$/m, 'name="old" # a # in a remark = "no key"')
    .replace(/^(first_set.*|\[compensation\].*)$/m, "$1\nreserved_points = [\n  [512, 767], # of others\n]")
    .replace(/\n/g, "\r\n");
  await drop([["job.toml", job], ["errors.csv", readFileSync(join(folder, "errors.csv"), "utf8")]]);
  await go("job");
  await type("name ", "VMC 900 ä");
  await settled();
  const zip = unzipSync(await saved("Save the visit"));
  const text = Buffer.from(zip["visit/job.toml"]).toString();
  const changed = text.split("\n").filter((line, n) => line !== job.split("\n")[n]);
  assert.deepEqual(changed.map((line) => line.trim()), ['name = "VMC 900 ä"                  # a # in a remark = "no key"']);
  await page.waitForSelector("header .verdict");
});

test("a spreadsheet with an error table becomes a CSV; any other one is refused where it is dropped", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  const rows = readFileSync(join(folder, "errors.csv"), "utf8").split("\n").filter((line) => line && !line.startsWith("#"));
  writeFileSync(join(scratch, "of sheet.xlsx"), workbook(rows.map((line) => line.split(","))));
  await choose([join(folder, "generic.toml"), join(folder, "errors.csv")]);
  await go("measurement");
  await choose([join(root, "fixtures/formats/workbook_selfmade.xlsx")]);
  assert.match(await noticed(), /workbook_selfmade.xlsx is not taken.*not recognised/);
  await choose([join(scratch, "of sheet.xlsx")]);
  assert.equal(await noticed().then((words) => words.replace(/\s*✕/, "")), "of sheet.csv is used now (generic.toml). errors.csv is kept.");
  assert.equal(await page.$eval('[data-cell="1:1"]', (one) => one.value), "30");
  await page.waitForSelector("header .verdict.pass");
  await go("kit");
  await press("Make the kit");
  await page.waitForSelector(".file");
  await go("second");
  await choose([join(scratch, "of sheet.xlsx")]);
  await shows("the same file, or a copy of it");
});

test("a table that the job names and that is not there is told as missing", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  await drop([["visit.zip", "PK"]]);
  assert.match(await noticed(), /visit.zip cannot be unpacked/);
  await drop([["job.toml", '[machine\nname = "A"']]);
  await shows("not valid TOML");
  await opened();
  await choose([join(folder, "generic.toml")]);
  await go("measurement");
  await shows("errors.csv, which the job names, is missing");
  await drop([["errors.csv", readFileSync(join(folder, "errors.csv"), "utf8")]]);
  assert.doesNotMatch(await noticed(), /kept/);
  await page.waitForSelector("header .verdict.pass");
});

test("a kit is judged as it stands: changed by hand it fails and is named as changed, of another job it is older", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  const [job, errors] = ["siemens-840d-sl.toml", "errors.csv"].map((name) => readFileSync(join(folder, name)));
  const kit = Object.fromEntries([...programKit(folder, "siemens-840d-sl.toml")].map(([name, bytes]) => [`kit/${name}`, bytes]));
  const table = Buffer.from(kit["kit/NONIUS_CEC.MPF"].toString().replace(/(\$AN_CEC\[\d+,5\]=)\S+/, "$10.9"));
  assert.ok(!table.equals(kit["kit/NONIUS_CEC.MPF"]));
  await chooseZip({ "job.toml": job, "errors.csv": errors, ...kit, "kit/NONIUS_CEC.MPF": table });
  await page.waitForSelector("header .verdict.fail");
  for (const step of ["result", "kit", "second"]) {
    await go(step);
    await shows("not as it was made");
    assert.doesNotMatch(await shown(), /older than|forecast: pass/i);
  }
  await go("result");
  await shows("NONIUS_CEC.MPF. was changed after it was made");
  await go("kit");
  assert.doesNotMatch(await shown(), /Download the kit/);
  await press("Make the kit again");
  await shows("up to date");
  await page.waitForSelector("header .verdict.pass");
  await go("job");
  await type("spacing_mm X", "60");
  await settled();
  await go("kit");
  await shows("older than the job");
});

test("a visit that replaces the kit of an older one is opened, saved and opened again with it", async () => {
  const from = join(root, "fixtures/nine_errors_900");
  const [old, upd] = ["old", "upd"].map((name) => join(scratch, "update", name));
  cpSync(from, old, { recursive: true });
  programKit(old, "generic.toml");
  cpSync(join(scratch, "kit-generic.toml"), join(old, "kit"), { recursive: true });
  execFileSync(program, ["new", "--from", "old/generic.toml", "-o", "upd"], { cwd: dirname(old), stdio: "ignore" });
  cpSync(join(from, "errors.csv"), join(upd, "errors.csv"));
  writeFileSync(join(upd, "job.toml"), readFileSync(join(upd, "job.toml"), "utf8").replace('date = ""', 'date = "2026-12-01"'));
  const files = ["old/kit", "upd"].flatMap((of) => readdirSync(join(scratch, "update", of)).map((name) => `${of}/${name}`));
  const read = (name) => readFileSync(join(scratch, "update", name));
  await opened();
  // As programs for Windows pack it.
  await chooseZip(Object.fromEntries(files.map((name) => [name.replaceAll("/", "\\"), read(name)])));
  await page.waitForFunction(() => document.querySelector("header .verdict"));
  await go("kit");
  await press("Make the kit");
  await shows("up to date");
  const kept = unzipSync(await saved("Save the visit"));
  for (const [name, bytes] of programKit(upd, "job.toml")) assert.ok(bytes.equals(Buffer.from(kept[`visit/upd/kit/${name}`])), `${name} differs`);
  await opened();
  await chooseZip(kept);
  await go("kit");
  await shows("up to date");
});

test("a second measurement that was dropped is judged", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  await choose([join(folder, "generic.toml"), join(folder, "errors.csv")]);
  await go("kit");
  await press("Make the kit");
  await page.waitForSelector(".file");
  await go("second");
  // As found once more, a little otherwise: the tables do not act.
  const again = readFileSync(join(folder, "errors.csv"), "utf8").replace(/,(-?\d+\.\d{9})/g, (_, um) => `,${(um * 1.01).toFixed(3)}`);
  await drop([["errors.csv", again]]);
  await shows("not as forecast");
  const kept = unzipSync(await saved("Save the visit"));
  assert.ok(readFileSync(join(folder, "errors.csv")).equals(Buffer.from(kept["visit/errors.csv"])), "the first measurement stays");
});

test("the visit is judged again by the second measurement that was dropped last", async () => {
  const before = await page.$eval("header .now", (one) => one.innerText);
  assert.match(before, /as left/i);
  writeFileSync(join(scratch, "second.zip"), await saved("Save the visit"));
  await opened();
  await choose([join(scratch, "second.zip")]);
  await go("second");
  assert.equal(await page.$eval("header .now", (one) => one.innerText), before);
});

test("a second job lies in a folder of its own with what it names, whatever the first one calls its table", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  const [job, errors] = ["generic.toml", "errors.csv"].map((name) => readFileSync(join(folder, name), "utf8"));
  await drop([["generic.toml", job], ["errors.csv", errors]]);
  await go("kit");
  await press("Make the kit");
  await page.waitForSelector(".file");
  await go("second");
  const left = errors.replace(/,(-?\d+\.\d{3})/g, (_, um) => `,${(um * 0.01).toFixed(3)}`);
  const active = job.replace(/^active_while_measuring = .*$/m, 'active_while_measuring = "../kit"');
  await drop([["job.toml", active], ["errors.csv", left], ["errors-2025.csv", errors]]);
  await shows("as left");
  assert.match(await page.$eval("header .now", (one) => one.innerText), /as left/i);
  const kept = unzipSync(await saved("Save the visit"));
  assert.deepEqual(
    Object.entries(kept).map(([name, bytes]) => [name, Buffer.from(bytes).toString()]).filter(([name]) => /errors.csv/.test(name)),
    [["visit/errors.csv", errors], ["visit/after/errors.csv", left]],
  );
  // A link of the framed report stays within it.
  const frame = await (await page.waitForSelector("iframe")).contentFrame();
  await frame.click("a[href^='#']");
  assert.ok(await frame.$("h1"));
});

test("a first measurement called after.csv stays the first one", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  const [job, errors] = ["generic.toml", "errors.csv"].map((name) => readFileSync(join(folder, name), "utf8"));
  await drop([["job.toml", job.replace("errors.csv", "after.csv")], ["after.csv", errors]]);
  await go("kit");
  await press("Make the kit");
  await page.waitForSelector(".file");
  await go("second");
  await shows("no second measurement");
  await drop([["after.csv", errors.replaceAll(".4", ".5")]]);
  await shows("as left");
  const kept = unzipSync(await saved("Save the visit"));
  assert.equal(Buffer.from(kept["visit/after.csv"]).toString(), errors);
});

test("of several jobs the person chooses; every wrong cell is marked", async () => {
  await opened();
  const folder = join(root, "fixtures/nine_errors_900");
  const wrong = readFileSync(join(folder, "errors.csv"), "utf8").replace(/^(x,(?:30|60|90|120|150)\.0+),[^,]*/gm, "$1,?");
  const all = ["generic.toml", "fanuc-30i.toml"].map((name) => [name, readFileSync(join(folder, name), "utf8")]);
  await drop([...all, ["errors.csv", wrong]]);
  await shows("several jobs");
  await press("fanuc-30i.toml");
  await go("measurement");
  const cells = await page.$$eval("[data-cell][aria-invalid=true]", (all) => all.map((one) => one.dataset.cell));
  assert.deepEqual(cells, ["1:2", "2:2", "3:2", "4:2", "5:2"]);
});

test("of two windows the one that was opened last keeps its visit, and the other says so", async () => {
  await opened();
  const first = page;
  page = await first.browserContext().newPage();
  await page.goto(pathToFileURL(file).href);
  await page.waitForSelector(".begin");
  await first.bringToFront();
  await first.evaluate(() => [...document.querySelectorAll("button")].find((one) => one.textContent.startsWith("Try it")).click());
  await first.waitForFunction(() => document.querySelector(".notice")?.innerText.includes("Another window"));
  await first.close();
});

test("nothing was asked of anybody, and nothing failed in silence", () => {
  assert.deepEqual(asked.filter((url) => !/^(file:|blob:|data:|about:)/.test(url)), []);
  assert.deepEqual(said, []);
});
