//! Sentences of a drawn law.

use super::draw::Drawn;
use super::nearest::Range;

impl Drawn {
    /// Returns the law in sentences: its curves, what it explains, the nearest formula and where it departs from it.
    #[must_use]
    pub fn sentence(&self) -> String {
        let parts = [self.curves(), self.explained(), self.formula()];
        parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
    }

    /// Returns the sentence of both curves.
    fn curves(&self) -> String {
        let (force, drag) = (&self.bands.force, &self.bands.drag);
        let ends = |all: &[f64]| (1e3 * all[0], 1e3 * all[all.len() - 1]);
        let (low, high) = ends(&force.value);
        let reach_mm = 1e3 * self.fit.extent.reach_m;
        let lopsided = 100.0 * self.even_share;
        let mut out = format!(
            "A law without a name is drawn: a force of {low:.1} to {high:.1} mN on the first mode at heights of -{reach_mm:.0} to \
             {reach_mm:.0} mm ({lopsided:.0} % of it lopsided), and a drag of {:.1} mN in a cycle whose rate reaches {:.2} m/s",
            1e3 * drag.value[drag.value.len() - 1],
            self.fit.extent.fastest_m_s
        );
        match &self.power {
            Some(power) if power.distance <= 1.0 => {
                out += &format!(", within its band a power {:.2} of the rate.", power.exponent);
            }
            Some(_) => out += ", which no power of the rate follows within its band.",
            None => out += ", which its band does not distinguish from none.",
        }
        out
    }

    /// Returns the sentence of what the law explains.
    fn explained(&self) -> String {
        let left_out = format!(
            "{} of {} recordings are predicted better when they are left out of its fit.",
            self.held_out.better, self.held_out.recordings
        );
        match &self.gap {
            Some(gap) => format!(
                "With it the held-out recording has an error of {:.3} mm; {left_out}",
                1e3 * gap.law_m
            ),
            None => left_out,
        }
    }

    /// Returns the sentence of the nearest formula.
    fn formula(&self) -> String {
        let Some(near) = &self.nearest else {
            return "No formula of the library could be fitted beside it.".into();
        };
        let listed = |ranges: &[Range], scale: f64, digits: usize, unit: &str| {
            let one = |r: &Range| format!("{:.digits$} to {:.digits$} {unit}", scale * r.from, scale * r.to);
            ranges.iter().map(one).collect::<Vec<_>>().join(" and ")
        };
        let mut departs = Vec::new();
        if !near.heights.is_empty() {
            departs.push(format!("in the force at heights of {}", listed(&near.heights, 1e3, 1, "mm")));
        }
        if !near.rates.is_empty() {
            departs.push(format!("in the drag at rates of {}", listed(&near.rates, 1.0, 3, "m/s")));
        }
        if departs.is_empty() {
            return format!("The nearest formula of the library, {}, stays within the bands.", near.name);
        }
        format!(
            "The nearest formula of the library is {}; the law departs from it by more than its band {}.",
            near.name,
            departs.join(", and ")
        )
    }
}
