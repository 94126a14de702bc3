//! What a command line asks for: a picture, or a piece of one.

use super::files::{Files, quoted};
use crate::commands::cli::{MethodName, PassesArgument, PictureArgs, RenderArgs};
use crate::commands::failure::{Refused, Usage};
use covbeam_render::files::output::OutputError;
use covbeam_render::files::shard::{Origin, PassRange, Passes, Shard, write_shard};
use covbeam_render::files::stored::StoredError;
use covbeam_render::progress::say;
use covbeam_render::scene_file;
use covbeam_session::film::Film;
use covbeam_session::gather::march::Marching;
use covbeam_session::render::Goal;
use covbeam_session::scene::Scene;
use covbeam_session::work::arithmetic::arithmetic;
use std::error::Error;
use std::fmt;
use std::path::{Path, PathBuf};

/// What is rendered when no scene is named.
pub(crate) const DEFAULT_SCENE: &str = include_str!("default_scene.toml");
pub(crate) const DEFAULT_NAME: &str = "glass-ball";

pub(super) struct Job {
    pub(super) scene: Scene,
    pub(super) origin: Origin,
    /// Number of the first pass, counted from 0.
    pub(super) first: u32,
    pub(super) goal: Goal,
    pub(super) target: Target,
}

/// Where the passes go.
pub(super) enum Target {
    /// Into a picture, and a shard beside it that it goes on from.
    Picture(Files),
    /// Into a shard.
    Piece(PathBuf),
}

/// What was there before.
pub(super) enum Begun {
    /// Passes to go on from; none: nothing was there.
    Film(Film),
    /// All of the piece.
    Finished,
}

impl Job {
    pub(super) fn new(args: &RenderArgs) -> Result<Self, Box<dyn Error>> {
        let (scene, origin) = subject(&args.picture)?;
        let (name, method) = (&origin.scene, &origin.method);
        if let Some(range) = args.passes.and_then(PassesArgument::range) {
            let path = args.out.clone();
            let path = path.unwrap_or_else(|| {
                PathBuf::from(format!("{name}-{method}-{}-{}.shard", range.start, range.end))
            });
            check_ending(&path, "shard", "with --passes A..B a shard is written")?;
            let goal = Goal { passes: Some(range.count()), ..Goal::default() };
            return Ok(Self { scene, origin, first: range.start, goal, target: Target::Piece(path) });
        }
        let unbounded = args.time.is_none() && args.until.is_none();
        let passes =
            args.passes.and_then(PassesArgument::count).or(unbounded.then_some(scene.settings.passes));
        let goal = Goal { passes, time: args.time, error: args.until };
        let exr = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{name}-{method}.exr")));
        check_ending(&exr, "exr", "the PNG preview and the sums are written beside it")?;
        let info = origin.info(0);
        let target = Target::Picture(Files { exr, info, maps: args.maps });
        Ok(Self { scene, origin, first: 0, goal, target })
    }

    /// For the user, at the start.
    pub(super) fn title(&self, threads: usize, passes: u32) -> String {
        let Origin { scene, width, height, method, photons, .. } = &self.origin;
        let piece = match &self.target {
            Target::Picture(_) => String::new(),
            Target::Piece(_) => format!("passes {}, ", self.range(self.goal.passes.unwrap_or(0))),
        };
        let before = match passes {
            0 => String::new(),
            1 => ", 1 pass is there already".to_owned(),
            _ => format!(", {passes} passes are there already"),
        };
        format!(
            "{scene}: {width} x {height} pixels, {piece}method {method}, {photons} light paths a pass, {threads} threads{before}"
        )
    }

    fn range(&self, passes: u32) -> PassRange {
        PassRange { start: self.first, end: self.first + passes }
    }

    /// What earlier renders left: of a piece always, of a picture where the user wants to go on.
    pub(super) fn begun(&self, resume: bool) -> Result<Begun, Box<dyn Error>> {
        let new = || Ok(Begun::Film(Film::of_scene(&self.scene)));
        let path = self.target.shard();
        let is_piece = matches!(self.target, Target::Piece(_));
        if !(is_piece || resume) {
            return new();
        }
        if !path.exists() {
            if resume {
                say(format!("{} does not exist: this starts with the first pass", path.display()));
            }
            return new();
        }
        let remedy =
            if is_piece { "delete it, or choose another --out" } else { "leave --resume out to begin anew" };
        let (passes, film) = match Shard::open(&path).and_then(|shard| self.passes_of(&shard)) {
            Ok(found) => found,
            Err(error) if is_piece && error.is_damaged() => {
                say(format!("{error}: its passes are rendered now"));
                return new();
            }
            Err(error) if error.is_damaged() || error.is_stranger() => {
                return Err(Refused(format!("{error}; {remedy}")).into());
            }
            Err(error) => return Err(error.into()),
        };
        let finished = is_piece && Some(passes) == self.goal.passes;
        Ok(if finished { Begun::Finished } else { Begun::Film(film) })
    }

    /// The number of a shard's passes and their sums, if they are the first ones of this job.
    fn passes_of(&self, shard: &Shard) -> Result<(u32, Film), StoredError> {
        if let Some(difference) = shard.origin().difference(&self.origin) {
            return Err(shard.stranger(format!("it holds passes of another render ({difference})")));
        }
        let count = shard.passes().count();
        let wanted = self.goal.passes.filter(|_| matches!(self.target, Target::Piece(_)));
        let fits =
            *shard.passes() == Passes::from(self.range(count)) && wanted.is_none_or(|wanted| count <= wanted);
        if !fits {
            let wanted =
                wanted.map_or_else(|| format!("{}..N", self.first), |wanted| self.range(wanted).to_string());
            let passes = shard.passes();
            return Err(shard.stranger(format!(
                "it holds the passes {passes}, which are not the first ones of {wanted}"
            )));
        }
        let mut film = shard.film();
        shard.add_to(&mut film)?;
        Ok((count, film))
    }

    /// Writes the shard that a render goes on from. `before`: how many passes this render last read from it or wrote into it; None: it may hold
    /// anything.
    pub(super) fn save_shard(&self, film: &Film, before: Option<u32>) -> Result<(), OutputError> {
        let path = self.target.shard();
        let there = || Shard::open(&path).map_or(0, |shard| shard.passes().count());
        if before.is_some_and(|before| before != there()) {
            return Err(OutputError::Taken(path));
        }
        write_shard(&path, &self.origin, &self.range(film.passes()).into(), film)
    }
}

impl Target {
    pub(super) fn shard(&self) -> PathBuf {
        match self {
            Self::Picture(files) => files.shard(),
            Self::Piece(path) => path.clone(),
        }
    }

    /// All files that will be written.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        match self {
            Self::Picture(files) => files.all(),
            Self::Piece(path) => vec![path.clone()],
        }
    }

    /// What was written, in words.
    pub(super) fn saved(&self, film: &Film, first: u32) -> String {
        match self {
            Self::Picture(files) => files.saved(film),
            Self::Piece(path) => {
                let passes = PassRange { start: first, end: first + film.passes() };
                format!("wrote {} (sums of passes {passes})\n", path.display())
            }
        }
    }

    pub(super) fn hints(&self, args: &RenderArgs) -> String {
        match self {
            Self::Picture(files) => files.hints(args),
            Self::Piece(path) => format!(
                "\nwhen all pieces are there\n  covbeam merge {} ... --out picture.exr\n      the picture, the same bits as that of one render\n",
                quoted(path)
            ),
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Picture(files) => write!(f, "{}", files.exr.display()),
            Self::Piece(path) => write!(f, "{}", path.display()),
        }
    }
}

pub(crate) fn check_ending(path: &Path, ending: &str, why: &str) -> Result<(), Usage> {
    if path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending)) {
        return Ok(());
    }
    Err(Usage(format!("--out '{}': expected a file name that ends in .{ending} ({why})", path.display())))
}

/// The scene of a picture, and what all passes of it have in common.
pub(crate) fn subject(args: &PictureArgs) -> Result<(Scene, Origin), Box<dyn Error>> {
    let (scene, name, fingerprint) = scene(args.scene.as_deref())?;
    let march = matches!(args.method, MethodName::March);
    let guided = matches!(args.method, MethodName::Adaptive);
    let origin = Origin {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        arithmetic: format!("{:08x}", arithmetic()),
        scene: name,
        fingerprint,
        width: scene.camera.width,
        height: scene.camera.height,
        method: args.method.name().to_owned(),
        photons: args.photons.unwrap_or(scene.settings.light_paths(guided)),
        seed: args.seed.unwrap_or(scene.settings.seed),
        every_pixel: args.every_pixel,
        samples: march.then(|| args.samples.unwrap_or(Marching::default().samples)),
        light_passes: args.light_passes,
    };
    Ok((scene, origin))
}

/// The scene, its name and its fingerprint.
fn scene(path: Option<&Path>) -> Result<(Scene, String, String), Box<dyn Error>> {
    let Some(path) = path else {
        let (scene, fingerprint) =
            scene_file::parse_with_fingerprint(DEFAULT_SCENE, "built-in scene", Path::new("."))?;
        return Ok((scene, DEFAULT_NAME.to_owned(), fingerprint));
    };
    let (scene, fingerprint) = scene_file::load_with_fingerprint(path)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok((scene, name, fingerprint))
}
