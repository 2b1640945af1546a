//! One training from several seeds: what of a figure is the method's, and what is chance.

use meniscus_report::checks::Check;
use std::fmt::Write;

/// One figure over the seeds.
#[derive(Clone, Debug)]
pub struct SeedSpread {
    /// The figure as the first seed gave it: its name, unit and target.
    pub figure: Check,
    /// Its value from every seed; NaN where it could not be measured.
    pub values: Vec<f64>,
    /// Mean.
    pub mean: f64,
    /// Standard deviation over the seeds, with one degree of freedom taken by the mean; 0 of a single seed.
    pub deviation: f64,
    /// The worst value, by the figure's target.
    pub worst: f64,
}

/// Every figure of `runs`, one run a seed, that all of them have, in the order of the first.
#[must_use]
pub fn over_seeds(runs: &[Vec<Check>]) -> Vec<SeedSpread> {
    let first = runs.first().map(Vec::as_slice).unwrap_or_default();
    first.iter().filter_map(|figure| spread(figure, runs)).collect()
}

/// mean = sum x / n,  deviation^2 = sum (x - mean)^2 / (n - 1)
fn spread(figure: &Check, runs: &[Vec<Check>]) -> Option<SeedSpread> {
    let of = |run: &Vec<Check>| run.iter().find(|check| check.name == figure.name).cloned();
    let same: Vec<Check> = runs.iter().map(of).collect::<Option<_>>()?;
    let values: Vec<f64> = same.iter().map(|check| check.value.unwrap_or(f64::NAN)).collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    // What could not be measured is worse than anything.
    let bad = |x: f64| if x.is_nan() { f64::INFINITY } else { figure.badness(x) };
    let worst = values.iter().copied().max_by(|a, b| bad(*a).total_cmp(&bad(*b)))?;
    let deviation = (square / (n - 1.0).max(1.0)).sqrt();
    Some(SeedSpread { figure: figure.clone(), values, mean, deviation, worst })
}

impl SeedSpread {
    /// The three as checks: NAME_mean and NAME_worst against the figure's target, NAME_sd for information.
    #[must_use]
    pub fn checks(&self) -> [Check; 3] {
        let name = |what: &str| format!("{}_{what}", self.figure.name);
        [
            self.figure.with(name("mean"), self.mean),
            Check::informational(name("sd"), self.deviation, self.figure.unit),
            self.figure.with(name("worst"), self.worst),
        ]
    }
}

/// The table of `spreads` in Markdown, a column a seed; `command` made them.
#[must_use]
pub fn markdown(spreads: &[SeedSpread], seeds: &[u64], command: &str) -> String {
    let mut page = format!(
        "`{command}`, meniscus {}.\n\nOf every figure the mean over {} seeds, its standard deviation, the worst, and \
         what each seed gave. MISSED: the worst misses the target.\n\n| figure | unit | target | mean | deviation | \
         worst | |",
        env!("CARGO_PKG_VERSION"),
        seeds.len()
    );
    for seed in seeds {
        // Writing to a string cannot fail.
        let _ = write!(page, " {seed} |");
    }
    let _ = writeln!(page, "\n|{}", "---|".repeat(7 + seeds.len()));
    for spread in spreads {
        let [_, _, worst] = spread.checks();
        let verdict = worst.verdict();
        let figure = &spread.figure;
        let _ = write!(
            page,
            "| {} | {} | {} | {} | {} | {} | {verdict} |",
            figure.name.replace('|', "\\|"),
            figure.unit,
            figure.target,
            short(spread.mean),
            short(spread.deviation),
            short(spread.worst)
        );
        for &value in &spread.values {
            let _ = write!(page, " {} |", short(value));
        }
        page.push('\n');
    }
    page
}

/// Three significant digits.
fn short(value: f64) -> String {
    match value.abs() {
        0.0 => String::from("0"),
        size if (1e-2..1e5).contains(&size) => {
            let decimals = (2 - size.log10().floor() as i32).clamp(0, 4) as usize;
            format!("{value:.decimals$}")
        }
        _ if value.is_nan() => String::from("not measured"),
        _ => format!("{value:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_deviation_and_worst() {
        let run = |error: f64, held: f64| {
            let surface = Check::at_most("surface", error, "%", 8.0);
            vec![
                surface,
                Check::within("coverage", held, "%", 85.0, 95.0),
                Check::informational("one", 1.0, "1"),
            ]
        };
        let mut runs = vec![run(4.0, 91.0), run(9.0, 84.0), run(5.0, 99.0)];
        runs[1].pop();
        let spreads = over_seeds(&runs);
        assert_eq!(spreads.len(), 2, "a figure that one seed lacks is left out");
        assert!((spreads[0].mean - 6.0).abs() < 1e-12);
        assert!((spreads[0].deviation - 7.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((spreads[0].worst, spreads[1].worst), (9.0, 99.0));
        let [mean, sd, worst] = spreads[0].checks();
        assert_eq!([mean.ok, sd.ok, worst.ok], [Some(true), None, Some(false)]);
        assert_eq!(worst.name, "surface_worst");
        let page = markdown(&spreads, &[1, 2, 3], "meniscus train");
        assert!(
            page.contains("| surface | % | <= 8 | 6.00 | 2.65 | 9.00 | MISSED | 4.00 | 9.00 | 5.00 |"),
            "{page}"
        );
    }

    #[test]
    fn what_one_seed_could_not_measure_is_the_worst() {
        let runs = [1.0, f64::NAN].map(|x| vec![Check::at_most("a", x, "1", 2.0)]);
        let spreads = over_seeds(&runs);
        assert!(spreads[0].worst.is_nan() && spreads[0].checks()[2].missed());
    }
}
