//! Draws what a kit does: every measured term before and after, as an SVG on standard output.
//!
//! `cargo run --release --example before_after -- fixtures/nine_errors_900/fanuc-30i.toml > docs/before-after.svg`
//!
//! The curve "after" is measured deviation + correction, with the correction emulated from the
//! bytes of the files, as in the forecast.
#![allow(clippy::print_stdout, reason = "a script that prints its picture")]

use nonius::control::controller::builtin;
use nonius::inputs::error_table::ErrorTable;
use nonius::inputs::job::{Job, MeasuredData};
use nonius::kit::{Inputs, Kit, emulator, generate};
use nonius::quantity::axis::{Axis, Direction, ErrorTerm};
use nonius::quantity::units::Millimetres;
use nonius::read::emulate::Emulator;
use nonius::text::document::Source;
use nonius::text::problem::{Problem, Problems};
use nonius::write::plan::axis_pairs;
use std::fmt::Write;
use std::path::Path;
use std::process::ExitCode;

const PANEL_WIDTH: f64 = 250.0;
const PANEL_HEIGHT: f64 = 110.0;
const LEFT: f64 = 46.0;
const TOP: f64 = 64.0;
const GAP_X: f64 = 34.0;
const GAP_Y: f64 = 38.0;
const SAMPLES: u32 = 600;

fn main() -> ExitCode {
    let Some(job) = std::env::args().nth(1) else {
        println!("usage: before_after JOB");
        return ExitCode::from(2);
    };
    match picture(Path::new(&job)) {
        Ok(svg) => {
            println!("{svg}");
            ExitCode::SUCCESS
        }
        Err(problems) => {
            println!("{problems}");
            ExitCode::from(2)
        }
    }
}

fn source(path: &Path) -> Result<Source, Problems> {
    let bytes = std::fs::read(path)
        .map_err(|error| Problem::new(format!("{}: {error}", path.display())))?;
    Source::from_bytes(&path.display().to_string(), &bytes)
}

fn picture(path: &Path) -> Result<String, Problems> {
    let job = Job::read(source(path)?)?;
    let MeasuredData::Errors(paths) = &job.measurement.data else {
        return Err(Problem::new("the job has readings, expected an error table").into());
    };
    let [errors] = &paths[..] else {
        return Err(Problem::new("the job has several error tables, expected one").into());
    };
    let table = ErrorTable::read(source(&path.with_file_name(errors))?)?;
    let profile = builtin::profile(&job.compensation.controller)?;
    let inputs = Inputs::new(job, profile, &table, Vec::new())?;
    let kit = generate(&inputs)?;
    let control = emulator(&inputs.profile, &kit.compiled.tables, &kit.compiled.state)
        .map_err(|reason| Problem::new(reason.0))?;
    draw(&inputs, &kit, control.as_ref())
}

/// Deviation before and after at places over the measured range: (mm, µm, µm).
fn samples(
    inputs: &Inputs,
    kit: &Kit,
    control: &dyn Emulator,
    term: ErrorTerm,
) -> Option<Vec<(f64, f64, f64)>> {
    let measured = inputs.model.terms[term].as_ref()?;
    let curve = measured.measured.curve(Direction::Plus)?;
    let (from, to) = curve.measured_range();
    let (base, output) = axis_pairs(&kit.plan.names, term).first().copied()?;
    let response = control.response(base, output, Direction::Plus).ok()?;
    let at = |part: u32| {
        let mm = from.mm() + (to.mm() - from.mm()) * f64::from(part) / f64::from(SAMPLES);
        let deviation = curve.at(Millimetres::new(mm));
        let after = deviation + response.correction(Millimetres::new(mm));
        (mm, deviation.um(), after.um())
    };
    Some((0..=SAMPLES).map(at).collect())
}

fn draw(inputs: &Inputs, kit: &Kit, control: &dyn Emulator) -> Result<String, Problems> {
    let largest = kit
        .forecast
        .terms
        .iter()
        .map(|t| t.change.before_um)
        .fold(1.0, f64::max);
    let scale_um = (largest / 5.0).ceil() * 5.0;
    let width = LEFT + 3.0 * PANEL_WIDTH + 2.0 * GAP_X + 16.0;
    let height = TOP + 3.0 * PANEL_HEIGHT + 3.0 * GAP_Y;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    let title = format!(
        "<text x=\"{LEFT}\" y=\"20\" font-size=\"14\">{}: nine errors before and after, {}</text>\n<text x=\"{LEFT}\" y=\"38\"><tspan fill=\"#c0504d\">as measured</tspan> and <tspan fill=\"#1f6fb4\">with the tables (emulated from the written bytes)</tspan>, ±{scale_um} µm</text>\n",
        inputs.job.machine.name, inputs.profile.name
    );
    svg.push_str(&title);
    let columns = [
        LEFT,
        LEFT + PANEL_WIDTH + GAP_X,
        LEFT + 2.0 * (PANEL_WIDTH + GAP_X),
    ];
    let rows = [
        TOP,
        TOP + PANEL_HEIGHT + GAP_Y,
        TOP + 2.0 * (PANEL_HEIGHT + GAP_Y),
    ];
    for (along, x) in Axis::ALL.into_iter().zip(columns) {
        for (of, y) in Axis::ALL.into_iter().zip(rows) {
            let term = ErrorTerm { of, along };
            let points = samples(inputs, kit, control, term);
            panel(&mut svg, term, (x, y), scale_um, points.as_deref())
                .map_err(|_| Problem::new("the picture cannot be put together"))?;
        }
    }
    svg.push_str("</svg>");
    Ok(svg)
}

fn panel(
    svg: &mut String,
    term: ErrorTerm,
    (x, y): (f64, f64),
    scale_um: f64,
    points: Option<&[(f64, f64, f64)]>,
) -> std::fmt::Result {
    let middle = y + PANEL_HEIGHT / 2.0;
    writeln!(
        svg,
        "<rect x=\"{x}\" y=\"{y}\" width=\"{PANEL_WIDTH}\" height=\"{PANEL_HEIGHT}\" fill=\"none\" stroke=\"#999\"/>"
    )?;
    writeln!(
        svg,
        "<line x1=\"{x}\" y1=\"{middle}\" x2=\"{}\" y2=\"{middle}\" stroke=\"#ccc\"/>",
        x + PANEL_WIDTH
    )?;
    writeln!(
        svg,
        "<text x=\"{}\" y=\"{}\" font-weight=\"bold\">{term}</text>",
        x + 6.0,
        y + 15.0
    )?;
    for (um, at) in [(scale_um, y + 9.0), (-scale_um, y + PANEL_HEIGHT)] {
        writeln!(
            svg,
            "<text x=\"{}\" y=\"{at}\" text-anchor=\"end\" fill=\"#666\">{um:+}</text>",
            x - 4.0
        )?;
    }
    let Some(points) = points else {
        return writeln!(
            svg,
            "<text x=\"{}\" y=\"{middle}\">not measured</text>",
            x + 90.0
        );
    };
    let (first, last) = (points[0].0, points[points.len() - 1].0);
    let bottom = y + PANEL_HEIGHT + 13.0;
    writeln!(
        svg,
        "<text x=\"{x}\" y=\"{bottom}\" fill=\"#666\">{first}</text>"
    )?;
    writeln!(
        svg,
        "<text x=\"{}\" y=\"{bottom}\" text-anchor=\"end\" fill=\"#666\">{} {last} mm</text>",
        x + PANEL_WIDTH,
        term.along
    )?;
    for (colour, pick) in [("#c0504d", 1), ("#1f6fb4", 2)] {
        let mut path = String::new();
        for point in points {
            let um = if pick == 1 { point.1 } else { point.2 };
            let px = x + (point.0 - first) / (last - first) * PANEL_WIDTH;
            let py = middle - um / scale_um * PANEL_HEIGHT / 2.0;
            write!(path, "{px:.1},{py:.1} ")?;
        }
        writeln!(
            svg,
            "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.4\" points=\"{}\"/>",
            path.trim_end()
        )?;
    }
    Ok(())
}
