//! Regular reliefs: what stands on a plate at a point, before any roughness.

use std::f64::consts::TAU;

/// The height √3/2 of a triangle of side 1: the distance between rows of a hexagonal pattern, in wavelengths.
const ROW: f64 = 0.866_025_403_784_438_6;

/// A dot: a cylinder whose upper edge and foot are rounded, lengths in m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dot {
    pub(super) height_m: f64,
    pub(super) edge_m: f64,
}

impl Dot {
    /// The mean height, m, over `width_m` about a point `from_wall_m` outside the wall (negative inside).
    ///
    /// The upper edge is an arc of the edge's radius, the foot its mirror image, and the wall between them stands
    /// upright; a dot lower than two radii has no wall. Half the height is met at the wall in any case. The mean
    /// is along the radius and exact: a microscope's pixel sees a mean, and a wall falls between no two points.
    pub(super) fn mean_height_m(&self, from_wall_m: f64, width_m: f64) -> f64 {
        let half_m = 0.5 * width_m;
        (self.area_m2(from_wall_m + half_m) - self.area_m2(from_wall_m - half_m)) / width_m
    }

    /// The area under the radial section from the wall to `to_m` outside it, m²; negative inside.
    fn area_m2(&self, to_m: f64) -> f64 {
        let foot_m2 = self.foot_m2(to_m.abs());
        if to_m < 0.0 {
            self.height_m * to_m + foot_m2
        } else {
            foot_m2
        }
    }

    /// The area under the foot from the wall to `to_m` outside it, m²: ∫ (ρ − √(ρ² − (reach − t)²)) dt.
    fn foot_m2(&self, to_m: f64) -> f64 {
        let edge_m = self.edge_m;
        let low_m = edge_m.min(0.5 * self.height_m);
        let reach_m = (low_m * (2.0 * edge_m - low_m)).sqrt();
        let to_m = to_m.min(reach_m);
        if to_m > 0.0 {
            edge_m * to_m - (arc_m2(reach_m, edge_m) - arc_m2(reach_m - to_m, edge_m))
        } else {
            0.0
        }
    }
}

/// ∫ √(ρ² − x²) dx from 0 to `to_m`, m².
fn arc_m2(to_m: f64, radius_m: f64) -> f64 {
    let share = (to_m / radius_m).min(1.0);
    0.5 * radius_m * radius_m * (share * (1.0 - share * share).sqrt() + share.asin())
}

/// How far a point is from the nearest centre of a hexagonal pattern, in wavelengths, as is the point.
///
/// The centres are whole numbers of a1 = (1, 0) and a2 = (1/2, √3/2) from the origin.
pub(super) fn from_centre(x: f64, y: f64) -> f64 {
    // no centre is farther than 1/√3, so that the nearest one is in the row below or in the row above
    let below = (y / ROW).floor();
    let distance = |row: f64| {
        let along = x - 0.5 * row;
        (along - along.round()).hypot(y - ROW * row)
    };
    distance(below).min(distance(below + 1.0))
}

/// The height of ridges `depth_m` deep at `x` wavelengths, m: a cosine about 0.
pub(super) fn ridge_m(x: f64, depth_m: f64) -> f64 {
    0.5 * depth_m * (TAU * x).cos()
}
