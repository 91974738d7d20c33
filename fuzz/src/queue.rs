//! The inputs of a target that found something new, and which of them is changed next.

use crate::coverage::Edge;
use crate::random::Random;

/// Inputs, and for every edge the smallest of them that takes it.
#[derive(Default)]
pub struct Queue {
    inputs: Vec<Vec<u8>>,
    /// For every edge the classes of counts that were seen, and the smallest input; 0 = never taken.
    edges: Vec<(u8, usize)>,
    taken: Vec<usize>,
}

impl Queue {
    /// Keeps an input that takes an edge, or takes one more or less often, as none did before.
    pub fn add(&mut self, input: &[u8], trace: &[Edge]) -> bool {
        let highest = trace.last().map_or(0, |(edge, _)| edge + 1);
        if self.edges.len() < highest {
            self.edges.resize(highest, (0, 0));
        }
        let is_new = trace.iter().any(|(edge, class)| self.edges[*edge].0 & class == 0);
        if is_new {
            self.keep(input, trace);
        }
        is_new
    }

    /// An input that is changed even though it takes no new edge (without counters: all of them).
    pub fn keep(&mut self, input: &[u8], trace: &[Edge]) {
        let own = self.inputs.len();
        self.inputs.push(input.to_vec());
        for (edge, class) in trace {
            let (seen, smallest) = &mut self.edges[*edge];
            if *seen == 0 {
                self.taken.push(*edge);
            }
            if *seen == 0 || input.len() < self.inputs[*smallest].len() {
                *smallest = own;
            }
            *seen |= class;
        }
    }

    /// One to be changed: mostly the smallest that takes some edge, else any.
    pub fn next(&self, random: &mut Random) -> &[u8] {
        let index = match self.taken.is_empty() || random.one_in(3) {
            true => random.below(self.inputs.len()),
            false => self.edges[*random.pick(&self.taken)].1,
        };
        self.inputs.get(index).map_or(&[], Vec::as_slice)
    }

    /// How many edges were taken.
    pub fn edges(&self) -> usize {
        self.taken.len()
    }
}
