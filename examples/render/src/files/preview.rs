//! Previews: pictures as a screen shows them.

use covbeam_session::color::luminance;
use covbeam_session::film::Picture;

/// The picture as 8-bit sRGB, three bytes a pixel.
///
/// Exposure is chosen so that the median of luminance (of the pixels that are not black) is shown as middle grey,
/// 0.18 of the display's linear range, or darker where the 99th percentile would come out above 0.9: the same look in
/// every unit, and room for a caustic above evenly lit fog. Up to 0.6 the picture is linear; above, a shoulder
/// `0.6 + 0.4 (1 - exp(-(v - 0.6) / 0.4))`, per channel, lets highlights run out towards white instead of clipping.
pub fn preview(picture: &Picture) -> Vec<u8> {
    preview_exposed_as(picture, picture)
}

/// The same with the exposure that is right for another picture, so that the two can be compared.
pub fn preview_exposed_as(picture: &Picture, exposed: &Picture) -> Vec<u8> {
    const KNEE: f32 = 0.6;
    const ROOM: f32 = 1.0 - KNEE;
    const MIDDLE_GREY: f32 = 0.18;
    // The shoulder shows this value at 0.9: KNEE + ROOM ln 4.
    const SHOWN_AT_90_PERCENT: f32 = 1.154_517_7;

    let mut lit: Vec<f32> = exposed.radiance.iter().map(|v| luminance(*v)).filter(|l| *l > 0.0).collect();
    let mut percentile = |percent: usize| {
        let index = lit.len() * percent / 100;
        if lit.is_empty() { 1.0 } else { *lit.select_nth_unstable_by(index, f32::total_cmp).1 }
    };
    let middle = MIDDLE_GREY / SHOWN_AT_90_PERCENT * percentile(99);
    let grey = percentile(50).max(middle);
    // Before the bytes take their place.
    drop(lit);
    let show = |value: f32| {
        let exposed = value / grey * MIDDLE_GREY;
        let shown =
            if exposed <= KNEE { exposed } else { KNEE + ROOM * (1.0 - libm::expf((KNEE - exposed) / ROOM)) };
        (255.0 * srgb(shown) + 0.5) as u8
    };
    picture.radiance.iter().flat_map(|v| v.to_array().map(show)).collect()
}

/// The transfer function of IEC 61966-2-1: linear 0..=1 to encoded 0..=1.
fn srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::powf(linear, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn picture(width: u32, radiance: Vec<Vec3>) -> Picture {
        Picture { width, height: radiance.len() as u32 / width, radiance, ..Picture::default() }
    }

    #[test]
    fn the_preview_shows_a_few_bright_pixels_at_nine_tenths_in_every_unit() {
        for unit in [1e-20_f32, 1.0, 1e12] {
            // Nine in ten pixels are a hundred times darker than the ramp of the rest.
            let ramp = (1..=1000).map(|i| Vec3::splat(unit * if i <= 900 { 1.0 } else { (i - 800) as f32 }));
            let bytes = preview(&picture(1000, ramp.collect()));
            // sRGB of 0.9 is 0.9547 of 255 = 243.4; index 990 is the 99th percentile.
            assert_eq!(bytes[990 * 3], 243, "unit {unit}");
            // The brightest pixel runs into the shoulder, not into white; the darkest is nearly black.
            assert!(bytes[999 * 3] < 255 && bytes[999 * 3] >= 243);
            assert!(bytes[0] <= 24);
        }
    }

    #[test]
    fn the_preview_shows_even_fog_as_middle_grey_and_is_linear_below_the_knee() {
        // sRGB of 0.18 is 1.055 * 0.18^(1/2.4) - 0.055 = 0.4614 of 255 = 117.6; of twice that 0.6353 = 162.0.
        let mut radiance = vec![Vec3::ONE; 200];
        radiance[0] = Vec3::splat(2.0);
        let bytes = preview(&picture(200, radiance));
        assert_eq!((bytes[0], bytes[3]), (162, 118));
    }

    #[test]
    fn the_preview_of_a_black_picture_is_black_and_a_single_light_is_seen() {
        assert_eq!(preview(&picture(2, vec![Vec3::ZERO; 4])), [0; 12]);
        let mut radiance = vec![Vec3::ZERO; 1000];
        radiance[7] = Vec3::splat(3.0);
        // It is its own median: middle grey.
        assert_eq!(preview(&picture(1000, radiance))[7 * 3], 118);
    }
}
