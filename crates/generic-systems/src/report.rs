//! The nets side by side: checks, a page, a picture.

use super::Outcome;
use super::judge::Figures;
use meniscus_report::checks::Check;
use meniscus_report::plot::{BLUE, FONT, GREY, ORANGE, PURPLE, PictureError, legend, prepare_font};
use plotters::prelude::*;
use std::fmt::Write;
use std::path::Path;

/// Size of one panel of the picture, pixels, and panels in a row.
const PANEL: (u32, u32) = (620, 260);
const ACROSS: usize = 2;

/// Largest drift of the energy in a step of the exact net, of what a step passes around.
const DRIFT: f64 = 1e-9;

/// Every figure. Where there is a published net, the exact one is to miss no more of any variable than it.
#[must_use]
pub fn checks(outcome: &Outcome) -> Vec<Check> {
    let mut checks = Vec::new();
    let published = outcome.of("published");
    for figures in &outcome.figures {
        let name = |what: &str| format!("{}_{what}", figures.name);
        let exact = figures.name == "exact";
        let rollout = 100.0 * figures.rollout;
        checks.push(match published {
            Some(other) if exact => Check::at_most(name("rollout"), rollout, "%", 100.0 * other.rollout),
            _ => Check::informational(name("rollout"), rollout, "%"),
        });
        for (k, &mse) in figures.mse.iter().enumerate() {
            let name = name(&format!("mse_{}", outcome.names[k]));
            checks.push(match published {
                // What does not move is missed by nothing but rounding, by neither.
                Some(other) if exact => Check::at_most(name, mse, "unit2", other.mse[k].max(1e-14)),
                _ => Check::informational(name, mse, "unit2"),
            });
        }
        let falls = f64::from(figures.falls);
        checks.push(if exact {
            Check::exactly("entropy_falls", falls, "1", 0.0)
        } else {
            Check::informational(name("entropy_falls"), falls, "1")
        });
        if let Some(falls) = figures.system_falls.map(f64::from) {
            checks.push(if exact {
                Check::exactly("exact_system_entropy_falls", falls, "1", 0.0)
            } else {
                Check::informational(name("system_entropy_falls"), falls, "1")
            });
        }
        for (what, figure) in ["energy_drift", "L_dS", "M_dE"].iter().zip(figures.laws) {
            checks.push(if exact {
                Check::at_most(name(what), figure, "1", 1e-9)
            } else {
                Check::informational(name(what), figure, "1")
            });
        }
        if exact {
            checks.push(Check::at_most("energy_drift_step", figures.drift, "1", DRIFT));
            checks.push(Check::exactly("exact_steps_held", f64::from(figures.held), "1", 0.0));
        }
    }
    checks
}

/// The page: a table of errors, a table of laws, and the picture's name.
#[must_use]
pub fn markdown(outcome: &Outcome, command: &str) -> String {
    let judged = outcome.data.test.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let steps = outcome.data.paths.first().map_or(0, Vec::len);
    let mut page = format!(
        "`{command}`, meniscus {}.\n\nRoll-outs over {steps} steps of {} s from the first state of the trajectories \
         that nothing was learnt from or chosen by: {judged}.\n\n| net |",
        env!("CARGO_PKG_VERSION"),
        outcome.data.dt_s
    );
    // Writing to a string cannot fail.
    for name in &outcome.names {
        let _ = write!(page, " {name} |");
    }
    let _ = writeln!(page, " all, relative |\n|{}", "---|".repeat(outcome.names.len() + 2));
    for Figures { name, mse, rollout, .. } in &outcome.figures {
        let _ = write!(page, "| {name} |");
        for error in mse {
            let _ = write!(page, " {error:.2e} |");
        }
        let _ = writeln!(page, " {:.2} % |", 100.0 * rollout);
    }
    page += "\nMean square errors in the unit of the variable squared; the last column is the root mean square over the \
             variables that move of |z - said| / |z - mean of z|.\n\n| net | steps whose entropy falls | \
             energy, \\|dE . dz\\| / (\\|dE\\| \\|dz\\|) | \\|L dS\\| / \\|L dE\\| | \\|M dE\\| / \\|M dS\\| |\n\
             |---|---|---|---|---|\n";
    for Figures { name, steps, falls, laws: [drift, l_ds, m_de], .. } in &outcome.figures {
        let _ = writeln!(page, "| {name} | {falls} of {steps} | {drift:.1e} | {l_ds:.1e} | {m_de:.1e} |");
    }
    if let Some(exact) = outcome.of("exact") {
        let _ = writeln!(
            page,
            "\nThe exact net's energy changes by at most {:.1e} in a step, of what a step passes around between the \
             variables on average; {} steps could not be solved.",
            exact.drift, exact.held
        );
    }
    page
}

fn colour(name: &str) -> RGBColor {
    match name {
        "exact" => BLUE,
        "soft" => PURPLE,
        _ => ORANGE,
    }
}

/// One line of a panel: its points, colour and name.
type Line<'a> = (Vec<(f64, f64)>, RGBColor, &'a str);

/// Draws the error over time, and every variable that moves of the first trajectory that judges.
///
/// # Errors
/// [`PictureError`], when the file cannot be written.
pub fn rollouts_png(outcome: &Outcome, path: &Path) -> Result<(), PictureError> {
    prepare_font();
    let shown: Vec<usize> = (0..outcome.names.len()).filter(|&k| outcome.moving[k]).collect();
    let rows = (1 + shown.len()).div_ceil(ACROSS);
    let size = (PANEL.0 * ACROSS as u32, PANEL.1 * rows as u32);
    let area = BitMapBackend::new(path, size).into_drawing_area();
    area.fill(&WHITE)?;
    let panels = area.split_evenly((rows, ACROSS));
    let at = |step: usize| step as f64 * outcome.data.dt_s;
    let over_time = |figures: &Figures| {
        figures.over_time.iter().enumerate().map(|(k, e)| (at(k), 100.0 * e)).collect::<Vec<_>>()
    };
    let errors: Vec<Line<'_>> =
        outcome.figures.iter().map(|f| (over_time(f), colour(f.name), f.name)).collect();
    panel(&panels[0], "error of all test trajectories", "relative, %", &errors, true)?;
    let Some(&first) = outcome.data.test.first() else { return Ok(area.present()?) };
    for (&k, area) in shown.iter().zip(&panels[1..]) {
        let of = |path: &[nalgebra::DVector<f64>]| {
            path.iter().enumerate().map(|(n, z)| (at(n), z[k])).collect::<Vec<_>>()
        };
        let mut lines: Vec<Line<'_>> = vec![(of(&outcome.data.paths[first]), GREY, "truth")];
        lines.extend(outcome.figures.iter().map(|f| (of(&f.paths[0]), colour(f.name), f.name)));
        panel(area, &format!("trajectory {first}"), &outcome.names[k], &lines, false)?;
    }
    Ok(area.present()?)
}

fn panel(
    area: &DrawingArea<BitMapBackend<'_>, plotters::coord::Shift>,
    title: &str,
    y: &str,
    lines: &[Line<'_>],
    named: bool,
) -> Result<(), PictureError> {
    let all = || lines.iter().flat_map(|line| &line.0);
    let end = all().map(|p| p.0).fold(0.0, f64::max);
    // What has left the truth by far must not flatten the rest: the first line, or half a unit of error, sets the scale.
    let scale: Vec<f64> = if named {
        all().map(|p| p.1.min(100.0)).collect()
    } else {
        lines.first().map(|line| line.0.iter().map(|p| p.1).collect()).unwrap_or_default()
    };
    let least = scale.iter().copied().fold(if named { 0.0 } else { f64::INFINITY }, f64::min);
    let most = scale.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let room = 0.1 * (most - least).max(1e-9);
    let least = if named { 0.0 } else { least - room };
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 16))
        .margin(8)
        .margin_right(20)
        .x_label_area_size(32)
        .y_label_area_size(56)
        // Room beside the curves for their names.
        .build_cartesian_2d(0.0..1.32 * end, least..most + room)?;
    chart.configure_mesh().x_desc("time, s").y_desc(y).x_labels(7).y_labels(6).draw()?;
    for (points, colour, name) in lines {
        let kept = points.iter().copied().map(|(x, y)| (x, y.clamp(least, most + room)));
        let (colour, wide) = (*colour, if *name == "truth" { 4 } else { 2 });
        chart
            .draw_series(LineSeries::new(kept, colour.stroke_width(wide)))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3)));
    }
    legend(&mut chart, SeriesLabelPosition::UpperRight)?;
    Ok(())
}
