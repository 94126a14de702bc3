//! What an edge beside a ray does to its light field.

use super::{LightField, sharpness};
use glam::Vec3;

impl LightField {
    /// Occlusion by a straight edge beside the ray.
    ///
    /// Spectrum: spatial variance 1/(4π²ρ²), that of a Gaussian whose standard deviation is the distance to
    /// the edge, is added across the edge. Both the light that passes an object near its silhouette and the
    /// light that enters it there are masked.
    ///
    /// - `towards_edge`: world direction from the ray to the nearest point of the edge; the part of it across
    ///   the ray counts.
    /// - `distance` ρ \[m\] >= 0 from the ray to the edge: 0 is an edge on the ray (root 2⁵⁰), infinity none.
    ///
    /// Source: thesis 5.3.1 ("largest unoccluded disk"); the constant is the one of 1, 2, 3 and 4 times this
    /// width that agrees best with the closed form of a penumbra (test
    /// `the_penumbra_of_a_disk_light_behind_a_straight_edge`).
    ///
    /// ```
    /// use covbeam::{LightField, Vec3};
    /// let mut light = LightField::gaussian(Vec3::Z, Vec3::X, [0.0, 0.0], [1.0, 1.0]);
    /// light.occlude(Vec3::Y, 0.5 * std::f32::consts::FRAC_1_PI);
    /// let [xx, xy, yy] = light.slice();
    /// assert!(xx == 0.0 && xy == 0.0 && (yy - 1.0).abs() < 1e-6);
    /// ```
    pub fn occlude(&mut self, towards_edge: Vec3, distance: f32) {
        if distance.is_nan() || distance < 0.0 {
            return;
        }
        let Some([n_x, n_y]) = self.across(towards_edge) else { return };
        let root = sharpness(2.0 * distance);
        self.multiply([0.0, 0.0, n_x * root, n_y * root]);
    }
}
