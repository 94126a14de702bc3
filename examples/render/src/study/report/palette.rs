//! Colours of values, and of the parts of a pass.

/// An sRGB colour.
pub(super) type Color = [u8; 3];

/// Of the parts of a pass, in the order of [`super::PARTS`]; the muted scheme of Paul Tol, apart from those of the methods.
pub(super) const PART_COLORS: [Color; 6] =
    [[136, 204, 238], [17, 119, 51], [153, 153, 51], [221, 204, 119], [170, 68, 153], [136, 34, 85]];

/// As CSS and SVG write it.
pub(super) fn hex([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Stops of viridis (S. van der Walt and N. Smith, 2015), evenly spaced.
const VIRIDIS: [Color; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// Stops from blue over white to red (C. Brewer's RdBu), evenly spaced.
const BLUE_WHITE_RED: [Color; 9] = [
    [33, 102, 172],
    [67, 147, 195],
    [146, 197, 222],
    [209, 229, 240],
    [255, 255, 255],
    [253, 219, 199],
    [244, 165, 130],
    [214, 96, 77],
    [178, 24, 43],
];

/// A scale of colours over 0..=1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    /// For values from little to much.
    Viridis,
    /// For values around zero.
    BlueWhiteRed,
}

impl Scale {
    fn stops(self) -> &'static [Color; 9] {
        match self {
            Self::Viridis => &VIRIDIS,
            Self::BlueWhiteRed => &BLUE_WHITE_RED,
        }
    }

    /// The colour of a share; beyond 0..=1 that of the end, of NaN black.
    pub(super) fn color(self, share: f32) -> Color {
        let stops = self.stops();
        let place = share.clamp(0.0, 1.0) * (stops.len() - 1) as f32;
        let low = (place as usize).min(stops.len() - 2);
        let share = place - low as f32;
        let channel = |i: usize| {
            let (a, b) = (f32::from(stops[low][i]), f32::from(stops[low + 1][i]));
            (a + share * (b - a)).round() as u8
        };
        [channel(0), channel(1), channel(2)]
    }

    /// The scale from left to right as a CSS gradient.
    pub(super) fn css(self) -> String {
        let stops: Vec<String> = self.stops().iter().map(|color| hex(*color)).collect();
        format!("linear-gradient(to right,{})", stops.join(","))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_runs_from_its_first_to_its_last_stop() {
        assert_eq!(Scale::Viridis.color(0.0), [68, 1, 84]);
        assert_eq!(Scale::Viridis.color(7.0), [253, 231, 37]);
        assert_eq!(Scale::BlueWhiteRed.color(0.5), [255; 3]);
        // Half-way between the stops at 5/8 and 6/8.
        assert_eq!(Scale::BlueWhiteRed.color(5.5 / 8.0), [249, 192, 165]);
        assert_eq!(Scale::Viridis.color(f32::NAN), [0; 3], "black as all that has no value");
    }
}
