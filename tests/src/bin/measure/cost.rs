//! Core time of a pass.

use crate::rendering::{Run, load};
use crate::{Outcome, Size};
use covbeam_render::pass::Method;
use std::path::Path;

pub(crate) fn run(path: &Path, passes: u32, size: Size) -> Outcome<()> {
    let mut scene = load(path, size)?;
    let wide = scene.settings.schedule.radius;
    println!(
        "{:9} {:>6}  core-milliseconds a pass: trace | light fields | grid | build | gather",
        "method", "radius"
    );
    let narrow = 0.08 * wide;
    for (name, method, radius) in
        [("ppb", Method::Ppb, wide), ("ppb", Method::Ppb, narrow), ("adaptive", Method::Adaptive, wide)]
    {
        // The radius stays (almost) where it is: α near 1.
        scene.settings.schedule.radius = radius;
        scene.settings.schedule.alpha = 0.999;
        let (_, times) = Run::new(&scene, method, 1, passes).picture()?;
        let part = |seconds: f64| 1e3 * seconds / f64::from(passes);
        let fields = times.light_fields + times.grid;
        println!(
            "{name:9} {radius:6.3}  {:.1} | {:.1} | {:.1} | {:.1} | {:.1}   light fields + grid {:.1} %, {:.2} M accepted pairs, {:.1} M a core-second of gather",
            part(times.trace),
            part(times.light_fields),
            part(times.grid),
            part(times.build),
            part(times.gather),
            100.0 * fields / times.total(),
            times.pairs as f64 / f64::from(passes) / 1e6,
            times.pairs as f64 / times.gather / 1e6,
        );
    }
    if let Some(peak) = std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| status.lines().find(|line| line.starts_with("VmHWM")).map(str::to_owned))
    {
        println!("peak memory: {}", peak.trim_start_matches("VmHWM:").trim());
    }
    Ok(())
}
