//! `covbeam render`: from a scene file to pictures on the disk, telling the user what happens.

use crate::cli::{MethodName, RenderArgs};
use covbeam_render::film::Film;
use covbeam_render::maps::{density_map, filter_map};
use covbeam_render::march::Marching;
use covbeam_render::memory;
use covbeam_render::output::{OutputError, RenderInfo, check_writable, write_bitmap, write_exr, write_png};
use covbeam_render::pass::Renderer;
use covbeam_render::progress::seconds;
use covbeam_render::render::{End, Goal, Progress, RenderError, render};
use covbeam_render::scene::Scene;
use cpu_time::ProcessTime;
use indicatif::{ProgressBar, ProgressStyle};
use std::error::Error;
use std::io::{IsTerminal, Write, stderr, stdout};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// As shells report a program that Ctrl-C stopped.
pub(crate) const STOPPED: u8 = 130;

/// What is rendered when no scene is named.
pub(crate) const DEFAULT_SCENE: &str = include_str!("../../scenes/glass-ball.toml");
pub(crate) const DEFAULT_NAME: &str = "glass-ball";

pub(crate) fn run(args: &RenderArgs) -> Result<ExitCode, Box<dyn Error>> {
    let start = Instant::now();
    check_flags(args)?;
    let (scene, name) = match &args.scene {
        Some(path) => {
            (Scene::load(path)?, path.file_stem().unwrap_or_default().to_string_lossy().into_owned())
        }
        None => (Scene::parse(DEFAULT_SCENE, "built-in scene", Path::new("."))?, DEFAULT_NAME.to_owned()),
    };
    let unbounded = args.time.is_none() && args.until.is_none();
    let passes = args.passes.or(unbounded.then_some(scene.settings.passes));
    let goal = Goal { passes, time: args.time, error: args.until };
    let method = args.method.name();
    let exr = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{name}-{method}.exr")));
    let photons = args.photons.unwrap_or(scene.settings.photons);
    let seed = args.seed.unwrap_or(scene.settings.seed);
    let info = RenderInfo { method: method.to_owned(), passes: 0, photons, seed, scene: name };
    let files = Files { exr, info, maps: args.maps };
    files.all().iter().try_for_each(|path| check_writable(path))?;
    check_memory(&scene, photons, args.light_passes)?;

    let stop = Arc::new(AtomicBool::new(false));
    let handler_stop = Arc::clone(&stop);
    ctrlc::set_handler(move || handler_stop.store(true, Ordering::Relaxed))?;
    let cancelled = || stop.load(Ordering::Relaxed);

    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads as usize).build()?;
    let (width, height) = (scene.camera.width, scene.camera.height);
    eprintln!(
        "{}: {width} x {height} pixels, method {method}, {photons} light paths a pass, {} threads",
        files.info.scene,
        pool.current_num_threads()
    );
    let mut renderer = pool.install(|| Renderer::new(&scene, args.method.method(), photons, seed));
    if matches!(args.method, MethodName::Adaptive) {
        pool.install(|| renderer.light_by_kind());
    }
    if args.method.plans_eye_rays() && !args.every_pixel {
        pool.install(|| renderer.plan_eye_rays());
    }
    let mut film = Film::of_scene(&scene);
    if args.light_passes {
        film.keep_kinds(renderer.keep_kinds());
    }
    let marching = Marching::default();
    renderer.march_as(Marching { samples: args.samples.unwrap_or(marching.samples), ..marching });
    let mut display = Display::new();
    let mut autosave = Autosave::new();
    let rendered = render(
        &mut film,
        &goal,
        start,
        &cancelled,
        |index, cancelled| pool.install(|| renderer.pass(index, cancelled)),
        |progress, film| {
            display.show(progress, &goal);
            autosave.after_pass(progress, &goal, || pool.install(|| files.save(film)))
        },
    );
    display.finish();

    if film.passes() == 0 {
        rendered?;
        eprintln!("stopped before the first pass was finished: nothing is written");
        return Ok(ExitCode::from(STOPPED));
    }
    // An output error came from saving this very film: trying again would fail again.
    if !matches!(rendered, Err(RenderError::Report(_))) {
        pool.install(|| files.save(&film))?;
        stdout().write_all(files.saved(&film).as_bytes())?;
    }
    let (end, progress) = rendered?;
    stdout().write_all(verdict(end, &progress, args).as_bytes())?;
    stdout().write_all((summary(&progress) + &files.hints(args)).as_bytes())?;
    Ok(if end == End::Cancelled { ExitCode::from(STOPPED) } else { ExitCode::SUCCESS })
}

/// What became of the error that was asked for.
fn verdict(end: End, progress: &Progress, args: &RenderArgs) -> String {
    let Some(goal) = args.until else { return String::new() };
    let found = progress.error.map(|(error, passes)| format!("{:.2} % after {passes} passes", 100.0 * error));
    let found = found.unwrap_or_else(|| "not known yet".to_owned());
    match end {
        End::Dark => {
            format!(
                "no light reaches the picture: it has no error that could be brought to {:.2} %\n",
                100.0 * goal
            )
        }
        End::NotReached => format!("the error asked for, {:.2} %, is not reached: {found}\n", 100.0 * goal),
        End::Reached | End::Cancelled => format!("median relative error: {found}\n"),
    }
}

/// Refuses a picture that memory cannot hold, before the work begins.
fn check_memory(scene: &Scene, photons: u32, kinds: bool) -> Result<(), String> {
    let (needed, available) = (memory::needed(scene, photons, kinds), memory::available());
    let Some(available) = available.filter(|available| needed > *available) else { return Ok(()) };
    let (width, height) = (scene.camera.width, scene.camera.height);
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    Err(format!(
        "a picture of {width} x {height} pixels with {photons} light paths a pass needs about {:.2} GB of memory, and {:.2} GB are available; \
         choose fewer pixels (camera.width, camera.height) or fewer light paths (--photons)",
        gigabytes(needed),
        gigabytes(available)
    ))
}

/// Refuses flags that the method would ignore.
fn check_flags(args: &RenderArgs) -> Result<(), String> {
    let planned = args.method.plans_eye_rays();
    let march = matches!(args.method, MethodName::March);
    let adaptive = matches!(args.method, MethodName::Adaptive);
    for (given, flag, used, users) in [
        (args.maps, "--maps", planned, "adaptive and march"),
        (args.every_pixel, "--every-pixel", planned, "adaptive and march"),
        (args.light_passes, "--light-passes", adaptive, "adaptive"),
        (args.samples.is_some(), "--samples", march, "march"),
    ] {
        if given && !used {
            let method = args.method.name();
            return Err(format!(
                "{flag} means nothing to the method {method}; leave it out, or choose {users}"
            ));
        }
    }
    Ok(())
}

/// Where the pictures go.
struct Files {
    exr: PathBuf,
    info: RenderInfo,
    maps: bool,
}

impl Files {
    fn save(&self, film: &Film) -> Result<(), OutputError> {
        let mut picture = film.picture();
        write_exr(&self.exr, &picture, &RenderInfo { passes: film.passes(), ..self.info.clone() })?;
        write_png(&self.png(), &picture)?;
        if let (true, Some(mut maps)) = (self.maps, picture.maps.take()) {
            write_bitmap(&self.beside("density"), &density_map(&picture, &maps))?;
            // The last map has nine pixels for one of the picture: what it does not show makes room.
            (picture.error, picture.layers) = (None, None);
            maps.volume = Vec::new();
            maps.layers.iter_mut().for_each(|layer| layer.density = Arc::default());
            write_bitmap(&self.beside("filters"), &filter_map(&picture, &maps))?;
        }
        Ok(())
    }

    fn png(&self) -> PathBuf {
        self.exr.with_extension("png")
    }

    /// NAME-map.png for NAME.exr.
    fn beside(&self, map: &str) -> PathBuf {
        let name = self.exr.file_stem().unwrap_or_default().to_string_lossy();
        self.exr.with_file_name(format!("{name}-{map}.png"))
    }

    fn all(&self) -> Vec<PathBuf> {
        let maps = self.maps.then(|| ["density", "filters"].map(|map| self.beside(map)));
        [self.exr.clone(), self.png()].into_iter().chain(maps.into_iter().flatten()).collect()
    }

    fn saved(&self, film: &Film) -> String {
        let (exr, png, passes) = (self.exr.display(), self.png(), film.passes());
        let mut text = format!(
            "wrote {exr} (linear radiance and layers) and {} (preview), {passes} passes\n",
            png.display()
        );
        if self.maps {
            let [density, filters] = ["density", "filters"].map(|map| self.beside(map));
            text += &format!(
                "wrote {} (eye rays a pixel, logarithmic) and {} (filters at one standard deviation)\n",
                density.display(),
                filters.display()
            );
        }
        text
    }

    fn hints(&self, args: &RenderArgs) -> String {
        // Started by `cargo run`, the program is not on the user's path.
        let covbeam = if std::env::var_os("CARGO").is_some() { "cargo run --release --" } else { "covbeam" };
        let scene = args.scene.as_deref().map_or(String::new(), |path| format!(" {}", quoted(path)));
        let (other, about) = match args.method {
            MethodName::Adaptive => ("ppb", "the same without frequency analysis"),
            MethodName::Ppb | MethodName::LightTrace | MethodName::March => {
                ("adaptive", "the same with frequency analysis")
            }
        };
        let picture = quoted(&self.exr);
        format!(
            "\nnext, try\n  \
             {covbeam} render{scene} --method {other}\n      {about}\n  \
             {covbeam} render{scene} --passes 1000 --seed 1000 --out reference.exr\n      a reference\n  \
             {covbeam} compare {picture} reference.exr\n      how far this picture is from it\n"
        )
    }
}

fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    if text.contains(char::is_whitespace) { format!("'{text}'") } else { text }
}

/// Saves the picture now and then, so that a crash or a full disk costs seconds of a long render, not all of it.
struct Autosave {
    next: Instant,
}

impl Autosave {
    const EVERY: Duration = Duration::from_secs(10);
    /// Of a huge picture, saving takes at most 1/20 of the time.
    const SHARE: u32 = 20;

    /// The first picture is saved after the first pass.
    fn new() -> Self {
        Self { next: Instant::now() }
    }

    /// How long it took, if it was time to save.
    fn after_pass(
        &mut self,
        progress: &Progress,
        goal: &Goal,
        save: impl FnOnce() -> Result<(), OutputError>,
    ) -> Result<Option<Duration>, OutputError> {
        let start = Instant::now();
        // The end of the render saves it anyway.
        let ends = progress.reaches(goal)
            || goal.time.is_some_and(|time| progress.elapsed + 2 * progress.saving + progress.last > time);
        if start < self.next || ends {
            return Ok(None);
        }
        save()?;
        let took = start.elapsed();
        self.next = Instant::now() + Self::EVERY.max(took * Self::SHARE);
        Ok(Some(took))
    }
}

/// Progress on standard error: a bar in a terminal, else a line every few seconds.
struct Display {
    bar: Option<ProgressBar>,
    next_line: Instant,
}

impl Display {
    const LINES_EVERY: Duration = Duration::from_secs(5);

    const STEPS: u64 = 1000;

    fn new() -> Self {
        let bar = stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("[{bar:30}] {elapsed} {msg}").expect("a valid template");
            let bar = ProgressBar::new(Self::STEPS).with_style(style.progress_chars("=> "));
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Self { bar, next_line: Instant::now() }
    }

    fn show(&mut self, progress: &Progress, goal: &Goal) {
        let passes = match goal.passes {
            Some(all) => format!("pass {} of {all}", progress.passes),
            None => format!("pass {}", progress.passes),
        };
        let left = progress.left(goal);
        let error =
            progress.error.map_or(String::new(), |(error, _)| format!(", error {:.1} %", 100.0 * error));
        let until = left.map_or(String::new(), |left| format!(", {} left", seconds(left)));
        let speed = 1.0 / progress.last.as_secs_f64().max(1e-9);
        let message = format!("{passes}{error}{until}, {speed:.2} passes/s");
        if let Some(bar) = &self.bar {
            let elapsed = progress.elapsed.as_secs_f64();
            let share = left.map_or(0.0, |left| elapsed / (elapsed + left.as_secs_f64()).max(1e-9));
            bar.set_position((Self::STEPS as f64 * share) as u64);
            bar.set_message(message);
        } else if Instant::now() >= self.next_line {
            eprintln!("{message}");
            self.next_line = Instant::now() + Self::LINES_EVERY;
        }
    }

    fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

/// Time, where it went, and memory.
fn summary(progress: &Progress) -> String {
    let times = &progress.times;
    let parts = [
        ("trace", times.trace),
        ("light fields", times.light_fields),
        ("grid", times.grid),
        ("build", times.build),
        ("plan", times.plan),
        ("gather", times.gather),
    ];
    let whole = times.total();
    let mut text = format!("{}, {whole:.2} core-seconds:\n", seconds(progress.elapsed));
    for (name, time) in parts {
        let percent = if whole > 0.0 { 100.0 * time / whole } else { 0.0 };
        text += &format!("  {name:<12} {time:>8.2} s {percent:>5.1} %\n");
    }
    if times.pairs > 0 && times.gather > 0.0 {
        let pairs = times.pairs as f64;
        let speed = pairs / times.gather / 1e6;
        text += &format!(
            "{:.1} million accepted pairs, {speed:.2} million a core-second of gather\n",
            pairs / 1e6
        );
    }
    if times.shadow_rays > 0 {
        text += &format!("{:.1} million shadow rays\n", times.shadow_rays as f64 / 1e6);
    }
    if let (Ok(cpu), Some(peak)) = (ProcessTime::try_now(), memory::peak()) {
        text += &format!(
            "the system counts {:.2} s of CPU time and a peak memory of {:.0} MB\n",
            cpu.as_duration().as_secs_f64(),
            peak as f64 / 1e6
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use covbeam_render::pass::PassTimes;

    #[test]
    fn the_summary_splits_the_time_and_counts_pairs_per_second_of_gather() {
        let times = PassTimes {
            trace: 1.0,
            light_fields: 0.5,
            grid: 0.5,
            build: 2.0,
            plan: 0.0,
            gather: 4.0,
            pairs: 24_000_000,
            shadow_rays: 0,
        };
        let progress = Progress { passes: 2, elapsed: Duration::from_secs(4), times, ..Progress::default() };
        let text = summary(&progress);
        assert!(text.contains("8.00 core-seconds"), "{text}");
        assert!(text.contains("gather           4.00 s  50.0 %"), "{text}");
        assert!(text.contains("24.0 million accepted pairs, 6.00 million a core-second"), "{text}");
    }

    #[test]
    fn a_path_with_spaces_is_quoted_in_the_hints() {
        assert_eq!(quoted(Path::new("my scene.toml")), "'my scene.toml'");
        assert_eq!(quoted(Path::new("scene.toml")), "scene.toml");
    }
}
