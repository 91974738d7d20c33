//! Volumetric accuracy of a grid: the exact largest difference of two error vectors.
//!
//! Branch and bound over directions instead of pairs. A cell of directions is dropped as soon
//! as the vectors do not reach far enough along it; in what is left only vectors near both ends
//! can be the pair, and those few are compared. A direction costs about as many steps as the
//! grid has nodes on its three axes together.
//!
//! Volumetric accuracy of every sub-volume of a size: which place in the machine is best.
//!
//! One position of a small volume says little: on machine H a volume of 6 × 2 × 1 m has 499 µm
//! at its best place and 641 µm at its worst. So the map is given, with its extremes and the
//! corner.

use crate::space::grid_map;
use crate::space::grid_map::{
    ARM, AxisAtNode, BY_SECOND, BY_THIRD, GridMap, Interval, Node, ROLL, Vector, Window, last_row,
    tree,
};
use crate::space::pair::{
    DirectionCell, Ends, Frame, Longest, NumberedVector, dot, minus, room, search, square, unit,
};

/// Smallest cosine of a cell whose ends are listed rather than the cell cut.
const NARROW: f64 = 0.94;

/// Vectors listed at one end at most.
const LISTED: usize = 512;

/// Turns along the longest pair found so far, each towards a longer one.
const TURNS: usize = 16;

/// A map whose largest difference is within so many rounding errors is treated as a cloud.
const LOST_IN_ROUNDING: f64 = 4096.0;

/// The largest difference of two error vectors, and the nodes where they are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diameter {
    /// Length of the difference, µm.
    pub um: f64,
    /// The two nodes, in the order of [`GridMap::number`].
    pub nodes: [Node; 2],
}

/// The largest difference of two error vectors of the whole grid.
///
/// what   max over all pairs of |e_p − e_q| (paper 002, section 4.1), µm
/// source branch and bound over directions, docs/volume.md §6
/// limits exact: the largest of all squares as [`super::pair::square`] computes them; of several
///        pairs with the same square the one with the smallest numbers
pub fn diameter(map: &GridMap) -> Diameter {
    within(map, Window { low: [0; 3], size: map.size() }, None)
}

/// The largest difference within a window; a guess inside it makes the search shorter.
fn within(map: &GridMap, window: Window, guess: Option<[Node; 2]>) -> Diameter {
    let longest = Longest::none(map.number(window.low));
    let mut search =
        Search { map, nodes: map.distinct(window), longest, room: room(map.size_um()) };
    if let Some([p, q]) = guess {
        search.longest.offer(&search.point(p), &search.point(q));
    }
    let mut level: Vec<DirectionCell> = DirectionCell::half_sphere().collect();
    while !level.is_empty() {
        level.retain(|cell| search.visit(*cell));
        if search.longest.um() <= LOST_IN_ROUNDING * search.room {
            search.as_cloud();
            break;
        }
        level = level.into_iter().flat_map(DirectionCell::quarters).collect();
    }
    let Longest { pair, .. } = search.longest;
    Diameter { um: search.longest.um(), nodes: pair.map(|number| map.node(number)) }
}

/// A search for the largest difference.
struct Search<'a> {
    map: &'a GridMap,
    /// The nodes that count, of axis 1, 2 and 3.
    nodes: [Vec<usize>; 3],
    longest: Longest,
    room: f64,
}

impl Search<'_> {
    fn point(&self, node: Node) -> NumberedVector {
        NumberedVector { at: self.map.at(node), number: self.map.number(node) }
    }

    /// What the vectors must reach along a cell for a difference as long as the longest one.
    fn needed(&self, cell: DirectionCell) -> f64 {
        self.longest.um() * cell.cosine() - self.room
    }

    /// The vectors along a direction and how far they reach to both sides, `None` where that is less than `needed`. The
    /// pair there is offered: true where it is longer.
    fn reach(&mut self, d: &Vector, needed: f64) -> Option<(Sight, [f64; 2], bool)> {
        let sight = Sight::of(self.map, &self.nodes, d);
        let (high, top) = sight.furthest(AHEAD, needed - sight.bound(BEHIND))?;
        let (depth, bottom) = sight.furthest(BEHIND, needed - high)?;
        let [top, bottom] = [top, bottom].map(|places| self.seen(places));
        Some((sight, [high, depth], self.longest.offer(&top, &bottom)))
    }

    /// A node by its places in the lists of the window.
    fn seen(&self, places: Node) -> NumberedVector {
        self.point([0, 1, 2].map(|axis| self.nodes[axis][places[axis]]))
    }

    /// Turns along the longest pair as long as that finds a longer one.
    fn turn(&mut self) {
        for _ in 0..TURNS {
            let [p, q] = self.longest.pair.map(|n| self.map.at(self.map.node(n)));
            let needed = self.longest.um() - self.room;
            let reached = unit(minus(&p, &q)).and_then(|d| self.reach(&d, needed));
            if !reached.is_some_and(|(.., longer)| longer) {
                break;
            }
        }
    }

    /// Looks into a cell of directions; true where it has to be cut.
    fn visit(&mut self, cell: DirectionCell) -> bool {
        let reached = self.reach(&cell.direction(), self.needed(cell));
        let Some((sight, [high, depth], longer)) = reached else {
            return false;
        };
        if longer {
            self.turn();
        }
        let needed = self.needed(cell);
        let fine = cell.is_fine(self.longest.um(), self.room);
        if !fine && cell.cosine() <= NARROW {
            return high + depth >= needed;
        }
        let most = if fine { usize::MAX } else { LISTED };
        let list = |side, least| -> Option<Vec<NumberedVector>> {
            let nodes = sight.beyond(side, least, most)?;
            Some(nodes.into_iter().map(|places| self.seen(places)).collect())
        };
        let lists = list(AHEAD, needed - depth)
            .and_then(|top| Some(Ends { top, bottom: list(BEHIND, needed - high)? }));
        let Some(ends) = lists else { return true };
        let middle = self.map.at(self.map.node(self.longest.pair[0]));
        search(cell, &ends, Frame { middle, room: self.room }, &mut self.longest);
        false
    }

    /// All vectors, where the map is constant but for rounding.
    fn as_cloud(&mut self) {
        let [first, second, third] = &self.nodes;
        let lines = first.iter().flat_map(|i| second.iter().map(move |j| (*i, *j)));
        let nodes = lines.flat_map(|(i, j)| third.iter().map(move |k| [i, j, *k]));
        let numbers: Vec<usize> = nodes.map(|node| self.map.number(node)).collect();
        let vector = |number: &usize| self.map.at(self.map.node(*number));
        let vectors: Vec<Vector> = numbers.iter().map(vector).collect();
        if let Some(longest) = longest(&vectors) {
            self.longest = Longest { pair: longest.pair.map(|place| numbers[place]), ..longest };
        }
    }
}

// How far the vectors of a grid reach along a direction, without looking at all of them.
//
// Along a direction d the map is a sum of a few numbers an axis,
// f(i,j,k) = α_i + γ_i·y_j + μ_j + (β_i + ν_j)·z_k + κ_k. Every axis is a tree with the ranges of its numbers; from a
// branch of each axis follows what no f in that box exceeds. A box that may reach far enough is cut across the axis that
// was cut least, down to single nodes, the half with the higher bound first.

/// The side of a direction where it points.
const AHEAD: f64 = 1.0;
/// The other side.
const BEHIND: f64 = -1.0;

/// The sum f along a direction.
struct Sight {
    /// Of each axis what it adds, by itself and for a metre of axis 2 and 3, and its lever.
    trees: [Vec<[Interval; 4]>; 3],
    /// Nodes of each axis.
    size: Node,
}

impl Sight {
    /// Some nodes of each axis, seen along `d`.
    fn of(map: &GridMap, nodes: &[Vec<usize>; 3], d: &Vector) -> Sight {
        let d = map.along_chain(*d);
        let numbers = |row: &AxisAtNode| {
            [
                Interval::of(dot(&d, &[row[0], row[1], row[2]])),
                Interval::of(d[0] * row[BY_SECOND] + d[2] * row[ROLL]),
                Interval::of(d[0] * row[BY_THIRD] - d[1] * row[ROLL]),
                Interval::of(row[ARM]),
            ]
        };
        let trees = [0, 1, 2]
            .map(|axis| tree(nodes[axis].iter().map(|n| numbers(&map.rows[axis][*n])).collect()));
        Sight { trees, size: nodes.each_ref().map(Vec::len) }
    }

    /// What no node reaches beyond on a side.
    fn bound(&self, side: f64) -> f64 {
        self.bound_of([1; 3], side)
    }

    fn bound_of(&self, [i, j, k]: [usize; 3], side: f64) -> f64 {
        let (a, b, c) = (&self.trees[0][i], &self.trees[1][j], &self.trees[2][k]);
        let f = ((a[0] + b[0]) + c[0]) + (a[1] * b[3] + (a[2] + b[2]) * c[3]);
        if side > 0.0 { f.high } else { -f.low }
    }

    /// The node that reaches furthest to a side, and how far; `None` where that is less than `least`.
    fn furthest(&self, side: f64, least: f64) -> Option<(f64, Node)> {
        let mut best = None;
        self.seek([1; 3], side, least, &mut |reach: f64, node| {
            best = Some((reach, node));
            reach.next_up()
        });
        best
    }

    /// The nodes that reach `least` on a side; `None` where they are more than `most`.
    fn beyond(&self, side: f64, least: f64, most: usize) -> Option<Vec<Node>> {
        let mut nodes = Vec::new();
        self.seek([1; 3], side, least, &mut |_, node| {
            nodes.push(node);
            if nodes.len() > most { f64::INFINITY } else { least }
        });
        (nodes.len() <= most).then_some(nodes)
    }

    /// Tells `found` of the nodes in a box that reach `least`; its answer is the `least` from there on. Returns the last.
    fn seek(
        &self,
        branches: [usize; 3],
        side: f64,
        mut least: f64,
        found: &mut impl FnMut(f64, Node) -> f64,
    ) -> f64 {
        let cut = (0..3).filter(|axis| branches[*axis] < self.size[*axis]);
        let Some(axis) = cut.min_by_key(|axis| branches[*axis]) else {
            let node = [0, 1, 2].map(|axis| last_row(branches[axis], self.size[axis]));
            return found(self.bound_of(branches, side), node);
        };
        let [mut one, mut two] = [branches; 2];
        one[axis] = 2 * branches[axis];
        two[axis] = one[axis] + 1;
        let [one, two] = [(self.bound_of(one, side), one), (self.bound_of(two, side), two)];
        for (bound, part) in if one.0 < two.0 { [two, one] } else { [one, two] } {
            if bound >= least {
                least = self.seek(part, side, least, found);
            }
        }
        least
    }
}

/// The largest difference of every window of a size.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowMap {
    /// Positions of the window, along the chain.
    pub positions: Node,
    /// Figures in the order of [`GridMap::number`] over `positions`.
    pub figures: Vec<Diameter>,
}

impl WindowMap {
    /// Every window of `size` nodes; `None` where `size` is 0 or larger than the grid.
    pub fn of(map: &GridMap, size: Node) -> Option<WindowMap> {
        let whole = map.size();
        if (0..3).any(|axis| size[axis] == 0 || size[axis] > whole[axis]) {
            return None;
        }
        let positions = [0, 1, 2].map(|axis| whole[axis] - size[axis] + 1);
        let mut figures: Vec<Diameter> = Vec::new();
        for number in 0..positions.iter().product() {
            let window = Window { low: grid_map::node(number, positions), size };
            let guess = figures.last().map(|figure| moved(figure.nodes, window));
            figures.push(within(map, window, guess));
        }
        Some(WindowMap { positions, figures })
    }

    /// The lowest node of the window of figure `number`.
    pub fn low(&self, number: usize) -> Node {
        grid_map::node(number, self.positions)
    }

    /// The figure of the window whose lowest node is `low`.
    ///
    /// Panics where there is no such window.
    pub fn at(&self, low: Node) -> Diameter {
        self.figures[grid_map::number(low, self.positions)]
    }

    /// Number and figure of the worst window, the first of several.
    pub fn worst(&self) -> (usize, Diameter) {
        self.first_with(|candidate, best| candidate > best)
    }

    /// Number and figure of the best window, the first of several.
    pub fn best(&self) -> (usize, Diameter) {
        self.first_with(|candidate, best| candidate < best)
    }

    fn first_with(&self, better: impl Fn(f64, f64) -> bool) -> (usize, Diameter) {
        let figures = self.figures.iter().copied().enumerate();
        figures.fold((0, self.figures[0]), |found, figure| {
            if better(figure.1.um, found.1.um) { figure } else { found }
        })
    }
}

/// The pair of a neighbour, moved into a window.
fn moved(nodes: [Node; 2], window: Window) -> [Node; 2] {
    nodes.map(|node| {
        [0, 1, 2].map(|axis| {
            let low = window.low[axis];
            node[axis].clamp(low, low + window.size[axis] - 1)
        })
    })
}

// The longest difference in a cloud of vectors without a grid: tool paths, measured maps.

/// Vectors looked at together when the furthest one is sought.
const BLOCK: usize = 256;

/// Steps from one vector to the one furthest from it, before the directions are cut.
const STEPS: usize = 8;

/// The longest difference of two vectors, exact; `None` where there is no vector, or one is not
/// finite.
///
/// Vectors that cannot be an end are left out first: with the middle m and the radius R of the
/// cloud, no difference from p is longer than |p − m| + R.
pub fn longest(vectors: &[Vector]) -> Option<Longest> {
    let (low, high) = bounds(vectors)?;
    let room = room((0..3).map(|c| high[c] - low[c]).sum());
    let mut longest = Longest::none(0);
    walk(vectors, &mut longest);
    let middle = [0, 1, 2].map(|c| low[c] + (high[c] - low[c]) / 2.0);
    let radius = square(&vectors[furthest(vectors, &middle)], &middle).sqrt();
    let least = longest.um() - radius - room;
    let ends = ends(vectors, &middle, least);
    for cell in DirectionCell::half_sphere() {
        search(cell, &ends, Frame { middle, room }, &mut longest);
    }
    Some(longest)
}

/// Smallest and largest components.
pub(super) fn bounds(vectors: &[Vector]) -> Option<(Vector, Vector)> {
    let first = *vectors.first()?;
    let (mut low, mut high) = (first, first);
    let mut sum = 0.0;
    for vector in vectors {
        for c in 0..3 {
            low[c] = if vector[c] < low[c] { vector[c] } else { low[c] };
            high[c] = if vector[c] > high[c] { vector[c] } else { high[c] };
            sum += vector[c] * 0.0;
        }
    }
    sum.is_finite().then_some((low, high))
}

/// The place of the vector furthest from `from`, the first of several.
fn furthest(vectors: &[Vector], from: &Vector) -> usize {
    let mut best = (-1.0, 0);
    for (block, list) in vectors.chunks(BLOCK).enumerate() {
        let mut squares = [-1.0; BLOCK];
        for (value, vector) in squares.iter_mut().zip(list) {
            *value = square(vector, from);
        }
        let largest = squares.iter().fold(best.0, |m, s| if *s > m { *s } else { m });
        if largest > best.0 {
            let place = squares.iter().position(|s| *s >= largest).unwrap_or(0);
            best = (largest, block * BLOCK + place);
        }
    }
    best.1
}

/// From a vector to the one furthest from it, and so on while the step grows.
fn walk(vectors: &[Vector], longest: &mut Longest) {
    let point = |number: usize| NumberedVector { at: vectors[number], number };
    let mut from = 0;
    for _ in 0..STEPS {
        let to = furthest(vectors, &vectors[from]);
        if !longest.offer(&point(from), &point(to)) {
            break;
        }
        from = to;
    }
}

fn ends(vectors: &[Vector], middle: &Vector, least: f64) -> Ends {
    let least = if least > 0.0 { least * least * (1.0 - 1e-12) } else { 0.0 };
    let far = vectors.iter().enumerate().filter(|(_, vector)| square(vector, middle) >= least);
    let top: Vec<NumberedVector> =
        far.map(|(number, at)| NumberedVector { at: *at, number }).collect();
    Ends { bottom: top.clone(), top }
}
