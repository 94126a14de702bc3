//! Bounces of light by kind, and their limits as path tracers count them: from the eye.
//!
//! A path tracer counts each event on the way from the camera to the lamp but the last one, where it looks the lamp up. Seen from the lamp
//! the first event is free, and the one that sends light to the camera counts. Light that glass and mirrors focus is what a path tracer
//! hardly finds: what is sharp all the way from the lamp may be let off, as if the light came straight from there.

/// A kind of event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bounce {
    /// Reflected diffusely.
    Diffuse,
    /// Reflected otherwise.
    Glossy,
    /// Sent on behind a surface, but for what goes straight on.
    Transmission,
    /// Scattered by a medium.
    Volume,
}

/// Largest numbers of events of each kind, and of all, between the camera and the last one before the lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BounceLimits {
    /// Of all kinds.
    pub total: u32,
    /// Diffuse reflections.
    pub diffuse: u32,
    /// Other reflections.
    pub glossy: u32,
    /// Transmissions; what goes straight on does not count.
    pub transmission: u32,
    /// Scatterings by media, the one that sends light to the camera included.
    pub volume: u32,
    /// Whether sharp reflections on the way from a lamp are let off: they count as `glossy` alone.
    pub free_reflections: bool,
    /// The same of sharp transmissions.
    pub free_transmissions: bool,
}

/// The bounces of a light path so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counted {
    /// Of each kind, but for the first and what is let off.
    each: [u32; 4],
    total: u32,
    /// Whether anything has been met, and anything that is not let off.
    has_met: bool,
    has_counted: bool,
    /// Whether nothing is let off.
    is_strict: bool,
}

impl Counted {
    /// Of light of a lamp that may have a limit of its own on events of all kinds, which counts where there are others.
    pub(crate) fn of_lamp(limits: Option<&BounceLimits>, most: Option<u32>) -> Self {
        let (Some(limits), Some(most)) = (limits, most) else { return Self::default() };
        Self { total: limits.total - limits.total.min(most), is_strict: true, ..Self::default() }
    }

    /// Counts an event. `is_sharp`: whether light keeps its directions in it.
    #[inline]
    pub(crate) fn add(&mut self, limits: Option<&BounceLimits>, bounce: Bounce, is_sharp: bool) {
        let Some(limits) = limits else { return };
        let is_let_off = match bounce {
            Bounce::Glossy => limits.free_reflections,
            Bounce::Transmission => limits.free_transmissions,
            Bounce::Diffuse | Bounce::Volume => false,
        };
        let is_let_off = is_sharp && is_let_off && !self.is_strict;
        if !self.has_counted && is_let_off {
            self.each[bounce as usize] += u32::from(self.has_met);
        } else if self.has_counted {
            self.each[bounce as usize] += 1;
            self.total += 1;
        }
        self.has_counted |= !is_let_off;
        self.has_met = true;
    }

    /// Whether the light may be sent to the camera by an event of a kind.
    #[inline]
    pub(crate) fn may_be_seen(&self, limits: &BounceLimits, by: Bounce) -> bool {
        let is_within = |kind: Bounce, more: u32, most: u32| self.each[kind as usize] + more <= most;
        let of = |kind: Bounce| u32::from(self.has_counted && kind == by);
        is_within(Bounce::Glossy, 0, limits.glossy)
            && is_within(Bounce::Transmission, 0, limits.transmission)
            && is_within(Bounce::Diffuse, of(Bounce::Diffuse), limits.diffuse)
            && is_within(Bounce::Volume, of(Bounce::Volume), limits.volume)
            && (!self.has_counted || self.total < limits.total)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CYCLES: BounceLimits = BounceLimits {
        total: 12,
        diffuse: 4,
        glossy: 4,
        transmission: 12,
        volume: 0,
        free_reflections: true,
        free_transmissions: true,
    };

    /// Of a path from the lamp: a letter an event; small ones are sharp.
    fn sees(limits: &BounceLimits, path: &str) -> [bool; 2] {
        seen(Counted::default(), limits, path)
    }

    fn seen(mut counted: Counted, limits: &BounceLimits, path: &str) -> [bool; 2] {
        for letter in path.chars() {
            let bounce = match letter.to_ascii_uppercase() {
                'D' => Bounce::Diffuse,
                'G' => Bounce::Glossy,
                'T' => Bounce::Transmission,
                _ => Bounce::Volume,
            };
            counted.add(Some(limits), bounce, letter.is_ascii_lowercase());
        }
        [Bounce::Volume, Bounce::Diffuse].map(|by| counted.may_be_seen(limits, by))
    }

    /// What a path tracer counts: the events from the camera to the last but one, the one that is seen first.
    fn counted_from_the_eye(limits: &BounceLimits, path: &str, by: char) -> bool {
        let events: Vec<char> = std::iter::once(by).chain(path.to_uppercase().chars().rev()).collect();
        let counted = &events[..events.len() - 1];
        let of = |letter| counted.iter().filter(|&&event| event == letter).count() as u32;
        of('D') <= limits.diffuse
            && of('G') <= limits.glossy
            && of('T') <= limits.transmission
            && of('V') <= limits.volume
            && counted.len() as u32 <= limits.total
    }

    /// All paths of up to six events, with limits of all kinds: nothing is let off.
    #[test]
    fn events_count_as_from_the_eye() {
        let paths = (0..=6).flat_map(|length| {
            (0..4_usize.pow(length)).map(move |code| {
                (0..length).map(|i| b"DGTV"[code / 4_usize.pow(i) % 4] as char).collect::<String>()
            })
        });
        let paths: Vec<String> = paths.collect();
        for numbers in
            [[0, 0, 0, 0, 0], [12, 4, 4, 12, 0], [12, 1, 0, 2, 1], [3, 2, 2, 2, 2], [2, 9, 9, 9, 9]]
        {
            let [total, diffuse, glossy, transmission, volume] = numbers;
            let (free_reflections, free_transmissions) = (false, false);
            let limits = BounceLimits {
                total,
                diffuse,
                glossy,
                transmission,
                volume,
                free_reflections,
                free_transmissions,
            };
            for path in &paths {
                for sharp in [path.clone(), path.to_lowercase()] {
                    let expected = ['V', 'D'].map(|by| counted_from_the_eye(&limits, path, by));
                    assert_eq!(sees(&limits, &sharp), expected, "{path} {limits:?}");
                }
            }
        }
    }

    /// A lamp's own limit is that of all events but for the one that is seen, and lets nothing off: a path tracer looks up no such lamp.
    #[test]
    fn a_lamp_has_fewer_events_than_all() {
        let limits = BounceLimits { volume: 4, ..CYCLES };
        for (most, path, is_seen) in [
            (0, "", true),
            (0, "t", false),
            (0, "D", false),
            (1, "t", true),
            (1, "D", true),
            (1, "tD", false),
            (2, "tD", true),
            (2, "DDD", false),
            (90, "DDDD", true),
            (90, "DDDDDD", false),
        ] {
            assert_eq!(
                seen(Counted::of_lamp(Some(&limits), Some(most)), &limits, path)[0],
                is_seen,
                "{most} {path}"
            );
        }
        assert!(seen(Counted::of_lamp(Some(&limits), None), &limits, "t")[0]);
    }

    #[test]
    fn what_is_sharp_from_the_lamp_on_is_let_off() {
        for (path, in_fog) in [
            ("", true),
            ("tt", true),
            ("gtgt", true),
            ("ggggg", true),
            ("gggggg", false),
            ("D", false),
            ("V", false),
            ("G", false),
            ("ttD", false),
            ("tT", false),
        ] {
            assert_eq!(sees(&CYCLES, path)[0], in_fog, "{path}");
        }
        let once = BounceLimits { volume: 1, ..CYCLES };
        assert_eq!(["ttD", "ttV", "ttVV", "tDt"].map(|path| sees(&once, path)[0]), [true, true, false, true]);
        let off = BounceLimits { free_transmissions: false, ..CYCLES };
        assert_eq!(["tt", "g", "gt"].map(|path| sees(&off, path)[0]), [false, true, false]);
    }
}
