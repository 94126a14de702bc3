//! The truth test in numbers: a table of all voxels and a summary.

use super::{Analysis, Axis, BATCHES, ENERGY, FACTOR, Origin, Verdict, Voxel};
use covbeam_session::pass::field_passes;
use std::fmt::Write as _;
use std::io;

/// How many voxel-axes have each verdict, by number and by energy.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shares {
    count: [f64; Verdict::ALL.len()],
    energy: [f64; Verdict::ALL.len()],
}

impl Shares {
    /// Over the axes of the voxels that hold 99 % of the energy; `verdict` picks one of an axis's verdicts, None leaves
    /// the axis out.
    pub fn of(analysis: &Analysis, verdict: impl Fn(&Voxel, usize, &Axis) -> Option<Verdict>) -> Self {
        let mut shares = Self::default();
        for voxel in analysis.voxels.iter().filter(|voxel| voxel.bright) {
            for (number, axis) in voxel.axes.iter().enumerate() {
                if let Some(verdict) = verdict(voxel, number, axis) {
                    shares.count[verdict as usize] += 1.0;
                    shares.energy[verdict as usize] += voxel.energy;
                }
            }
        }
        shares
    }

    /// Number of voxel-axes with this verdict.
    pub fn count(&self, verdict: Verdict) -> f64 {
        self.count[verdict as usize]
    }

    /// Number of voxel-axes that put the prediction to the test.
    pub fn judged(&self) -> f64 {
        sum(&self.count, Verdict::is_judged)
    }

    /// Share of the judged voxel-axes with this verdict, by number.
    pub fn by_count(&self, verdict: Verdict) -> f64 {
        self.count(verdict) / self.judged()
    }

    /// The same, each with its voxel's energy.
    pub fn by_energy(&self, verdict: Verdict) -> f64 {
        self.energy[verdict as usize] / sum(&self.energy, Verdict::is_judged)
    }

    /// Share that noise leaves undecided, of those that could be judged without it, by number and by energy.
    pub fn undecided(&self) -> [f64; 2] {
        [&self.count, &self.energy].map(|values| {
            let undecided = values[Verdict::Undecided as usize];
            undecided / (undecided + sum(values, Verdict::is_judged))
        })
    }
}

fn sum(values: &[f64], which: impl Fn(Verdict) -> bool) -> f64 {
    Verdict::ALL.iter().filter(|verdict| which(**verdict)).map(|verdict| values[*verdict as usize]).sum()
}

/// What the numbers mean, for the head of every table.
fn definitions(analysis: &Analysis) -> String {
    let [nx, ny, nz] = analysis.layout.cells;
    let size = super::walk::voxel_size(&analysis.layout);
    let prediction = analysis.options.prediction;
    format!(
        "\
Standard deviation sigma of the fluence's spectrum along the world axes, in cycles per scene unit.
predicted: from the covariance grid of {nx} x {ny} x {nz} voxels of {:.4} x {:.4} x {:.4} after {} passes, with
  light fields in {} passes of {} light paths (seed {}): the mean of sigma^2 over a voxel and its neighbours, weighted by
  f-, 2 f0, f+, through which the measurement sees the light as well. A row gives the voxel alone.
measured: from differences of the fluence that {} other light paths measured, in {BATCHES} independent batches:
  f-, f0, f+ of a voxel and its neighbours, size h: c = (f- - 2 f0 + f+)/h^2, g = (f+ - f-)/(2 h),
  m = (f- + 2 f0 + f+)/4, sigma^2 = max(|c|/m, (g/m)^2)/(4 pi^2).
bounds: both at most 1/(pi h), the most that differences can tell, and at least 0.0503/h: a kernel as wide as
  a voxel blurs such light by less than 1 %.
flat in both: neither is above the lower bound; such voxels agree, and say nothing more.
undecided: the noise (one standard error) leaves more than 25 % of doubt about the measured sigma.
surface, border: left out, because a surface cuts the three voxels or more than 10 % of one is no medium; or
  because a neighbour is missing.
",
        size.x,
        size.y,
        size.z,
        prediction.passes,
        field_passes(prediction.passes),
        prediction.field_paths,
        prediction.seed,
        analysis.options.paths,
    )
}

/// Writes all voxels as comma-separated values, with the definitions as comments (#) above.
///
/// # Errors
/// Those of `out`.
pub fn write_table(analysis: &Analysis, out: &mut dyn io::Write) -> io::Result<()> {
    for line in definitions(analysis).lines() {
        writeln!(out, "# {line}")?;
    }
    write!(out, "i,j,k,x,y,z,bright,fluence,noise,energy,medium,direct,specular,scattered")?;
    for axis in ["x", "y", "z"] {
        write!(
            out,
            ",predicted_{axis},measured_{axis},low_{axis},high_{axis},verdict_{axis},unbounded_{axis}"
        )?;
    }
    writeln!(out)?;
    for voxel in &analysis.voxels {
        let [i, j, k] = voxel.cell;
        let [x, y, z] = voxel.center.to_array();
        let [direct, specular, scattered] = voxel.origins;
        write!(
            out,
            "{i},{j},{k},{x:.5},{y:.5},{z:.5},{},{:.5e},{:.2e},{:.4e},{:.3},{direct:.3},{specular:.3},{scattered:.3}",
            u8::from(voxel.bright),
            voxel.fluence,
            voxel.noise,
            voxel.energy,
            voxel.medium,
        )?;
        for axis in &voxel.axes {
            let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:.4}"));
            let Axis { predicted, measured, verdict, strict, .. } = axis;
            write!(
                out,
                ",{},{},{},{},{},{}",
                number(*predicted),
                number(measured.map(|m| m.sigma)),
                number(measured.map(|m| m.low)),
                number(measured.map(|m| m.high)),
                verdict.name(),
                strict.name(),
            )?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Voxels in the list of the worst.
const WORST: usize = 12;

/// Definitions, shares, where they come from, and the worst voxels.
pub fn summary(analysis: &Analysis, scene: &str) -> String {
    let bright: Vec<&Voxel> = analysis.voxels.iter().filter(|voxel| voxel.bright).collect();
    let mut noise: Vec<f64> = bright.iter().map(|voxel| voxel.noise).collect();
    noise.sort_by(f64::total_cmp);
    let mut text = format!("{scene}\n\n{}\n", definitions(analysis));
    let whole = Shares::of(analysis, |_, _, axis| Some(axis.verdict));
    let axes = 3.0 * bright.len() as f64;
    let _ = writeln!(
        text,
        "{} of {} voxels hold {:.0} % of the energy; noise of their fluence: median {:.2} %, largest {:.2} %\n\
         of their {axes} voxel-axes, left out: {} at surfaces ({:.1} %), {} at the border ({:.1} %)\n",
        bright.len(),
        analysis.voxels.len(),
        100.0 * ENERGY,
        100.0 * noise.get(noise.len() / 2).unwrap_or(&0.0),
        100.0 * noise.last().unwrap_or(&0.0),
        whole.count(Verdict::Surface),
        100.0 * whole.count(Verdict::Surface) / axes,
        whole.count(Verdict::Border),
        100.0 * whole.count(Verdict::Border) / axes,
    );
    table_of_shares(&mut text, analysis);
    text += "\n";
    quantiles(&mut text, analysis);
    for verdict in [Verdict::TooSmall, Verdict::TooLarge] {
        worst(&mut text, analysis, verdict);
    }
    text
}

/// The shares of verdicts: with either bound and without flat axes, along each axis, and by what happened to the light.
fn table_of_shares(text: &mut String, analysis: &Analysis) {
    let whole = Shares::of(analysis, |_, _, axis| Some(axis.verdict));
    let strict = Shares::of(analysis, |_, _, axis| Some(axis.strict));
    let _ = writeln!(
        text,
        "{:<38} {:>9} {:>10} {:>9} {:>10} {:>10} {:>8}",
        format!("shares [%] (factor of {FACTOR})"),
        "judged",
        "within",
        "too small",
        "too large",
        "no data",
        "undecided"
    );
    row(text, "both bounds, by number", &whole, false);
    row(text, "both bounds, by energy", &whole, true);
    let rough = Shares::of(analysis, |_, _, axis| (!axis.flat).then_some(axis.verdict));
    row(text, "not flat in both, by number", &rough, false);
    row(text, "not flat in both, by energy", &rough, true);
    let alone = Shares::of(analysis, |_, _, axis| Some(axis.at_center));
    row(text, "the voxel alone, by number", &alone, false);
    let alone = Shares::of(analysis, |_, _, axis| (!axis.flat).then_some(axis.at_center));
    row(text, "the voxel alone, not flat, by number", &alone, false);
    row(text, "upper bound only, by number", &strict, false);
    row(text, "upper bound only, by energy", &strict, true);
    for (number, name) in ["x", "y", "z"].iter().enumerate() {
        let along = |axis, found: &Axis| (axis == number && !found.flat).then_some(found.verdict);
        let shares = Shares::of(analysis, |_, axis, found| along(axis, found));
        row(text, &format!("not flat in both, along {name}"), &shares, false);
    }
    for origin in Origin::ALL {
        let of =
            |voxel: &Voxel, found: &Axis| (voxel.origin() == origin && !found.flat).then_some(found.verdict);
        let shares = Shares::of(analysis, |voxel, _, found| of(voxel, found));
        row(text, &format!("not flat, mostly {} light", origin.name()), &shares, false);
    }
}

fn row(text: &mut String, name: &str, shares: &Shares, energy: bool) {
    let percent = |verdict| 100.0 * if energy { shares.by_energy(verdict) } else { shares.by_count(verdict) };
    if shares.judged() == 0.0 {
        let _ = writeln!(text, "{name:<38} {:>9}", 0);
        return;
    }
    let _ = writeln!(
        text,
        "{name:<38} {:>9} {:>10.2} {:>9.2} {:>10.2} {:>10.2} {:>8.2}",
        shares.judged(),
        percent(Verdict::Within),
        percent(Verdict::TooSmall),
        percent(Verdict::TooLarge),
        percent(Verdict::NoData),
        100.0 * shares.undecided()[usize::from(energy)],
    );
}

/// log2 of predicted over measured, both bounded, of a judged axis.
pub(super) fn log_ratio(analysis: &Analysis, number: usize, axis: &Axis) -> Option<f64> {
    let bounds = super::Bounds::of_voxel(super::walk::voxel_size(&analysis.layout)[number]);
    let measured = bounds.clamp(axis.measured?.sigma);
    axis.verdict.is_judged().then_some(())?;
    Some((bounds.clamp(axis.predicted?) / measured).log2())
}

fn quantiles(text: &mut String, analysis: &Analysis) {
    let mut ratios: Vec<f64> = Vec::new();
    for voxel in analysis.voxels.iter().filter(|voxel| voxel.bright) {
        let of_axis = |(number, axis): (usize, &Axis)| {
            (!axis.flat).then(|| log_ratio(analysis, number, axis)).flatten()
        };
        ratios.extend(voxel.axes.iter().enumerate().filter_map(of_axis));
    }
    ratios.sort_by(f64::total_cmp);
    *text += "quantiles of predicted/measured, not flat in both:";
    for percent in [1, 5, 25, 50, 75, 95, 99] {
        if let Some(ratio) = ratios.get((ratios.len() * percent / 100).min(ratios.len().saturating_sub(1))) {
            let _ = write!(text, "  {percent} %: {:.2}", ratio.exp2());
        }
    }
    *text += "\n";
}

fn worst(text: &mut String, analysis: &Analysis, verdict: Verdict) {
    let mut found: Vec<(&Voxel, usize)> = Vec::new();
    for voxel in analysis.voxels.iter().filter(|voxel| voxel.bright) {
        found.extend((0..3).filter(|axis| voxel.axes[*axis].verdict == verdict).map(|axis| (voxel, axis)));
    }
    found.sort_by(|a, b| b.0.energy.total_cmp(&a.0.energy));
    let _ = writeln!(text, "\n{} by more than {FACTOR}, the brightest of {}:", verdict.name(), found.len());
    if found.is_empty() {
        return;
    }
    let _ = writeln!(
        text,
        "{:>24} {:>5} {:>10} {:>9} {:>9} {:>7} {:>8} {:>9}",
        "position", "axis", "predicted", "measured", "energy %", "direct", "specular", "scattered"
    );
    for (voxel, axis) in found.into_iter().take(WORST) {
        let Axis { predicted, measured, .. } = voxel.axes[axis];
        let [x, y, z] = voxel.center.to_array();
        let [direct, specular, scattered] = voxel.origins;
        let _ = writeln!(
            text,
            "{:>24} {:>5} {:>10.3} {:>9.3} {:>9.4} {direct:>7.2} {specular:>8.2} {scattered:>9.2}",
            format!("{x:.2} {y:.2} {z:.2}"),
            ["x", "y", "z"][axis],
            predicted.unwrap_or(f64::NAN),
            measured.map_or(f64::NAN, |m| m.sigma),
            100.0 * voxel.energy,
        );
    }
}
