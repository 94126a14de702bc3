//! What is typed after a flag: how it is read, and what was expected instead.

use covbeam_render::files::shard::PassRange;
use covbeam_render::study::compare::Region;
use covbeam_render::study::report::{Compared, METHODS};
use glam::Vec3;
use std::path::PathBuf;
use std::str::FromStr;
use std::time::Duration;

/// `N` or `A..B`
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PassesArgument {
    Count(u32),
    Range(PassRange),
}

impl PassesArgument {
    pub(crate) fn count(self) -> Option<u32> {
        if let Self::Count(count) = self { Some(count) } else { None }
    }

    pub(crate) fn range(self) -> Option<PassRange> {
        if let Self::Range(range) = self { Some(range) } else { None }
    }
}

impl FromStr for PassesArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.contains("..") {
            return text.parse().map(Self::Range);
        }
        let count = text.parse().ok().filter(|count| *count > 0);
        count.map(Self::Count).ok_or_else(|| "expected a number of passes above 0, or A..B".to_owned())
    }
}

pub(super) fn report_method(text: &str) -> Result<&'static str, String> {
    let names = || METHODS.iter().map(|method| method.name).collect::<Vec<_>>().join(", ");
    Compared::named(text).map(|method| method.name).ok_or_else(|| format!("expected one of {}", names()))
}

/// `x0,y0,z0:x1,y1,z1`
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LineArgument {
    pub(crate) from: Vec3,
    pub(crate) to: Vec3,
}

impl FromStr for LineArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected two points x0,y0,z0:x1,y1,z1";
        let (from, to) = text.split_once(':').ok_or(expected)?;
        let (from, to) = (point(from)?, point(to)?);
        if from == to {
            Err("the line has no length: both points are the same".into())
        } else {
            Ok(Self { from, to })
        }
    }
}

pub(super) fn point(text: &str) -> Result<Vec3, String> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) if [x, y, z].iter().all(|v| v.is_finite()) => Ok(Vec3::new(x, y, z)),
        _ => Err(format!("expected three finite numbers x,y,z, not '{text}'")),
    }
}

pub(super) fn share(text: &str) -> Result<f32, String> {
    let share = text.parse().ok().filter(|share| *share > 0.0 && *share <= 1.0);
    share.ok_or_else(|| "expected a number above 0 and at most 1".to_owned())
}

/// `name=x0,y0,x1,y1`; without a name the numbers are the name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct NamedRegion {
    pub(crate) name: String,
    pub(crate) region: Region,
}

pub(super) fn named_region(text: &str) -> Result<NamedRegion, String> {
    let (name, numbers) = text.split_once('=').unwrap_or((text, text));
    Ok(NamedRegion { name: name.to_owned(), region: numbers.parse()? })
}

pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let time = text.parse().ok().and_then(|s| Duration::try_from_secs_f64(s).ok());
    time.filter(|t| !t.is_zero()).ok_or_else(|| "expected a number of seconds above 0".to_owned())
}

pub(super) fn relative_error(text: &str) -> Result<f64, String> {
    let error = text.parse().ok().filter(|error| *error > 0.0 && *error < 1.0);
    error.ok_or_else(|| "expected a number above 0 and below 1, such as 0.02 for 2 %".to_owned())
}

pub(super) fn interval(text: &str) -> Result<Duration, String> {
    let time = text.parse().ok().and_then(|s| Duration::try_from_secs_f64(s).ok());
    time.ok_or_else(|| "expected a number of seconds, 0 or above".to_owned())
}

pub(super) fn merged_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("exr") || ending.eq_ignore_ascii_case("shard") => {
            Ok(path)
        }
        _ => Err("expected a file name that ends in .exr, for the picture, or in .shard".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_a_finite_number_of_seconds_above_zero() {
        assert_eq!(seconds("1.5").unwrap(), Duration::from_millis(1500));
        for text in ["0", "-1", "nan", "inf", "1e300", "ten", ""] {
            assert!(seconds(text).unwrap_err().contains("seconds above 0"), "{text}");
        }
    }

    #[test]
    fn an_error_is_above_zero_and_below_one() {
        assert_eq!(relative_error("0.02"), Ok(0.02));
        for text in ["0", "1", "-0.1", "nan", "2%"] {
            assert!(relative_error(text).unwrap_err().contains("0.02 for 2 %"), "{text}");
        }
    }

    #[test]
    fn a_region_may_have_a_name() {
        let region = Region { x0: 1, y0: 2, x1: 3, y1: 4 };
        assert_eq!(named_region("fog=1,2,3,4").unwrap(), NamedRegion { name: "fog".into(), region });
        assert_eq!(named_region("1,2,3,4").unwrap(), NamedRegion { name: "1,2,3,4".into(), region });
        assert!(named_region("fog").is_err());
    }

    #[test]
    fn a_line_is_two_different_points() {
        let line = LineArgument { from: Vec3::new(-1.0, 0.5, 2.0), to: Vec3::new(3.0, 0.5, 2.0) };
        assert_eq!("-1,0.5,2:3, 0.5,2".parse(), Ok(line));
        for text in ["", "1,2,3", "1,2:3,4", "1,2,3:4,5,nan", "1,2,3:4,5,6:7,8,9"] {
            assert!(text.parse::<LineArgument>().unwrap_err().starts_with("expected"), "{text}");
        }
        assert!("1,2,3:1,2,3".parse::<LineArgument>().unwrap_err().contains("no length"));
    }

    #[test]
    fn a_share_is_above_zero_and_at_most_one() {
        assert_eq!(share("0.5"), Ok(0.5));
        assert_eq!(share("1"), Ok(1.0));
        for text in ["0", "-0.1", "1.01", "nan", "some"] {
            assert!(share(text).is_err(), "{text}");
        }
    }

    #[test]
    fn what_is_merged_is_a_picture_or_a_shard() {
        assert!(
            merged_path("a/b.exr").is_ok() && merged_path("B.EXR").is_ok() && merged_path("c.shard").is_ok()
        );
        assert!(merged_path("a.png").is_err() && merged_path("exr").is_err() && merged_path(".exr").is_err());
    }

    #[test]
    fn passes_are_a_number_or_a_range() {
        assert_eq!("64".parse(), Ok(PassesArgument::Count(64)));
        assert_eq!("8..16".parse(), Ok(PassesArgument::Range(PassRange { start: 8, end: 16 })));
        for text in ["0", "-1", "8..8", "..", "1.5", ""] {
            assert!(text.parse::<PassesArgument>().is_err(), "{text}");
        }
    }
}
