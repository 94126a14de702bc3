//! Which pixels get an eye ray in which pass.

/// Steps of the low-discrepancy pattern over x, y (M. Roberts' R2 sequence: 1/ρ and 1/ρ², ρ³ = ρ + 1) and
/// over passes (the golden ratio), as fractions of 2³².
const ACROSS: u32 = 0xc13f_a9a9;
const DOWN: u32 = 0x91e1_0da5;
const PASS: u32 = 0x9e37_79b9;

/// A pixel's threshold in a pass, in [0, 1): the pixel gets an eye ray if its density is above.
///
/// At any density the pixels chosen in a pass are spread evenly over the picture, and a pixel is chosen
/// evenly over the passes; each pass chooses others.
///
/// - `seed`: shifts the pattern.
///
/// Guarantee: over all 2³² passes each threshold comes equally often. Among 64 passes in a row a pixel of
/// density p is chosen 64 p times within 2.7 (test `a_pixel_is_chosen_evenly_over_the_passes`), and in each
/// pass 256 p of 16 x 16 pixels are, within 7.4 and typically within a third of what chance would stray by
/// (test `every_block_of_pixels_gets_its_share_in_every_pass`).
///
/// ```
/// let density = 0.25;
/// let chosen = (0..64).flat_map(|y| (0..64).map(move |x| (x, y)));
/// let count = chosen.filter(|(x, y)| covbeam::pixel_threshold(*x, *y, 1, 0) < density).count();
/// assert!((count as i32 - 1024).abs() < 16);
/// ```
pub fn pixel_threshold(x: u32, y: u32, pass: u32, seed: u32) -> f32 {
    let turns =
        x.wrapping_mul(ACROSS).wrapping_add(y.wrapping_mul(DOWN)).wrapping_add(pass.wrapping_mul(PASS));
    // The upper 24 bits: exact, and below 1.
    (turns.wrapping_add(seed) >> 8) as f32 * (1.0 / 16_777_216.0)
}
