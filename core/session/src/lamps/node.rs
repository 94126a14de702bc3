//! Groups of lamps as one.

use glam::Vec3;

/// All lamps of a group.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// Where the lamps are in the mean, and how far from it: of one lamp, of a ball that holds it; of more, the root of the mean square.
    pub(super) center: Vec3,
    pub(super) radius: f32,
    /// Flux into a steradian where all of them shine most.
    pub(super) most: f32,
    /// What they send all around of it.
    pub(super) around: f32,
    /// What they send along the axis besides, in a cone, dimmed by a cosine if it is flat.
    pub(super) strength: f32,
    pub(super) axis: Vec3,
    pub(super) angle: f32,
    pub(super) is_flat: bool,
    /// Whether directions from anywhere in the ball count as those from its middle and not as the best of them.
    pub(super) is_mean: bool,
    /// Squared length by which their size softens 1/d², a mean.
    pub(super) softening2: f32,
    /// Of a single lamp, how far its light is left to beams, squared: a ray that passes nearer gets little of it, not all.
    pub(super) gap2: f32,
}
