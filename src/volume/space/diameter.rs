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

use super::cloud;
pub use super::grid_map::Window;
use super::grid_map::{self, Distinct, GridMap, Node, Vector};
use super::pair::{DirectionCell, Ends, Frame, Longest, Point, minus, room, search, unit};
use super::support::Support;

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
/// source branch and bound over directions, docs/volumetric.md
/// limits exact: the largest of all squares as [`super::pair::square`] computes them; of several
///        pairs with the same square the one with the smallest numbers
pub fn diameter(map: &GridMap) -> Diameter {
    let low = [0; 3];
    let size = map.size();
    Search::new(map).within(Window { low, size }, None)
}

/// A search that keeps its lists from one window to the next.
pub(super) struct Search<'a> {
    map: &'a GridMap,
    grid: Distinct,
    top: Support,
    bottom: Support,
    longest: Longest,
    room: f64,
}

impl<'a> Search<'a> {
    pub(super) fn new(map: &'a GridMap) -> Self {
        Search {
            map,
            grid: Distinct::default(),
            top: Support::default(),
            bottom: Support::default(),
            longest: Longest::none(0),
            room: 0.0,
        }
    }

    /// The largest difference within a window; a guess inside it makes the search shorter.
    pub(super) fn within(&mut self, window: Window, guess: Option<[Node; 2]>) -> Diameter {
        self.grid.fill(self.map, window);
        self.room = room(self.grid.size_um());
        self.longest = Longest::none(self.map.number(window.low));
        if let Some([p, q]) = guess {
            self.longest.offer(&self.point(p), &self.point(q));
        }
        let mut level: Vec<DirectionCell> = DirectionCell::half_sphere().collect();
        while !level.is_empty() {
            let mut alive: Vec<(f64, DirectionCell)> = Vec::new();
            for cell in level {
                let reach = self.visit(cell);
                alive.extend(reach.map(|reach| (reach, cell)));
            }
            if self.longest.um() <= LOST_IN_ROUNDING * self.room {
                self.as_cloud();
                break;
            }
            alive.retain(|(reach, cell)| *reach >= self.needed(*cell));
            alive.sort_by(|a, b| b.0.total_cmp(&a.0));
            level = alive.into_iter().flat_map(|(_, cell)| cell.quarters()).collect();
        }
        let map = self.map;
        Diameter { um: self.longest.um(), nodes: self.longest.pair.map(|number| map.node(number)) }
    }

    fn point(&self, node: Node) -> Point {
        Point { at: self.map.at(node), number: self.map.number(node) }
    }

    /// What the vectors must reach along a cell for a difference as long as the longest one.
    fn needed(&self, cell: DirectionCell) -> f64 {
        self.longest.um() * cell.cosine() - self.room
    }

    /// Bound of the extent along `d`.
    fn aim(&mut self, d: &Vector) -> f64 {
        let d = self.map.along_chain(*d);
        self.top.aim(&self.grid, &d) + self.bottom.aim(&self.grid, &d.map(|c| -c))
    }

    /// How far the vectors reach to both sides; the pair there is offered. True where longer.
    fn reach(&mut self) -> ([f64; 2], bool) {
        let (high, top) = self.top.furthest(&self.grid);
        let (depth, bottom) = self.bottom.furthest(&self.grid);
        let node = |places: Node| [0, 1, 2].map(|axis| self.grid.axes[axis][places[axis]].0);
        let [top, bottom] = [top, bottom].map(|places| self.point(node(places)));
        ([high, depth], self.longest.offer(&top, &bottom))
    }

    /// Turns along the longest pair as long as that finds a longer one.
    fn turn(&mut self) {
        for _ in 0..TURNS {
            let [p, q] = self.longest.pair.map(|n| self.map.at(self.map.node(n)));
            let Some(d) = unit(minus(&p, &q)) else {
                break;
            };
            self.aim(&d);
            if !self.reach().1 {
                break;
            }
        }
    }

    /// Looks into a cell of directions; returns the extent along it where it has to be cut.
    fn visit(&mut self, cell: DirectionCell) -> Option<f64> {
        let d = cell.direction();
        if self.aim(&d) < self.needed(cell) {
            return None;
        }
        let ([high, depth], longer) = self.reach();
        if longer {
            self.turn();
        }
        let needed = self.needed(cell);
        if high + depth < needed {
            return None;
        }
        let fine = cell.is_fine(self.longest.um(), self.room);
        if fine || cell.cosine() > NARROW {
            if longer {
                self.aim(&d);
            }
            let most = if fine { usize::MAX } else { LISTED };
            let grid = (self.map, &self.grid);
            let top = self.top.beyond(grid, needed - depth, most);
            let bottom = top.as_ref().and_then(|_| self.bottom.beyond(grid, needed - high, most));
            if let (Some(top), Some(bottom)) = (top, bottom) {
                self.compare(cell, &Ends { top, bottom });
                return None;
            }
        }
        Some(high + depth)
    }

    fn compare(&mut self, cell: DirectionCell, ends: &Ends) {
        let [number, _] = self.longest.pair;
        let frame = Frame { middle: self.map.at(self.map.node(number)), room: self.room };
        search(cell, ends, frame, &mut self.longest);
    }

    /// All vectors, where the map is constant but for rounding.
    fn as_cloud(&mut self) {
        let mut numbers = Vec::new();
        let [first, second, third] = &self.grid.axes;
        for (i, _) in first {
            for (j, _) in second {
                let line = third.iter().map(|(k, _)| [*i, *j, *k]);
                numbers.extend(line.map(|node| self.map.number(node)));
            }
        }
        let vector = |number: &usize| self.map.at(self.map.node(*number));
        let vectors: Vec<Vector> = numbers.iter().map(vector).collect();
        if let Some(longest) = cloud::longest(&vectors) {
            self.longest = Longest { pair: longest.pair.map(|place| numbers[place]), ..longest };
        }
    }
}

/// The largest difference of every window of a size.
#[derive(Clone, Debug, PartialEq)]
pub struct WindowMap {
    /// Nodes of a window, along the chain.
    pub size: Node,
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
        let mut search = Search::new(map);
        let mut figures: Vec<Diameter> = Vec::new();
        for number in 0..positions.iter().product() {
            let window = Window { low: grid_map::node(number, positions), size };
            let guess = figures.last().map(|figure| moved(figure.nodes, window));
            figures.push(search.within(window, guess));
        }
        Some(WindowMap { size, positions, figures })
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
