//! Whoever leaves a true statement out gets no better verdict, and without `noise_um` not more passes.

use crate::support::{Visit, share};

const TRUE: [&str; 5] = [
    "angle_urad = 10.0",
    "setup_ppm = 1.0",
    "beam_mrad = 1.0",
    "laser_ppm = 0.5",
    "u_um_per_m = 0.5",
];
const SIGMA_UM: f64 = 0.4;

/// 0 fail, 1 undecided, 2 pass.
fn verdict(visit: &Visit, job: &str) -> usize {
    let made = visit.put("stated.toml", job).run("generate stated.toml -o kit");
    std::fs::remove_dir_all(visit.at("kit")).unwrap();
    let says = |word: &&str| made.out.contains(&format!("verdict: {word}"));
    ["fail", "undecided", "pass"].iter().position(says).unwrap()
}

#[test]
fn silence_is_never_better() {
    let visit = Visit::of("start/readings");
    let stated =
        format!("[measurement.uncertainty]\n{}\n{}\nnoise_um = {SIGMA_UM}\n", TRUE[2], TRUE[3]);
    visit.edit("job.toml", "[measurement.uncertainty]", &stated);
    let (all, mut passes) = (share(200, 2), [0, 0]);
    for number in 0..all {
        let limit = 1.6 + 0.4 * (number % 5) as f64;
        let (noise, seed) = (format!("--noise-um {SIGMA_UM}"), 7000 + number);
        let out = "-o new.csv --without-tables --force --runs 2";
        visit.yes(&format!("simulate job.toml {noise} --seed {seed} {out}"));
        let job = visit.read("job.toml").replace("readings.csv", "new.csv");
        let job = job.replace("max_deviation_um = 10.0", &format!("max_deviation_um = {limit}"));
        let honest = verdict(&visit, &job);
        for key in TRUE {
            let silent = verdict(&visit, &job.replace(key, ""));
            assert!(silent <= honest, "{limit} µm, seed {seed}, without {key}");
        }
        let without_noise = verdict(&visit, &job.replace("noise_um", "# noise_um"));
        passes[0] += usize::from(honest == 2);
        passes[1] += usize::from(without_noise == 2);
    }
    println!("of {all} visits {} pass, {} without noise_um", passes[0], passes[1]);
    assert!(passes[1] <= passes[0] && (all < 10 || (1..all as usize).contains(&passes[0])));
}
