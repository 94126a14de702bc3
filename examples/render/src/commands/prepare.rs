//! `covbeam prepare`: what pieces of a picture need of earlier passes, once for all of them.

use crate::commands::cli::PrepareArgs;
use crate::commands::failure::Usage;
use crate::commands::render::job::{check_ending, subject};
use crate::commands::render::{check_method, settings};
use crate::commands::stop::{Stop, Watch};
use covbeam_render::files::output::check_writable;
use covbeam_render::files::prepared::write_prepared;
use covbeam_render::progress::{Display, Listener, Standing, seconds};
use covbeam_session::pass::{Renderer, field_passes};
use covbeam_session::settings::Settings;
use serde_json::json;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

pub(crate) fn run(args: &PrepareArgs) -> Result<ExitCode, Box<dyn Error>> {
    let start = Instant::now();
    check_method(&args.picture, &[])?;
    if !args.picture.method.plans_eye_rays() {
        let method = args.picture.method.name();
        return Err(Usage(format!(
            "the method {method} needs nothing of earlier passes: there is nothing to prepare"
        ))
        .into());
    }
    let (scene, origin) = subject(&args.picture)?;
    let out = args.out.clone();
    let out = out.unwrap_or_else(|| PathBuf::from(format!("{}-{}.fields", origin.scene, origin.method)));
    check_ending(&out, "fields", "a file of light fields is written")?;
    check_writable(&out)?;
    let passes = args.passes.unwrap_or(scene.settings.passes);

    let stop = Stop::on_signals()?;
    let listener = args.progress.listener();
    let asked = stop.clone();
    let watch = Watch::new(stop.clone(), None, move |_| {
        stopped(listener);
        asked.code()
    })?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads as usize).build()?;
    let display = Display::for_listener(listener);
    let all = field_passes(passes);
    let mut done = 0;
    let report = |after: u32| {
        done += 1;
        let share = f64::from(done) / f64::from(all);
        let left = start.elapsed().mul_f64((1.0 - share) / share);
        display.show_all(&Standing {
            step: &format!("light fields of pass {after} of {passes}, {} left", seconds(left)),
            share: Some(share),
            left: Some(left),
            facts: json!({ "pass": after, "passes": passes }),
        });
    };
    let written = pool.install(|| {
        let settings = Settings { planned: false, ..settings(&origin, &args.picture) };
        let mut renderer = Renderer::new(&scene, settings);
        watch.end();
        write_prepared(&out, &origin, &mut renderer, passes, &|| stop.is_asked(), report)
    });
    display.finish();
    if !written? {
        stopped(listener);
        return Ok(stop.exit_code());
    }
    let took = seconds(start.elapsed());
    let text = format!(
        "wrote {} (light fields of {all} passes, for passes 0..{passes}), in {took}\n",
        out.display()
    );
    listener.done(&text, json!({ "files": [out], "passes": [0, passes] }));
    Ok(ExitCode::SUCCESS)
}

fn stopped(listener: Listener) {
    listener.stopped("stopped: nothing is written\n", json!({ "files": [] }));
}
