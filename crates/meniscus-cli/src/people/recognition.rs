//! `meniscus people study --recognition`: how often the right liquid is named.

use crate::among::among;
use crate::inputs::level;
use anyhow::{Context, ensure};
use indicatif::ProgressBar;
use meniscus_discover::identify::{IdentificationStudy, TestRecording, render_profiles, study};
use meniscus_service::identify::GlassSize;
use meniscus_virtual::observe_recording::DISPARITY_RMS_PX;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Every recording below `folder`, in the folders of their liquids, as the camera sees it with 2 mm of depth noise, held
/// against the liquids `known`.
pub(super) fn measure(folder: &Path, known: &[String], quiet: bool) -> anyhow::Result<IdentificationStudy> {
    let files = files(folder)?;
    let bar = if quiet { ProgressBar::hidden() } else { crate::bars::bar(files.len() as u64) };
    bar.set_style(crate::bars::style("the camera looks {wide_bar} {pos}/{len}, {left}")?);
    let (mut unseen, mut notes) = (Vec::new(), Vec::new());
    for (seed, file) in (1..).zip(&files) {
        let recording = level(file)?;
        let (glass, made) = (&recording.glass, &recording.provenance);
        notes = among(known, GlassSize { radius_m: glass.radius_m, fill_m: glass.fill_m })?;
        let learnt = notes.iter().find(|note| note.liquid == made.liquid);
        ensure!(
            learnt.is_none_or(|note| !note.recordings.contains(&made.motion)),
            "{} is of a motion that {} was learnt from: it is not unseen",
            file.display(),
            made.liquid
        );
        unseen.push(TestRecording {
            liquid: made.liquid.clone(),
            motion: made.motion.clone(),
            fill_m: glass.fill_m,
            profiles: render_profiles(&recording, DISPARITY_RMS_PX, seed)?,
        });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(study(&notes, &unseen))
}

/// The recordings in the folders of `folder`, by name.
fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let list = |folder: &Path| -> anyhow::Result<Vec<PathBuf>> {
        let entries = folder.read_dir().with_context(|| format!("{} cannot be listed", folder.display()))?;
        let mut paths: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
        // The order of a folder is not defined, and the seed of the noise goes by it.
        paths.sort();
        Ok(paths)
    };
    let mut files = Vec::new();
    for liquid in list(folder)?.into_iter().filter(|path| path.is_dir()) {
        let recordings = list(&liquid)?.into_iter();
        files.extend(recordings.filter(|path| path.extension().is_some_and(|end| end == "safetensors")));
    }
    ensure!(
        !files.is_empty(),
        "{} holds no LIQUID/*.safetensors: `meniscus simulate --out {}/water ...` makes some",
        folder.display(),
        folder.display()
    );
    Ok(files)
}

/// For a script.
pub(super) fn json(study: &IdentificationStudy) -> Value {
    let case = |case: &meniscus_discover::identify::Case| json!({ "liquid": case.liquid, "motion": case.motion, "said": case.standing });
    json!({
        "command": "meniscus people study --recognition",
        "version": env!("CARGO_PKG_VERSION"),
        "recordings": study.cases.iter().map(case).collect::<Vec<_>>(),
        "without_own_note": study.without.iter().map(case).collect::<Vec<_>>(),
        "checks": study.checks(),
    })
}

/// For a person, without the checks.
pub(super) fn text(study: &IdentificationStudy) -> String {
    let lines: String = (study.cases.iter())
        .filter(|case| case.standing.liquid.as_ref() != Some(&case.liquid))
        .map(|case| format!("{}, {}: {}\n", case.liquid, case.motion, case.standing.line()))
        .collect();
    let named: String = (study.without.iter())
        .filter(|case| case.standing.liquid.is_some())
        .map(|case| format!("{}, {}: {}\n", case.liquid, case.motion, case.standing.line()))
        .collect();
    let confusion = study.confusion();
    format!(
        "{confusion}\nnot named by their own name:\n{lines}\nwithout their own note, yet named:\n{named}\n"
    )
}
