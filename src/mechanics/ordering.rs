//! An order of elimination that keeps the factor of a stiffness matrix small: nested dissection (George 1973, SIAM J.
//! Numer. Anal. 10, 345) of the elements rather than of the graph.
//!
//! Elements are sorted along a direction and cut in two; the nodes that both parts share separate them and come last.
//! The cut is taken along the direction and at the place where it shares the fewest nodes. In a mesh of blocks that is
//! a layer of faces, a single node thick.

/// Directions along which cuts are sought in the plane: its axes.
const PLANE: usize = 2;
/// In space: the axes, the diagonals in plan, the distance from the axis and the angle around it. Against the axes
/// alone the last four take a third of the work from the factor of a quarter of a round phantom.
const SPACE: usize = 7;

/// Least share of the elements on either side of a cut.
const LEAST_SHARE: f64 = 0.25;
/// Rise of a cut's cost from even parts to a side with nothing.
const UNEVEN: f64 = 0.5;

fn along(direction: usize, x: [f64; 3]) -> f64 {
    match direction {
        0..=2 => x[direction],
        3 => x[0] + x[1],
        4 => x[0] - x[1],
        5 => x[0].hypot(x[1]),
        _ => x[1].atan2(x[0]),
    }
}

/// The nodes in their order of elimination, each once. `groups` are the nodes of each element, `positions` those of all
/// nodes.
pub fn nested_dissection(groups: &[Vec<u32>], positions: &[[f64; 3]]) -> Vec<u32> {
    let place = |group: &Vec<u32>| {
        let mut sum = [0.0; 3];
        for &a in group {
            (0..3).for_each(|i| sum[i] += positions[a as usize][i] / group.len() as f64);
        }
        std::array::from_fn(|direction| along(direction, sum))
    };
    let count = positions.len();
    let mut work = Dissection {
        groups,
        places: groups.iter().map(place).collect(),
        placed: vec![false; count],
        first: vec![u32::MAX; count],
        last: vec![0; count],
        order: Vec::with_capacity(count),
        directions: if positions.iter().all(|x| x[2] == 0.0) { PLANE } else { SPACE },
    };
    let mut all: Vec<u32> = (0..groups.len() as u32).filter(|&g| !groups[g as usize].is_empty()).collect();
    work.dissect(&mut all);
    let placed = std::mem::take(&mut work.placed);
    work.order.extend((0..count as u32).filter(|&a| !placed[a as usize]));
    work.order
}

struct Dissection<'a> {
    groups: &'a [Vec<u32>],
    /// Of each element along each direction.
    places: Vec<[f64; SPACE]>,
    /// Nodes that are in the order or in a separator that will be.
    placed: Vec<bool>,
    /// First and last of the present elements that hold a node; `u32::MAX` and 0 between uses.
    first: Vec<u32>,
    last: Vec<u32>,
    order: Vec<u32>,
    directions: usize,
}

impl Dissection<'_> {
    /// Orders the nodes of some elements that are not placed yet.
    fn dissect(&mut self, elements: &mut [u32]) {
        if elements.len() <= 1 {
            for &g in elements.iter() {
                self.place(g);
            }
            return;
        }
        let mut best: Option<(f64, usize, usize)> = None;
        for direction in 0..self.directions {
            self.sort(elements, direction);
            let (cost, cut) = self.cheapest_cut(elements);
            if best.is_none_or(|best| cost < best.0) {
                best = Some((cost, direction, cut));
            }
        }
        let Some((_, direction, cut)) = best else { return };
        self.sort(elements, direction);
        let separator = self.separate(elements, cut);
        let (left, right) = elements.split_at_mut(cut);
        self.dissect(left);
        self.dissect(right);
        self.order.extend(separator);
    }

    fn place(&mut self, group: u32) {
        for &a in &self.groups[group as usize] {
            if !std::mem::replace(&mut self.placed[a as usize], true) {
                self.order.push(a);
            }
        }
    }

    fn sort(&self, elements: &mut [u32], direction: usize) {
        let key = |g: &u32| self.places[*g as usize][direction];
        elements.sort_unstable_by(|a, b| key(a).total_cmp(&key(b)).then(a.cmp(b)));
    }

    /// Number of shared nodes, with a penalty for uneven parts, and place of the best cut of sorted elements.
    fn cheapest_cut(&mut self, elements: &[u32]) -> (f64, usize) {
        self.mark(elements);
        let mut change = vec![0i64; elements.len() + 1];
        for &g in elements {
            for &a in &self.groups[g as usize] {
                let (first, last) = (self.first[a as usize], self.last[a as usize]);
                if first < last {
                    change[first as usize + 1] += 1;
                    change[last as usize + 1] -= 1;
                }
                self.first[a as usize] = u32::MAX;
                self.last[a as usize] = 0;
            }
        }
        let count = elements.len();
        let least = ((LEAST_SHARE * count as f64) as usize).max(1);
        let mut shared = 0;
        let mut best = (f64::INFINITY, count / 2);
        for (cut, change) in change.iter().enumerate().take(count).skip(1) {
            shared += change;
            if cut >= least && count - cut >= least {
                let uneven = (2.0 * cut as f64 / count as f64 - 1.0).abs();
                let cost = shared as f64 * (1.0 + UNEVEN * uneven);
                if cost < best.0 {
                    best = (cost, cut);
                }
            }
        }
        best
    }

    /// Notes the first and the last of the elements that hold each unplaced node.
    fn mark(&mut self, elements: &[u32]) {
        for (k, &g) in elements.iter().enumerate() {
            for &a in self.groups[g as usize].iter().filter(|&&a| !self.placed[a as usize]) {
                self.first[a as usize] = self.first[a as usize].min(k as u32);
                self.last[a as usize] = k as u32;
            }
        }
    }

    /// Takes the nodes that both sides of a cut hold.
    fn separate(&mut self, elements: &[u32], cut: usize) -> Vec<u32> {
        self.mark(elements);
        let mut separator = Vec::new();
        for &g in elements {
            for &a in &self.groups[g as usize] {
                let (first, last) = (self.first[a as usize], self.last[a as usize]);
                if first < last && (first as usize) < cut && last as usize >= cut {
                    self.placed[a as usize] = true;
                    separator.push(a);
                }
                self.first[a as usize] = u32::MAX;
                self.last[a as usize] = 0;
            }
        }
        separator
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nodes of the cells of a grid of n x n cells, and the positions of its corners.
    fn grid(n: u32) -> (Vec<Vec<u32>>, Vec<[f64; 3]>) {
        let corner = |i: u32, j: u32| j * (n + 1) + i;
        let cells = (0..n * n).map(|k| (k % n, k / n));
        let groups = cells.map(|(i, j)| vec![corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)]);
        let positions = (0..(n + 1).pow(2)).map(|k| [f64::from(k % (n + 1)), f64::from(k / (n + 1)), 0.0]);
        (groups.collect(), positions.collect())
    }

    #[test]
    fn the_order_is_a_permutation() {
        let (groups, mut positions) = grid(9);
        // One more node that nothing holds.
        positions.push([0.0; 3]);
        let mut order = nested_dissection(&groups, &positions);
        order.sort_unstable();
        assert_eq!(order, (0..101).collect::<Vec<u32>>());
    }

    #[test]
    fn the_last_nodes_cut_a_grid_in_two() {
        let (groups, positions) = grid(8);
        let order = nested_dissection(&groups, &positions);
        let separator = &order[order.len() - 9..];
        // One whole line of corners, in either direction, in the middle.
        let line = |i: usize| separator.iter().all(|&a| (positions[a as usize][i] - 4.0).abs() < 1.5);
        let straight =
            |i: usize| separator.windows(2).all(|p| positions[p[0] as usize][i] == positions[p[1] as usize][i]);
        assert!((0..2).any(|i| line(i) && straight(i)), "{separator:?}");
    }

    #[test]
    fn coincident_elements_and_none_at_all() {
        assert!(nested_dissection(&[], &[]).is_empty());
        assert_eq!(nested_dissection(&vec![vec![0, 1]; 5], &[[0.0; 3]; 2]).len(), 2);
    }
}
