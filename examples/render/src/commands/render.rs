//! `covbeam render`: from a scene file to pictures on the disk, telling the user what happens.

mod files;
pub(crate) mod job;
mod saving;

use crate::commands::cli::{MethodName, PassesArgument, PictureArgs, RenderArgs};
use crate::commands::failure::{self, Refused, Usage};
use crate::commands::stop::{Ended, Stop, Watch};
use covbeam_render::files::output::check_writable;
use covbeam_render::files::prepared::read_prepared;
use covbeam_render::files::shard::Origin;
use covbeam_render::progress::{Display, Listener, Standing, say, seconds};
use covbeam_session::film::Film;
use covbeam_session::kind::Split;
use covbeam_session::pass::Renderer;
use covbeam_session::pass::memory;
use covbeam_session::render::{End, Goal, Progress, RenderError, render};
use covbeam_session::scene::Scene;
use covbeam_session::settings::{Layers, Settings};
use cpu_time::ProcessTime;
use job::{Begun, Job, Target};
use saving::Saving;
use serde_json::json;
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

pub(crate) fn run(args: &RenderArgs) -> Result<ExitCode, Box<dyn Error>> {
    let start = Instant::now();
    check_flags(args)?;
    let job = Job::new(args)?;
    let listener = args.progress.listener();
    let Begun::Film(mut film) = job.begun(args.resume)? else {
        finished_before(listener, &job);
        return Ok(ExitCode::SUCCESS);
    };
    job.target.files().iter().try_for_each(|path| check_writable(path))?;
    check_scene(&job, &args.picture)?;

    let stop = Stop::on_signals()?;
    let cancelled = || stop.is_asked();
    let watch = watch(&stop, &job, start, film.passes(), listener)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads as usize).build()?;
    job.scene.notes.iter().for_each(say);
    say(job.title(pool.current_num_threads(), film.passes()));
    let mut renderer = pool.install(|| Renderer::new(&job.scene, settings(&job.origin, &args.picture)));
    begin(&mut film, &mut renderer, &job, args)?;
    let display = Display::for_listener(listener);
    let mut saving = Saving::new(&job, args.checkpoint, passes_in_shard(&job, args, film.passes()));
    let rendered = render(
        &mut film,
        &job.goal,
        start,
        &cancelled,
        |index, cancelled| pool.install(|| renderer.pass(job.first + index, cancelled)),
        |progress, film| {
            watch.end();
            show(&display, progress, &job.goal);
            pool.install(|| saving.after_pass(progress, film))
        },
    );
    watch.end();
    display.finish();

    if film.passes() == 0 {
        rendered?;
        stopped_early(listener, [job.first; 2]);
        return Ok(stop.exit_code());
    }
    // An output error came from saving this very film: trying again would fail again.
    if !matches!(rendered, Err(RenderError::Report(_))) {
        pool.install(|| saving.save_all(&film))?;
    }
    let (end, progress) = rendered?;
    let text = job.target.saved(&film, job.first)
        + &verdict(end, &progress, args)
        + &summary(&progress)
        + &job.target.hints(args);
    let facts = facts(&job, &progress);
    if end == End::Cancelled {
        listener.stopped(&text, facts);
        return Ok(stop.exit_code());
    }
    listener.done(&text, facts);
    Ok(ExitCode::SUCCESS)
}

/// What the first pass of this render finds: a film that keeps the kinds of light that are asked for, and the light fields of earlier passes.
fn begin(
    film: &mut Film,
    renderer: &mut Renderer,
    job: &Job,
    args: &RenderArgs,
) -> Result<(), Box<dyn Error>> {
    if args.picture.light_passes && film.passes() == 0 {
        film.keep_kinds(Split::of_each_kind(&job.scene));
    }
    match &args.fields {
        Some(path) => read_fields(path, job, film.passes(), renderer),
        None => Ok(()),
    }
}

/// Passes in the shard that this render goes on from; None: what is there is replaced.
fn passes_in_shard(job: &Job, args: &RenderArgs, passes: u32) -> Option<u32> {
    let goes_on = args.resume || matches!(job.target, Target::Piece(_));
    // A damaged one is replaced.
    let anew = passes == 0 && job.target.shard().exists();
    (goes_on && !anew).then_some(passes)
}

/// Says that there is nothing to render.
fn finished_before(listener: Listener, job: &Job) {
    let text = format!("{}: finished before, nothing is left to do\n", job.target);
    let end = job.first + job.goal.passes.unwrap_or(0);
    listener.done(&text, json!({ "files": job.target.files(), "passes": [job.first, end] }));
}

/// Ends the program while there is no new pass: by signals, and where the first one takes so much longer than `--time` that it is worth less
/// than to know that.
fn watch(stop: &Stop, job: &Job, start: Instant, before: u32, listener: Listener) -> std::io::Result<Watch> {
    const MOST_TIMES: u32 = 2;
    let time = job.goal.time.and_then(|time| Some((time, start.checked_add(time.checked_mul(MOST_TIMES)?)?)));
    let (asked, range) = (stop.clone(), [job.first, job.first + before]);
    Watch::new(stop.clone(), time.map(|(_, until)| until), move |ended| match (ended, time) {
        (Ended::Time, Some((time, _))) => {
            let code = failure::FAILED;
            listener.failed(
                code,
                &format!(
                    "no pass is finished after {MOST_TIMES} times --time {}, nothing is written; give it more time, fewer light paths (--photons) or \
                     fewer pixels (camera.width, camera.height)",
                    time.as_secs_f64()
                ),
            );
            code
        }
        _ => {
            stopped_early(listener, range);
            asked.code()
        }
    })
}

/// Says that a signal came before there was a new pass; `passes`: those that were there.
fn stopped_early(listener: Listener, passes: [u32; 2]) {
    let text = match passes[1] - passes[0] {
        0 => "stopped before the first pass was finished: nothing is written\n",
        _ => "stopped before another pass was finished: all is as it was\n",
    };
    listener.stopped(text, json!({ "files": [], "passes": passes }));
}

/// How the passes of a picture are made.
pub(crate) fn settings(origin: &Origin, args: &PictureArgs) -> Settings {
    let mut settings = Settings::of(args.method.method(), origin.photons, origin.seed);
    settings.planned = args.method.plans_eye_rays() && !args.every_pixel;
    if args.light_passes {
        settings.layers = Layers::EachKind;
    }
    settings.marching.samples = origin.samples.unwrap_or(settings.marching.samples);
    settings
}

/// The light fields of the passes before the first one that is missing.
fn read_fields(path: &Path, job: &Job, passes: u32, renderer: &mut Renderer) -> Result<(), Box<dyn Error>> {
    let Some(state) = read_prepared(path, &job.origin, job.first + passes + 1)? else { return Ok(()) };
    let refused =
        |error| Refused(format!("'{}': {error}; make it with `covbeam prepare`", path.display())).into();
    renderer.load_fields(&state).map_err(refused)
}

/// Tells the user where the render stands.
fn show(display: &Display, progress: &Progress, goal: &Goal) {
    let passes = match goal.passes {
        Some(all) => format!("pass {} of {all}", progress.passes),
        None => format!("pass {}", progress.passes),
    };
    let left = progress.left(goal);
    let error = progress.error.map_or(String::new(), |(error, _)| format!(", error {:.1} %", 100.0 * error));
    let until = left.map_or(String::new(), |left| format!(", {} left", seconds(left)));
    let speed = 1.0 / progress.last.as_secs_f64().max(1e-9);
    let elapsed = progress.elapsed.as_secs_f64();
    let share = match *goal {
        // Passes that were there before count, too.
        Goal { passes: Some(all), time: None, error: None } => {
            Some(f64::from(progress.passes) / f64::from(all))
        }
        _ => left.map(|left| elapsed / (elapsed + left.as_secs_f64()).max(1e-9)),
    };
    display.show_all(&Standing {
        step: &format!("{passes}{error}{until}, {speed:.2} passes/s"),
        share,
        left,
        facts: json!({
            "pass": progress.passes,
            "passes": goal.passes,
            "error": progress.error.map(|(error, _)| error),
            "elapsed": elapsed,
        }),
    });
}

/// What a program is told at the end.
fn facts(job: &Job, progress: &Progress) -> serde_json::Value {
    json!({
        "files": job.target.files(),
        "passes": [job.first, job.first + progress.passes],
        "error": progress.error.map(|(error, _)| error),
        "elapsed": progress.elapsed.as_secs_f64(),
        "core_seconds": progress.times.total(),
    })
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

/// Refuses a scene that the method, or any, has no picture of.
fn check_scene(job: &Job, args: &PictureArgs) -> Result<(), Refused> {
    check_camera(&job.scene, args.method)?;
    check_lamps(&job.scene)?;
    check_memory(&job.scene, job.origin.photons, args.light_passes)
}

/// Refuses to connect light with a camera that shows a point in more than one place, or as no point.
fn check_camera(scene: &Scene, method: MethodName) -> Result<(), Refused> {
    if scene.camera.is_pinhole() || !matches!(method, MethodName::LightTrace) {
        return Ok(());
    }
    Err(Refused(
        "the method light-trace connects light with a pinhole, and this camera has a lens, a near plane or a projection other than \"perspective\"; \
         choose another --method, or leave camera.lens, camera.near and camera.projection out"
            .to_owned(),
    ))
}

/// Refuses a torch at the camera, in fog.
fn check_lamps(scene: &Scene) -> Result<(), Refused> {
    let Some(lamp) = scene.lamp_at_camera() else { return Ok(()) };
    Err(Refused(format!(
        "light[{lamp}] is a point at camera.position, in fog, which would be infinitely bright before the camera; move it aside, or give it a \
         size: kind = \"lamp\" with a radius, \"disk\", \"area\" or \"sphere\""
    )))
}

/// Refuses a picture that memory cannot hold, before the work begins.
fn check_memory(scene: &Scene, photons: u32, kinds: bool) -> Result<(), Refused> {
    let (needed, available) = (memory::needed(scene, photons, kinds), memory::available());
    let Some(available) = available.filter(|available| needed > *available) else { return Ok(()) };
    let (width, height) = (scene.camera.width, scene.camera.height);
    let gigabytes = |bytes: u64| bytes as f64 / 1e9;
    Err(Refused(format!(
        "a picture of {width} x {height} pixels with {photons} light paths a pass needs about {:.2} GB of memory, and {:.2} GB are available; \
         choose fewer pixels (camera.width, camera.height) or fewer light paths (--photons)",
        gigabytes(needed),
        gigabytes(available)
    )))
}

/// Refuses flags that the method would ignore, and those of `planned` where no eye rays are planned.
pub(crate) fn check_method(args: &PictureArgs, planned: &[(bool, &'static str)]) -> Result<(), Usage> {
    let plans = args.method.plans_eye_rays();
    let planned = planned.iter().map(|(given, flag)| (*given, *flag, plans, "adaptive and march"));
    let others = [
        (args.every_pixel, "--every-pixel", plans, "adaptive and march"),
        (args.light_passes, "--light-passes", matches!(args.method, MethodName::Adaptive), "adaptive"),
        (args.samples.is_some(), "--samples", matches!(args.method, MethodName::March), "march"),
    ];
    for (given, flag, used, users) in planned.chain(others) {
        if given && !used {
            let method = args.method.name();
            return Err(Usage(format!(
                "{flag} means nothing to the method {method}; leave it out, or choose {users}"
            )));
        }
    }
    Ok(())
}

/// Refuses flags that mean nothing together.
fn check_flags(args: &RenderArgs) -> Result<(), Usage> {
    check_method(&args.picture, &[(args.maps, "--maps"), (args.fields.is_some(), "--fields")])?;
    if args.maps && args.picture.every_pixel {
        return Err(Usage("--maps cannot be used with --every-pixel: there are none then".to_owned()));
    }
    let piece = args.passes.and_then(PassesArgument::range);
    for (given, flag) in [
        (args.time.is_some(), "--time"),
        (args.until.is_some(), "--until"),
        (args.maps, "--maps"),
        (args.resume, "--resume"),
    ] {
        if let (true, Some(range)) = (given, piece) {
            return Err(Usage(format!(
                "{flag} means nothing to a piece: --passes {range} writes these passes into a shard, and goes on from one that has some of them"
            )));
        }
    }
    Ok(())
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
    use covbeam_session::pass::PassTimes;
    use std::time::Duration;

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
}
