//! Part programs without end are refused after 20 million blocks, the largest ones run to their end. Each takes
//! seconds unoptimised: plain `cargo test` runs that of fixtures/cases/refuses/path.txt alone.
use crate::support::{Ran, Visit, short_or};

fn path(program: &str) -> Ran {
    let visit = Visit::of("base/part");
    visit.put("part.nc", program).run("path job.toml part.nc --format json")
}

#[test]
fn a_program_without_end_is_refused_with_its_reason() {
    let holes = "G81 X0 R1 Z-1 K9999\n".repeat(1100);
    let calls = [
        ("M98 P1 L99999999\nM30\nO1\nM99", "1\n"),
        ("G54 G90 G1 X0 Y0 Z0\n\nM98 P1 L99999999\nM30\nO1\nX100\nX0\nM99", "3\n"),
        ("G91 G1\nM98 P1 L9999\nM30\nO1\nX0\nM98 P2 L9999\nM99\nO2\nX1\nX-1\nM99", "2\n"),
        (&format!("G54 G91 G0 X0 Y0 Z0\n{holes}M30"), ""),
    ];
    let says = "more than 20000000 blocks and mm; the last of them begin in line ";
    for (program, line) in &calls[..short_or(0, 4)] {
        path(program).ends(2).says(&format!("{says}{line}")).says("L and P of M98");
    }
    let loops = ["N10 G1 X1\nGOTO 10", "#1=0\nWHILE [#1 EQ 0] DO1\nEND1"];
    for program in &loops[..short_or(0, 2)] {
        path(program).ends(2).says("more than 20000000 blocks");
    }
}

/// The largest programs seen have 60 MB, three million blocks and 10 km.
#[test]
fn a_large_program_is_executed_to_its_end() {
    let lines = "X3\nX-3\n".repeat(short_or(15_000, 1_500_000));
    let called = format!("G54 G91 G1 X0 Y0 Z0\nM98 P1\nM30\nO1\n{lines}M99");
    assert_eq!(path(&called).json()["blocks"], short_or(30_005, 3_000_005));
}
