//! Largest differences of error vectors: golden figures of machine H, random machines against all pairs.
use crate::support::machine_h::{self, machine_h};
use crate::support::random_map::{self, Family, random_map};
use crate::support::{fixture, short_or};
use nalgebra::Vector3;
use nonius::quantity::Axis;
use nonius::volume::space::boxes::Boxes;
use nonius::volume::space::diameter::{self, Diameter, WindowMap, diameter};
use nonius::volume::space::grid_map::{AxisNode, GridMap, Node, Vector};
use nonius::volume::space::histogram::{Tolerance, estimate, exact, grouping};
use nonius::volume::space::pair::square;
use std::f64::consts::TAU;

/// All pairs, the smaller numbers first.
fn brute(vectors: &[Vector]) -> (f64, [usize; 2]) {
    let mut best = (0.0, [0, 0]);
    for (p, a) in vectors.iter().enumerate() {
        for (q, b) in vectors.iter().enumerate().skip(p) {
            if square(a, b) > best.0 {
                best = (square(a, b), [p, q]);
            }
        }
    }
    best
}

/// The largest error of a length of all pairs; `places` in m, along the chain.
fn brute_length(map: &GridMap, places: [&[f64]; 3]) -> f64 {
    let point = |n: usize| {
        let mut place = Vector3::zeros();
        for (role, axis) in map.chain().into_iter().enumerate() {
            place[axis as usize] = 1e6 * places[role][map.node(n)[role]];
        }
        (place, Vector3::from(map.at(map.node(n))))
    };
    let points: Vec<(Vector3<f64>, Vector3<f64>)> = (0..map.count()).map(point).collect();
    let mut largest = 0.0_f64;
    for (n, (p, e)) in points.iter().enumerate() {
        for (q, f) in &points[..n] {
            let (nominal, shift) = (p - q, e - f);
            let sum = nominal.norm() + (nominal + shift).norm();
            largest = largest.max((shift.dot(&(nominal * 2.0 + shift)) / sum).abs());
        }
    }
    largest
}

fn brute_in(map: &GridMap, low: Node, size: Node) -> (f64, [Node; 2]) {
    let is_inside = |node: &Node| (0..3).all(|c| (low[c]..low[c] + size[c]).contains(&node[c]));
    let numbers: Vec<Node> = (0..map.count()).map(|n| map.node(n)).filter(is_inside).collect();
    let vectors: Vec<Vector> = numbers.iter().map(|node| map.at(*node)).collect();
    let (square, pair) = brute(&vectors);
    (square.sqrt(), pair.map(|n| numbers[n]))
}

fn close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

fn machines(count: u64) -> impl Iterator<Item = (u64, Family)> {
    (0..count).zip(Family::ALL.into_iter().cycle())
}

/// Diameter of grid and cloud equal all pairs, to the last digit and to the same pair.
fn agrees(map: &GridMap, what: &str) -> Diameter {
    let vectors = map.vectors();
    let (square, pair) = brute(&vectors);
    let found = diameter(map);
    assert_eq!(found.um, square.sqrt(), "{what}: length");
    assert_eq!(found.nodes.map(|node| map.number(node)), pair, "{what}: pair");
    let cloud = diameter::longest(&vectors).unwrap();
    assert_eq!((cloud.square_um2, cloud.pair), (square, pair), "{what}: cloud");
    found
}

#[test]
fn machine_h_is_the_tabulated_one() {
    let text = fixture("machine_h/errors.csv");
    let rows = text.lines().filter(|line| line.starts_with(['x', 'y', 'z']));
    assert_eq!(rows.clone().count(), 13 + 9 + 7);
    for line in rows {
        let cells: Vec<&str> = line.split(',').collect();
        let value = |n: usize| -> f64 { cells[n].parse().unwrap() };
        let at = value(1) / 1000.0;
        let (shift, turn) = match cells[0] {
            "x" => machine_h::x_errors(at),
            "y" => machine_h::y_errors(at),
            // the table's positions of Z are rounded to a nanometre
            _ => (machine_h::z_errors((at * 3.0).round() / 3.0), [0.0; 3]),
        };
        for (c, found) in shift.into_iter().chain(turn).enumerate() {
            close(found, value(2 + c), 1e-8);
        }
    }
}

#[test]
fn volumetric_accuracy_of_machine_h_which_follows_the_frame() {
    for size in [[13, 9, 7], [21, 21, 21], [25, 17, 13], [41, 41, 41], [101, 101, 101]] {
        let found = diameter(&machine_h(size));
        close(found.um, 1149.980851990, 5e-10);
        assert_eq!(found.nodes, [[0, size[1] - 1, 0], [size[0] - 1, 0, size[2] - 1]], "{size:?}");
    }
    agrees(&machine_h([13, 9, 7]), "machine H");
    // Figure 2: x = 9 m, y = 3.5 m are nodes; z = 1.35 m is one of 41 steps of 0.05 m.
    let found = machine_h([13, 9, 41]).at([9, 7, 27]);
    for (found, expected) in found.into_iter().zip([204.915, -40.42545, 11.567]) {
        close(found, expected, 1e-9);
    }
    // The same machine aligned differently (docs/volume.md, 3).
    let map = machine_h([13, 9, 7]);
    for (of, along, slope, va_um) in [(0, 1, -77.0, 1281.8443665), (0, 2, 181.0, 2243.6426694)] {
        let turned = (0..map.count()).map(|n| {
            let [i, j, k] = map.node(n).map(|n| n as f64);
            let (place_m, mut error) = ([i, j / 2.0, k / 3.0], map.at(map.node(n)));
            error[of] -= slope * place_m[along];
            error[along] += slope * place_m[of];
            error
        });
        close(diameter::longest(&turned.collect::<Vec<_>>()).unwrap().um(), va_um, 1e-6);
    }
}

#[test]
fn length_error_of_machine_h() {
    let even = |n: u32, size: f64| -> Vec<f64> {
        (0..n).map(|k| size * f64::from(k) / f64::from(n - 1)).collect()
    };
    let [x, y, z] = [even(13, 12.0), even(9, 4.0), even(7, 2.0)];
    let all = brute_length(&machine_h([13, 9, 7]), [&x, &y, &z]);
    // 21³ and 41³ were compared with all pairs once.
    for (size, um) in [([13, 9, 7], all), ([21; 3], 1070.02959208), ([41; 3], 1070.73498974)] {
        let map = machine_h(size);
        let found = Boxes::of(&map).length_error(&diameter(&map), 1000);
        assert!(found.is_exact(), "{size:?}: {found:?}");
        close(found.um, um, 1e-8);
    }
}

#[test]
fn windows_of_machine_h() {
    // reference/volumetric.md §7.4: windows of 6 × 2 × 1 m
    for (grid, size, best, worst, place) in [
        ([13, 9, 7], [7, 5, 4], 501.126690, 641.359923, Some([6, 4, 3])),
        ([21, 21, 21], [11, 11, 11], 498.970269, 641.391107, Some([10, 9, 10])),
        ([25, 17, 13], [13, 9, 7], 500.169527, 641.359923, None),
    ] {
        let windows = WindowMap::of(&machine_h(grid), size).unwrap();
        close(windows.best().1.um, best, 5e-7);
        close(windows.worst().1.um, worst, 5e-7);
        close(windows.at([0; 3]).um, 601.522188, 5e-7);
        assert!(place.is_none_or(|place| windows.low(windows.best().0) == place), "{grid:?}");
    }
}

#[test]
fn histogram_and_grouping_of_machine_h() {
    let vectors = machine_h([21, 21, 21]).vectors();
    for threads in [1, 2, 3] {
        let counts = exact(&vectors, 10.0, threads).unwrap();
        assert_eq!(counts[..6], [75478, 428405, 874985, 1176614, 1336101, 1381424]);
        assert_eq!(counts[113..], [1, 2]);
        assert_eq!(counts.iter().sum::<u64>(), 42_878_430);
    }
    let vectors = machine_h([13, 9, 7]).vectors();
    for (angular, groups, records) in [(0.05, 315, 383), (0.1, 197, 240), (0.2, 103, 129)] {
        let found = grouping(&vectors, Tolerance { angular, magnitude: 0.9 });
        assert_eq!((found.groups, found.records.len()), (groups, records));
        close(found.longest.unwrap().um(), 1149.980851990, 5e-10);
    }
    // A constant error fools the grouping and nothing else.
    let shifted: Vec<Vector> = vectors.iter().map(|[x, y, z]| [x + 300.0, *y, *z]).collect();
    let exact = diameter::longest(&shifted).unwrap();
    close(exact.um(), 1149.980851990, 1e-9);
    let grouped = grouping(&shifted, Tolerance { angular: 0.2, magnitude: 0.9 }).longest.unwrap();
    assert!(grouped.um() <= exact.um());
}

#[test]
fn random_machines_against_all_pairs() {
    for (number, family) in machines(short_or(70, 560)) {
        let (chain, axes) = random_map::axes(number, family);
        let map = GridMap::new(chain, &axes).unwrap();
        let found = agrees(&map, &format!("machine {number}, {family:?}"));
        let vectors = map.vectors();
        let boxes = Boxes::of(&map);
        let holds = |(um, bound_um): (f64, f64), of_all: f64, steps: usize| {
            let what = format!("{number}, {steps} steps: {um} … {bound_um}, of all {of_all}");
            assert!(um <= of_all + 1e-8 && of_all <= bound_um + 1e-8, "{what}");
            assert!(um >= bound_um || steps < usize::MAX, "{what}");
        };
        let from = vectors[0].map(|um| um + 0.1);
        let far = vectors.iter().map(|v| square(v, &from).sqrt()).fold(0.0, f64::max);
        let arms =
            axes.each_ref().map(|axis| axis.iter().map(|node| node.arm_m).collect::<Vec<_>>());
        let length = brute_length(&map, arms.each_ref().map(Vec::as_slice));
        for steps in [0, 3, 30, usize::MAX].into_iter().filter(|_| number % 4 == 0) {
            let (one, two) = (boxes.furthest_from(from, steps), boxes.length_error(&found, steps));
            holds((one.um, one.bound_um), far, steps);
            holds((two.um, two.bound_um), length, steps);
        }
        let range = |c: usize| {
            let values = || vectors.iter().map(move |v| v[c]);
            let ends = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
            close(boxes.ranges()[c].0, ends.0, 1e-9);
            close(boxes.ranges()[c].1, ends.1, 1e-9);
            ends.1 - ends.0
        };
        let ranges = [0, 1, 2].map(range);
        let room = 1.0 + 1e-12;
        let box_um = ranges.iter().map(|r| r * r).sum::<f64>().sqrt();
        assert!(ranges.iter().all(|r| *r <= found.um * room) && found.um <= box_um * room);
        let grouped = grouping(&vectors, Tolerance { angular: 0.1, magnitude: 0.9 }).longest;
        assert!(grouped.is_none_or(|grouped| grouped.um() <= found.um));
    }
}

/// Grids too large for all pairs; the cloud looks at every vector.
#[test]
fn larger_random_machines_against_the_cloud() {
    for (number, family) in machines(short_or(35, 105)) {
        let (chain, axes) = random_map::axes_of(number, family, 20..75);
        let map = GridMap::new(chain, &axes).unwrap();
        let cloud = diameter::longest(&map.vectors()).unwrap();
        let found = diameter(&map);
        assert_eq!(found.um, cloud.um(), "{number}, {family:?}");
        assert_eq!(found.nodes.map(|node| map.number(node)), cloud.pair, "{number}, {family:?}");
    }
}

#[test]
fn windows_of_random_machines_against_all_pairs() {
    for (number, family) in machines(28) {
        let map = random_map(1000 + number, family);
        let whole = map.size();
        let size = whole.map(|n| n.div_ceil(2));
        let windows = WindowMap::of(&map, size).unwrap();
        let all = diameter(&map);
        for (n, figure) in windows.figures.iter().enumerate() {
            let low = windows.low(n);
            assert_eq!((figure.um, figure.nodes), brute_in(&map, low, size), "{number} {low:?}");
            assert!(figure.um <= all.um);
        }
        assert_eq!(WindowMap::of(&map, whole).unwrap().figures, [all]);
        assert!([whole[0] + 1, 0].iter().all(|n| WindowMap::of(&map, [*n, 1, 1]).is_none()));
    }
}

/// Nodes of one axis that does not turn, from a function of the place 0…1.
fn axis(count: usize, shift: impl Fn(f64) -> Vector) -> Vec<AxisNode> {
    let at = (0..count).map(|n| n as f64 / (count.max(2) - 1) as f64);
    at.map(|t| AxisNode { translation_um: shift(t), rotation_urad: [0.0; 3], arm_m: t }).collect()
}

#[test]
fn degenerate_maps() {
    let map_of = |axes| GridMap::new(Axis::ALL, &axes).unwrap();
    let none = |count| axis(count, |_| [0.0; 3]);
    let constant = |count| axis(count, |_| [0.1, 0.7, -2000.3]);
    let circle = |count, r: f64| axis(count, |t| [r * (TAU * t).cos(), r * (TAU * t).sin(), 0.0]);
    let upright = |count| axis(count, |t| [0.0, 9.0 * (TAU * t).sin(), 9.0 * (TAU * t).cos()]);
    let line =
        |count, c: usize| axis(count, |t| [0, 1, 2].map(|n| if n == c { 10.0 * t } else { 0.0 }));
    let jump = |count| axis(count, |t| [if t > 0.4 && t < 0.6 { 5.0 } else { 0.0 }, 0.0, 0.0]);
    let tiny = |count| {
        let mut axis = axis(count, |t| [2000.0 + 1e-13 * t, 0.1, 0.3]);
        axis.iter_mut().for_each(|node| node.rotation_urad = [1e-15 * node.arm_m; 3]);
        axis
    };
    for (what, axes) in [
        ("one node", [none(1), none(1), none(1)]),
        ("zero", [none(9), none(8), none(7)]),
        ("constant", [constant(9), constant(8), constant(7)]),
        ("first axis only", [circle(9, 3.0), none(9), none(9)]),
        ("second axis only", [none(9), circle(9, 3.0), none(9)]),
        ("third axis only", [none(9), none(9), circle(9, 3.0)]),
        ("circle", [circle(60, 3.0), none(1), none(1)]),
        ("two circles", [circle(12, 3.0), circle(10, 3.0), none(5)]),
        ("torus", [circle(12, 5.0), upright(10), none(5)]),
        ("cube with ties", [line(7, 0), line(7, 1), line(7, 2)]),
        ("lines on each other", [line(7, 1), line(7, 1), line(7, 1)]),
        ("one node differs", [jump(11), none(10), none(9)]),
        ("lost in rounding", [tiny(8), constant(8), tiny(8)]),
        ("two axes of one node", [none(1), none(1), line(5, 2)]),
    ] {
        agrees(&map_of(axes), what);
    }
    // Large ones come to an end.
    let step = |count| axis(count, |t| [if t > 0.5 { 5.0 } else { 0.0 }, 0.0, 0.0]);
    let found = diameter(&map_of([constant(401), constant(401), constant(401)]));
    assert_eq!(found, Diameter { um: 0.0, nodes: [[0; 3]; 2] });
    let found = diameter(&map_of([step(401), step(401), step(401)]));
    assert_eq!(found, Diameter { um: 15.0, nodes: [[0, 0, 0], [201, 201, 201]] });
    close(diameter(&map_of([circle(401, 1.0), none(401), none(401)])).um, 2.0, 1e-12);
    close(diameter(&map_of([circle(101, 1.0), circle(101, 1.0), none(101)])).um, 4.0, 1e-12);
}

#[test]
fn the_map_is_the_sum_of_its_cross_products() {
    let cross = |a: Vector, b: Vector| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let along = |axis, arm: f64| Axis::ALL.map(|a| if a == axis { arm } else { 0.0 });
    let plus = |a: Vector, b: Vector| [0, 1, 2].map(|c| a[c] + b[c]);
    let mut chains = std::collections::BTreeSet::new();
    for number in 0..40 {
        let (chain, axes) = random_map::axes(number, Family::Smooth);
        chains.insert(chain.map(Axis::letter));
        let map = GridMap::new(chain, &axes).unwrap();
        for n in 0..map.count() {
            let [i, j, k] = map.node(n);
            assert_eq!(map.number([i, j, k]), n);
            let [a, b, c] = [&axes[0][i], &axes[1][j], &axes[2][k]];
            let third = along(chain[2], c.arm_m);
            let arm = plus(along(chain[1], b.arm_m), third);
            let shift = plus(plus(a.translation_um, b.translation_um), c.translation_um);
            let turn = plus(cross(a.rotation_urad, arm), cross(b.rotation_urad, third));
            let (found, expected) = (map.at([i, j, k]), plus(shift, turn));
            for c in 0..3 {
                close(found[c], expected[c], 1e-11);
            }
        }
    }
    assert_eq!(chains.len(), 6, "every chain was seen");
}

#[test]
fn unsound_maps_are_refused() {
    let sound = || axis(3, |t| [t, 0.0, 0.0]);
    assert!(GridMap::new(Axis::ALL, &[sound(), sound(), sound()]).is_some());
    assert!(GridMap::new([Axis::X, Axis::X, Axis::Z], &[sound(), sound(), sound()]).is_none());
    let broken: [fn(&mut Vec<AxisNode>); 3] =
        [|axis| axis.reverse(), |axis| axis.clear(), |axis| axis[1].translation_um[2] = f64::NAN];
    for break_it in broken {
        let mut axis = sound();
        break_it(&mut axis);
        assert!(GridMap::new(Axis::ALL, &[sound(), axis, sound()]).is_none());
    }
    assert!(diameter::longest(&[]).is_none());
    assert!(diameter::longest(&[[0.0; 3], [f64::INFINITY, 0.0, 0.0]]).is_none());
}

#[test]
fn histogram_against_all_pairs() {
    for (number, family) in machines(21) {
        let map = random_map(number, family);
        let vectors = map.vectors();
        let um = diameter(&map).um;
        // the width 2⁻ⁿ puts lengths onto edges; a width of a millionth has no rough distances
        for bin_um in [um / 7.0, 0.5_f64.powi(3), um / 4000.0] {
            if um / bin_um >= 4095.0 || um <= 0.0 {
                continue;
            }
            let mut expected = vec![0; (um / bin_um) as usize + 1];
            for (n, p) in vectors.iter().enumerate() {
                for q in &vectors[n + 1..] {
                    expected[(square(p, q).sqrt() / bin_um) as usize] += 1;
                }
            }
            assert_eq!(exact(&vectors, bin_um, 2).unwrap(), expected, "{number}");
        }
    }
    assert!(exact(&[[0.0; 3]], 0.0, 1).is_none());
    assert_eq!(exact(&[[0.0; 3]], 1.0, 1), Some(vec![0]));
}

#[test]
fn estimated_histogram_is_within_its_standard_errors() {
    let map = machine_h([21, 21, 21]);
    let exact = exact(&map.vectors(), 10.0, 1).unwrap();
    let found = estimate(&map, 10.0, 400_000, 1502).unwrap();
    assert_eq!(found, estimate(&map, 10.0, 400_000, 1502).unwrap());
    assert_ne!(found.counts, estimate(&map, 10.0, 400_000, 1503).unwrap().counts);
    close(found.counts.iter().flatten().sum(), 42_878_430.0, 2.0);
    let last = found.counts.last().unwrap();
    assert!(last.is_some_and(|n| n >= 1.0), "the last bin holds the largest difference");
    let mut all = found.counts.iter().chain(&found.standard_errors);
    assert!(all.all(|value| *value != Some(0.0)), "a zero that nobody counted: {found:?}");
    let (mut within, mut judged, mut chi) = (0, 0, 0.0);
    for (n, exact) in exact.iter().enumerate().filter(|(_, exact)| **exact > 10_000) {
        let off = (found.counts[n].unwrap() - *exact as f64) / found.standard_errors[n].unwrap();
        assert!(off.abs() < 4.5, "bin {n}: {off} standard errors");
        (within, judged, chi) = (within + i32::from(off.abs() < 2.0), judged + 1, chi + off * off);
    }
    assert!(judged > 60 && within * 100 > judged * 88, "{within} of {judged}");
    let mean = chi / f64::from(judged);
    assert!((0.6..1.5).contains(&mean), "mean square {mean}");
}
