//! Blocks of pixels: what an image is to an inference.

/// Most blocks along an axis, and fewest.
const MOST: u32 = 32;
const FEWEST: u32 = 8;

/// An image cut into as many columns and rows of equal blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Blocks {
    /// Columns and rows.
    pub count: [u32; 2],
}

impl Blocks {
    /// The finest blocks, not finer than 32 along an axis, that images of so many pixels can be cut into evenly; none
    /// where that would leave fewer than 8.
    pub fn of(pixels: [u32; 2]) -> Option<Self> {
        let along = |pixels: u32| (FEWEST..=MOST.min(pixels)).rev().find(|count| pixels.is_multiple_of(*count));
        Some(Self { count: [along(pixels[0])?, along(pixels[1])?] })
    }

    /// Blocks.
    pub fn total(&self) -> usize {
        self.count.iter().map(|count| *count as usize).product()
    }

    /// Whether an image of so many pixels is cut evenly.
    pub fn fits(&self, pixels: [u32; 2]) -> bool {
        [0, 1].iter().all(|&axis| pixels[axis] >= self.count[axis] && pixels[axis].is_multiple_of(self.count[axis]))
    }

    /// Pixels of each block of an image of so many pixels.
    pub fn pixels(&self, [width, height]: [u32; 2]) -> Vec<Vec<usize>> {
        let [columns, rows] = self.count.map(|count| count as usize);
        let [width, height] = [width, height].map(|pixels| pixels as usize);
        let mut blocks = vec![Vec::new(); self.total()];
        for pixel in 0..width * height {
            let (column, row) = (pixel % width * columns / width, pixel / width * rows / height);
            blocks[row * columns + column].push(pixel);
        }
        blocks
    }

    /// The first of a block and its mirror images.
    pub fn first_image(&self, block: usize) -> usize {
        let [columns, rows] = self.count.map(|count| count as usize);
        let [column, row] = [block % columns, block / columns];
        row.min(rows - 1 - row) * columns + column.min(columns - 1 - column)
    }

    /// Mean of an image over each block.
    pub fn means(&self, image: &[f64], pixels: [u32; 2]) -> Vec<f64> {
        let mean = |block: Vec<usize>| {
            let sum: f64 = block.iter().filter_map(|&pixel| image.get(pixel)).sum();
            sum / block.len().max(1) as f64
        };
        self.pixels(pixels).into_iter().map(mean).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn images_of_one_sensor_have_the_same_blocks() {
        let blocks = Blocks::of([348, 261]).unwrap();
        assert_eq!((blocks.count, Blocks::of([116, 87])), ([29, 29], Some(blocks)));
        assert!(blocks.fits([1392 / 12 * 12, 87]) && !blocks.fits([350, 261]));
        assert_eq!(Blocks::of([48, 36]), Some(Blocks { count: [24, 18] }));
        assert_eq!(Blocks::of([37, 41]), None);
        // A slope along columns: each block holds its middle.
        let slope = |width: u32, height: u32| -> Vec<f64> {
            (0..width * height).map(|k| (f64::from(k % width) + 0.5) / f64::from(width)).collect()
        };
        let (fine, coarse) = (blocks.means(&slope(348, 261), [348, 261]), blocks.means(&slope(116, 87), [116, 87]));
        assert!(fine.iter().zip(&coarse).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!((fine[30] - 1.5 / 29.0).abs() < 1e-12);
        // Its corners, and a middle of even and odd sides.
        assert!([0, 28, 28 * 29, 28 * 29 + 28].iter().all(|&corner| blocks.first_image(corner) == 0));
        assert_eq!(blocks.first_image(14 * 29 + 15), 14 * 29 + 13);
        assert_eq!(Blocks { count: [24, 18] }.first_image(9 * 24 + 12), 8 * 24 + 11);
    }
}
