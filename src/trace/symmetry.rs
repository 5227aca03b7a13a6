//! What a scene stays the same under: photons count for all places that are alike.
//!
//! Mirrored across a plane through the axis, (x, y) goes to (-x, y) or to (x, -y); both together are half a turn. A
//! model has those symmetries under which its LEDs, interfaces and tissue are their own images; outline, layers and
//! camera have them all. Light is then the same at a place and at its images, and a map of photons is the mean over the
//! images of each texel: up to four times as many photons for nothing. It is smoothed on the part that tells the rest.
//!
//! Camera paths are traced for all pixels (docs/decisions/symmetry.md).

/// What (x, y) goes to: which of both is turned about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Move(pub(super) [bool; 2]);

pub(super) const STILL: Move = Move([false; 2]);
const ACROSS: Move = Move([true, false]);
const DOWN: Move = Move([false, true]);
const ABOUT: Move = Move([true; 2]);

/// Moves that leave a model as it is, the one that moves nothing among them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Symmetry {
    moves: Vec<Move>,
}

impl Symmetry {
    /// None but the one that moves nothing.
    pub fn none() -> Self {
        Self { moves: vec![STILL] }
    }

    /// Those of the moves that leave something as it is.
    pub(super) fn under(leaves: impl Fn(Move) -> bool) -> Self {
        Self { moves: [STILL, ACROSS, DOWN, ABOUT].into_iter().filter(|one| leaves(*one)).collect() }
    }

    /// How many there are.
    pub fn order(&self) -> u32 {
        self.moves.len() as u32
    }

    /// The part of a grid about the axis, of so many columns and rows, that tells the whole.
    pub fn part(&self, whole: [usize; 2]) -> Part {
        let mirrored = |axis: usize, one| self.moves.contains(&one) && whole[axis].is_multiple_of(2);
        Part { moves: self.moves.clone(), whole, mirrored: [mirrored(0, ACROSS), mirrored(1, DOWN)] }
    }
}

/// The cells of a grid that tell all others: the lower half along each axis across which its field is mirrored. A line
/// of cells in the middle, or half a turn alone, leaves all cells in it.
#[derive(Debug, Clone)]
pub struct Part {
    moves: Vec<Move>,
    whole: [usize; 2],
    /// Whether the field goes on beyond the upper end of each axis, mirrored.
    pub mirrored: [bool; 2],
}

impl Part {
    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [0, 1].map(|axis| if self.mirrored[axis] { self.whole[axis] / 2 } else { self.whole[axis] })
    }

    /// Column and row of each of its cells.
    pub fn cells(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        let [columns, rows] = self.size();
        (0..columns * rows).map(move |k| [k % columns, k / columns])
    }

    /// The mean of a field of the whole grid over the images of each cell of the part.
    pub fn folded(&self, field: &[f64]) -> Vec<f64> {
        let value = |one: &Move, at| {
            let [column, row] = one.cell(at, self.whole);
            field[row * self.whole[0] + column]
        };
        let mean = |at| self.moves.iter().map(|one| value(one, at)).sum::<f64>() / self.moves.len() as f64;
        self.cells().map(mean).collect()
    }

    /// The field of the whole grid that a part tells.
    pub fn unfolded(&self, part: &[f64]) -> Vec<f64> {
        let ([columns, rows], mut field) = (self.size(), Vec::with_capacity(self.whole[0] * self.whole[1]));
        for row in 0..self.whole[1] {
            let own = if row < rows { row } else { self.whole[1] - 1 - row };
            let row = &part[own * columns..][..columns];
            field.extend_from_slice(row);
            if self.mirrored[0] {
                field.extend(row.iter().rev());
            }
        }
        field
    }
}

impl Move {
    pub(super) fn point(self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| if self.0[axis] { -at[axis] } else { at[axis] })
    }

    /// The cell that one goes to, of a grid about the axis.
    pub(super) fn cell(self, at: [usize; 2], size: [usize; 2]) -> [usize; 2] {
        [0, 1].map(|axis| if self.0[axis] { size[axis].saturating_sub(at[axis] + 1) } else { at[axis] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folded_map_is_its_own_image_and_keeps_its_sum() {
        let number = |k: u32| f64::from(k.wrapping_mul(2_654_435_761) % 1009);
        let all = Symmetry::under(|_| true);
        for (size, cells) in [([6, 6], 9), ([5, 5], 25), ([6, 4], 6), ([5, 4], 10)] {
            let field: Vec<f64> = (0..(size[0] * size[1]) as u32).map(number).collect();
            let part = all.part(size);
            let told = part.folded(&field);
            let folded = part.unfolded(&told);
            assert_eq!((told.len(), part.cells().count(), folded.len()), (cells, cells, field.len()));
            let (before, after) = (field.iter().sum::<f64>(), folded.iter().sum::<f64>());
            assert!((before - after).abs() < 1e-9 * before);
            let last = folded.len() - 1;
            for (k, value) in folded.iter().enumerate() {
                let across = k / size[0] * size[0] + size[0] - 1 - k % size[0];
                assert_eq!([folded[across], folded[last - k]], [*value; 2]);
            }
            assert_eq!(told, part.folded(&folded));
            assert_eq!(Symmetry::none().part(size).folded(&field), field);
        }
        // Half a turn has a mean, but no part.
        let turned = Symmetry { moves: vec![STILL, ABOUT] }.part([2, 2]);
        assert_eq!(turned.folded(&[1.0, 2.0, 4.0, 5.0]), [3.0; 4]);
    }
}
