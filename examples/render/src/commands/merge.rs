//! `covbeam merge`: from shards to the picture, or to a larger shard.

use crate::commands::cli::MergeArgs;
use crate::commands::failure::{Refused, Usage};
use covbeam_render::files::output::{OutputError, check_writable, write_exr, write_png};
use covbeam_render::files::shard::{Origin, PassRange, Passes, Shard, write_shard};
use covbeam_render::progress::{Display, Standing, seconds};
use covbeam_session::film::Film;
use serde_json::json;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

pub(crate) fn run(args: &MergeArgs) -> Result<ExitCode, Box<dyn Error>> {
    let start = Instant::now();
    let target = Target::of(&args.out);
    let is_picture = matches!(target, Target::Picture { .. });
    if !is_picture && (args.passes.is_some() || args.allow_gaps) {
        return Err(
            Usage("--passes and --allow-gaps are for pictures: a shard may have gaps".to_owned()).into()
        );
    }
    let files = target.files();
    files.iter().try_for_each(|path| check_writable(path))?;
    let shards = args.shards.iter().map(|path| Shard::open(path)).collect::<Result<Vec<_>, _>>()?;
    let passes = all_passes(&shards)?;
    let missing = if is_picture { missing(&passes, args)? } else { String::new() };

    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads as usize).build()?;
    let listener = args.progress.listener();
    // One that was opened first says what all are of.
    let Some(first) = shards.first() else {
        return Err(Usage("there is no shard to merge".to_owned()).into());
    };
    let display = Display::for_listener(listener);
    let mut film = first.film();
    for (number, shard) in shards.iter().enumerate() {
        show(&display, start, number, &shards);
        pool.install(|| shard.add_to(&mut film))?;
    }
    display.finish();

    let count = shards.len();
    let mut text = format!("merged {count} shards, passes {passes}, in {}\n", seconds(start.elapsed()));
    text += &pool.install(|| target.write(&film, first.origin(), &passes))?;
    if !missing.is_empty() {
        text += &format!("without the passes {missing}\n");
    }
    listener.done(&text, json!({ "files": files, "passes": passes.ranges(), "missing": missing }));
    Ok(ExitCode::SUCCESS)
}

/// What the sums become.
enum Target<'a> {
    Picture { exr: &'a Path, png: PathBuf },
    Shard(&'a Path),
}

impl<'a> Target<'a> {
    fn of(out: &'a Path) -> Self {
        let is_picture = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr"));
        if is_picture { Self::Picture { exr: out, png: out.with_extension("png") } } else { Self::Shard(out) }
    }

    /// All files that will be written.
    fn files(&self) -> Vec<PathBuf> {
        match self {
            Self::Picture { exr, png } => vec![exr.to_path_buf(), png.clone()],
            Self::Shard(path) => vec![path.to_path_buf()],
        }
    }

    /// Writes them, and says so.
    fn write(&self, film: &Film, origin: &Origin, passes: &Passes) -> Result<String, OutputError> {
        match self {
            Self::Picture { exr, png } => {
                let picture = film.picture();
                write_exr(exr, &picture, &origin.info(film.passes()))?;
                write_png(png, &picture)?;
                let (exr, png) = (exr.display(), png.display());
                Ok(format!("wrote {exr} (linear radiance and layers) and {png} (preview)\n"))
            }
            Self::Shard(path) => {
                write_shard(path, origin, passes, film)?;
                Ok(format!("wrote {} (sums)\n", path.display()))
            }
        }
    }
}

/// Tells the user which shard is added, and how long the others may take.
fn show(display: &Display, start: Instant, number: usize, shards: &[Shard]) {
    let count = shards.len();
    let step = format!("shard {} of {count}: {}", number + 1, shards[number].path().display());
    let share = number as f64 / count as f64;
    let left = (number > 0).then(|| start.elapsed().mul_f64((1.0 - share) / share));
    display.show_all(&Standing {
        step: &step,
        share: Some(share),
        left,
        facts: json!({ "shard": number, "shards": count }),
    });
}

/// The passes that a picture should have and no shard has, in words; refused unless the user allows gaps.
fn missing(passes: &Passes, args: &MergeArgs) -> Result<String, Refused> {
    let gaps = passes.gaps(expected(passes, args.passes)?);
    let missing = gaps.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    if missing.is_empty() || args.allow_gaps {
        return Ok(missing);
    }
    Err(Refused(format!(
        "the passes {missing} are in no shard; render them, or take the picture without them with --allow-gaps"
    )))
}

/// The passes that should be in a picture.
fn expected(passes: &Passes, asked: Option<u32>) -> Result<PassRange, Refused> {
    let last = passes.ranges().last().map_or(0, |range| range.end);
    match asked.filter(|asked| *asked < last) {
        None => Ok(PassRange { start: 0, end: asked.unwrap_or(last) }),
        Some(asked) => Err(Refused(format!(
            "there are shards with the passes {passes}, and --passes {asked} wants 0..{asked}; leave those beyond out, or --passes"
        ))),
    }
}

/// The passes of shards that are of one picture, none of them twice.
fn all_passes(shards: &[Shard]) -> Result<Passes, Refused> {
    let mut passes = Passes::default();
    for (number, shard) in shards.iter().enumerate() {
        let path = shard.path().display();
        if let Some(difference) = shards[0].origin().difference(shard.origin()) {
            let first = shards[0].path().display();
            return Err(Refused(format!(
                "'{path}' is not of the picture that '{first}' is of, which has {difference}"
            )));
        }
        if let Some(twice) = passes.overlap(shard.passes()) {
            let other =
                shards[..number].iter().find(|other| other.passes().overlap(shard.passes()).is_some());
            let other = other.map_or_else(|| path.to_string(), |other| other.path().display().to_string());
            return Err(Refused(format!(
                "the passes {twice} are in '{other}' and in '{path}'; leave one of them out"
            )));
        }
        passes.add(shard.passes());
    }
    Ok(passes)
}
