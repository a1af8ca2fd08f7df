//! The mean period of a surface that repeats itself.

/// Heights averaged over the places within one period, without the plane that runs through all periods.
pub(super) struct MeanPeriod {
    cells: Vec<Cell>,
    shape: (usize, usize),
    /// The sums of xx, xy, yy, xz and yz over all points.
    products: [f64; 5],
}

/// How many points a place within the period has, and the sums of their x, y and z, m.
#[derive(Clone, Copy, Default)]
struct Cell {
    count: usize,
    sums: [f64; 3],
}

impl Cell {
    fn means(&self) -> Option<[f64; 3]> {
        (self.count > 0).then(|| self.sums.map(|sum| sum / self.count as f64))
    }
}

impl MeanPeriod {
    pub(super) fn new(u: usize, v: usize) -> Self {
        Self {
            cells: vec![Cell::default(); u * v],
            shape: (u, v),
            products: [0.0; 5],
        }
    }

    /// Takes a point at x, y and z, m, at u and v in periods.
    pub(super) fn add(&mut self, [u, v]: [f64; 2], point: [f64; 3]) {
        let cell = |phase: f64, cells: usize| {
            (((phase - phase.floor()) * cells as f64) as usize).min(cells - 1)
        };
        let at = cell(v, self.shape.1) * self.shape.0 + cell(u, self.shape.0);
        let own = &mut self.cells[at];
        own.count += 1;
        let [x, y, z] = point;
        for (sum, value) in own.sums.iter_mut().zip(point) {
            *sum += value;
        }
        for (sum, value) in self
            .products
            .iter_mut()
            .zip([x * x, x * y, y * y, x * z, y * z])
        {
            *sum += value;
        }
    }

    /// The slopes in x and y that points of one place within the period have in common: a plane through a map that holds no whole number
    /// of periods is not level with them.
    ///
    /// Formula: least squares of the deviations from the means of each place.
    fn slopes(&self) -> (f64, f64) {
        let [mut xx, mut xy, mut yy, mut xz, mut yz] = self.products;
        for cell in &self.cells {
            let Some([x, y, z]) = cell.means() else {
                continue;
            };
            let count = cell.count as f64;
            xx -= count * x * x;
            xy -= count * x * y;
            yy -= count * y * y;
            xz -= count * x * z;
            yz -= count * y * z;
        }
        let determinant = xx * yy - xy * xy;
        match determinant > 1e-9 * xx * yy {
            true => (
                (xz * yy - yz * xy) / determinant,
                (yz * xx - xz * xy) / determinant,
            ),
            false => (0.0, 0.0),
        }
    }

    /// The lowest and the highest cell, m, and the share of the period above the middle between them, along straight lines from
    /// cell to cell.
    pub(super) fn half_height(&self) -> Option<(f64, f64, f64)> {
        let (slope_x, slope_y) = self.slopes();
        let height_m = |[x, y, z]: [f64; 3]| z - slope_x * x - slope_y * y;
        let heights_m: Vec<Option<f64>> = (self.cells.iter())
            .map(|cell| cell.means().map(height_m))
            .collect();
        let measured = || heights_m.iter().flatten().copied();
        let (low_m, high_m) = (measured().reduce(f64::min)?, measured().reduce(f64::max)?);
        let half_m = f64::midpoint(low_m, high_m);
        // Of the way from one cell to the middle of the next.
        let above_to = |from: f64, to: Option<f64>| {
            let to = f64::midpoint(from, to.unwrap_or(from));
            let (low, high) = (from.min(to), from.max(to));
            match high > low {
                true => ((high - half_m) / (high - low)).clamp(0.0, 1.0),
                false => f64::from(u8::from(high > half_m)),
            }
        };
        let (mut above, mut steps) = (0.0, 0.0);
        let width = self.shape.0;
        for row in heights_m.chunks_exact(width) {
            for (at, own) in row.iter().enumerate() {
                let Some(own) = *own else {
                    continue;
                };
                let beside = [row[(at + width - 1) % width], row[(at + 1) % width]];
                above += beside.map(|to| above_to(own, to)).iter().sum::<f64>() / 2.0;
                steps += 1.0;
            }
        }
        (steps > 0.0).then(|| (low_m, high_m, above / steps))
    }
}
