//! Share of recordings whose liquid is identified correctly; nothing is learnt from them.

use meniscus::identify::{Recogniser, Trail};
use meniscus::surface::{ConfigError, Settings, SurfaceProfile};
use meniscus_data::recording::Recording;
use meniscus_report::checks::Check;
use meniscus_service::identify::{MOST, Note, Standing, split};
use meniscus_virtual::observe_recording::sightings;
use meniscus_virtual::render::SceneSettings;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Recording whose liquid is to be identified.
#[derive(Debug)]
pub struct TestRecording {
    /// Its liquid, in truth.
    pub liquid: String,
    /// Its motion.
    pub motion: String,
    /// Height of the liquid at rest, m.
    pub fill_m: f64,
    /// Profiles of the camera.
    pub profiles: Vec<Option<SurfaceProfile>>,
}

/// Verdict on one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The liquid in truth.
    pub liquid: String,
    /// Its motion.
    pub motion: String,
    /// Verdict.
    pub standing: Standing,
}

/// Verdicts on all recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct IdentificationStudy {
    /// Liquids that were learnt.
    pub names: Vec<String>,
    /// The recordings.
    pub cases: Vec<Case>,
    /// Those of learnt liquids once more, judged by the other liquids alone: their own liquid is unknown then.
    pub without: Vec<Case>,
}

/// Renders `recording` for a camera whose disparity has this noise, pixels rms.
///
/// # Errors
/// [`ConfigError`], when its glass cannot be rendered.
pub fn render_profiles(
    recording: &Recording,
    disparity_rms_px: f64,
    seed: u64,
) -> Result<Vec<Option<SurfaceProfile>>, ConfigError> {
    let glass = &recording.glass;
    let camera = Settings::for_glass(glass.radius_m, glass.fill_m, glass.rim_m);
    sightings(recording, SceneSettings { camera, disparity_rms_px, seed, ..SceneSettings::default() })
}

/// Returns the verdict of `notes` on `profiles`, in a glass where the liquid rests at `fill_m`.
///
/// After every frame `each` gets the trail.
pub fn recognise(
    notes: &[Note],
    fill_m: f64,
    profiles: &[Option<SurfaceProfile>],
    mut each: impl FnMut(usize, &Trail<MOST>, &Recogniser<'_>),
) -> Standing {
    let (names, known) = split(notes);
    let recogniser = Recogniser::new(&known, fill_m);
    let mut trail = Trail::<MOST>::default();
    for (frame, profile) in profiles.iter().enumerate() {
        recogniser.turn(&mut trail, profile.as_ref());
        each(frame, &trail, &recogniser);
    }
    Standing::of(&names, &recogniser, &trail, 0)
}

/// Returns the verdict of `notes` on each of `unseen`, with and without the note of its own liquid.
#[must_use]
pub fn study(notes: &[Note], unseen: &[TestRecording]) -> IdentificationStudy {
    let judge = |notes: &[Note], one: &TestRecording| Case {
        liquid: one.liquid.clone(),
        motion: one.motion.clone(),
        standing: recognise(notes, one.fill_m, &one.profiles, |_, _, _| {}),
    };
    let names = split(notes).0;
    let without = |one: &&TestRecording| {
        let others: Vec<Note> = notes.iter().filter(|note| note.liquid != one.liquid).cloned().collect();
        judge(&others, one)
    };
    let learnt = unseen.iter().filter(|one| names.contains(&one.liquid));
    IdentificationStudy {
        cases: unseen.iter().map(|one| judge(notes, one)).collect(),
        without: learnt.map(|one| without(&one)).collect(),
        names,
    }
}

impl IdentificationStudy {
    /// Returns the recordings of liquids that were learnt, or of those that were not.
    fn of(&self, known: bool) -> impl Iterator<Item = &Case> {
        self.cases.iter().filter(move |case| self.names.contains(&case.liquid) == known)
    }

    /// Returns the share of the recordings of known liquids that were identified correctly, each liquid counted alike however many
    /// recordings there are of it; NaN of none.
    #[must_use]
    pub fn accuracy(&self) -> f64 {
        by_liquid(self.of(true), |case| case.standing.liquid.as_ref() == Some(&case.liquid))
    }

    /// Returns the share of the recordings of unknown liquids for which no liquid was identified, counted in the same way.
    #[must_use]
    pub fn refused(&self) -> f64 {
        by_liquid(self.of(false), |case| case.standing.liquid.is_none())
    }

    /// Returns the two figures with their targets, and the Brier score of the answers.
    #[must_use]
    pub fn checks(&self) -> Vec<Check> {
        let right = |case: &Case| {
            let own = case.standing.probabilities.iter().find(|(name, _)| *name == case.liquid);
            own.map_or(case.standing.none, |(_, p)| *p)
        };
        let count = |known| self.of(known).count() as f64;
        let brier = self.cases.iter().map(|case| (1.0 - right(case)).powi(2)).sum::<f64>();
        vec![
            Check::at_least("recognition_accuracy", self.accuracy(), "1", 0.9),
            Check::at_least("unknown_refused", self.refused(), "1", 0.8),
            Check::informational("recognition_recordings", count(true), "1"),
            Check::informational("unknown_recordings", count(false), "1"),
            Check::informational(
                "refused_without_own",
                by_liquid(self.without.iter(), |case| case.standing.liquid.is_none()),
                "1",
            ),
            Check::informational("recognition_brier", brier / self.cases.len() as f64, "1"),
        ]
    }

    /// Returns the confusion table, one line per liquid.
    #[must_use]
    pub fn confusion(&self) -> String {
        let mut liquids: Vec<&String> = self.names.iter().collect();
        for case in &self.cases {
            if !liquids.contains(&&case.liquid) {
                liquids.push(&case.liquid);
            }
        }
        let width = liquids.iter().map(|name| name.len()).max().unwrap_or(0).max(8);
        // Writing into a string cannot fail.
        let mut text = format!("{:width$}", "in truth");
        for name in self.names.iter().map(String::as_str).chain(["none"]) {
            let _ = write!(text, "  {name:>width$}");
        }
        text.push('\n');
        for liquid in liquids {
            let of = || self.cases.iter().filter(|case| case.liquid == *liquid);
            if of().next().is_none() {
                continue;
            }
            let _ = write!(text, "{liquid:width$}");
            for said in self.names.iter().map(Some).chain([None]) {
                let count = of().filter(|case| case.standing.liquid.as_ref() == said).count();
                let _ = write!(text, "  {:>width$}", if count > 0 { format!("{count}") } else { ".".into() });
            }
            text.push('\n');
        }
        text
    }
}

/// Returns the mean over liquids of the share of `of` that is `so`; NaN without a case.
fn by_liquid<'c>(of: impl Iterator<Item = &'c Case>, so: impl Fn(&Case) -> bool) -> f64 {
    let mut sums: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for case in of {
        let (yes, all) = sums.entry(&case.liquid).or_default();
        *yes += f64::from(u8::from(so(case)));
        *all += 1.0;
    }
    sums.values().map(|(yes, all)| yes / all).sum::<f64>() / sums.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(liquid: &str, said: Option<&str>) -> Case {
        let standing = Standing { liquid: said.map(String::from), none: 0.5, ..Standing::default() };
        Case { liquid: liquid.into(), motion: "strokes:1".into(), standing }
    }

    #[test]
    fn known_and_unknown_are_counted_apart() {
        let names = vec!["water".into(), "honey".into()];
        let cases = vec![
            case("water", Some("water")),
            case("water", Some("honey")),
            case("honey", Some("honey")),
            case("honey", None),
            case("honey", None),
            case("tar", None),
            case("tar", Some("honey")),
        ];
        let without = vec![case("water", None), case("honey", Some("water"))];
        let study = IdentificationStudy { names, cases, without };
        let third = 0.5 * (0.5 + 1.0 / 3.0);
        assert_eq!((study.accuracy(), study.refused()), (third, 0.5), "liquids count alike");
        let text = study.confusion();
        let row = |name: &str| -> Vec<&str> {
            let line = text.lines().find(|line| line.starts_with(name)).expect("a line");
            line.split_whitespace().skip(1).collect()
        };
        assert_eq!(
            (row("water"), row("honey"), row("tar")),
            (vec!["1", "1", "."], vec![".", "1", "2"], vec![".", "1", "1"])
        );
        let checks = study.checks();
        assert!(checks[0].missed() && checks[1].missed());
        assert_eq!(checks[4].value, Some(0.5), "refused where its own note was taken away");
    }
}
