//! Regions of the pictures of the glass-ball and black-ball scenes (256² pixels), in which errors are reported.

/// A named set of pixels.
#[derive(Clone, Copy, Debug)]
pub struct Region {
    /// Name.
    pub name: &'static str,
    /// Whether pixel (x, y) belongs to it; (0, 0) = upper left.
    pub contains: fn(u32, u32) -> bool,
}

/// Squared distance of a pixel's centre from the ball's centre; the ball's radius is 40.8 pixels.
fn from_ball(x: u32, y: u32) -> f32 {
    (x as f32 + 0.5 - 128.0).powi(2) + (y as f32 + 0.5 - 128.0).powi(2)
}

/// Whole picture.
pub const WHOLE: Region = Region { name: "whole", contains: |_, _| true };
/// Fog in front of the walls: rows 0-164 outside the ball.
pub const VOLUME: Region =
    Region { name: "volume", contains: |x, y| y < 165 && from_ball(x, y) > 43.0 * 43.0 };
/// The part of it more than half a ball's radius away from the ball's silhouette.
pub const SMOOTH: Region =
    Region { name: "smooth", contains: |x, y| y < 165 && from_ball(x, y) > 61.0 * 61.0 };
/// The volumetric caustic below the ball and the floor behind it.
pub const CAUSTIC: Region =
    Region { name: "caustic", contains: |x, y| (172..236).contains(&y) && (116..140).contains(&x) };
/// What is seen through the ball.
pub const GLASS: Region = Region { name: "glass", contains: |x, y| from_ball(x, y) < 40.0 * 40.0 };
/// Rows that see the floor, outside the caustic.
pub const FLOOR: Region = Region { name: "floor", contains: |x, y| y >= 180 && !(116..140).contains(&x) };

/// All of them.
pub const REGIONS: [Region; 6] = [WHOLE, VOLUME, SMOOTH, CAUSTIC, GLASS, FLOOR];
