//! The balance of a pass' light paths: what is emitted is absorbed, escapes, or is taken by chance.

use crate::statistics::Sample;
use covbeam_session::pass::Renderer;
use covbeam_session::paths::Energy;
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Method, Settings};

/// Traces 20,000 paths with each of `seeds` seeds in a closed room, asserts that every balance closes, and returns the share that
/// chance took, per channel.
///
/// # Panics
/// If energy is lost or made, or escapes.
pub fn taken_by_chance(scene: &Scene, seeds: u32) -> [Sample; 3] {
    let shares: Vec<[f64; 3]> = (1..=seeds)
        .map(|seed| {
            let mut renderer = Renderer::new(scene, Settings::of(Method::Plain, 20_000, seed));
            renderer.pass(1, &|| false).expect("not cancelled");
            let Energy { emitted, medium, surfaces, escaped, spent, roulette } = renderer.energy();
            std::array::from_fn(|c| {
                let balance = medium[c] + surfaces[c] + escaped[c] + spent[c] + roulette[c] - emitted[c];
                // f32 powers, f64 sums: rounding of 6e-8 at each of a few events a path.
                assert!(balance.abs() < 1e-6 * emitted[c], "balance {balance} of {}", emitted[c]);
                assert_eq!(escaped[c], 0.0, "the room is closed");
                roulette[c] / emitted[c]
            })
        })
        .collect();
    std::array::from_fn(|c| Sample::of(&shares.iter().map(|share| share[c]).collect::<Vec<_>>()))
}
