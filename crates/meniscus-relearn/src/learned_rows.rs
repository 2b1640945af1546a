//! Rows of finished runs side by side, by the names of `meniscus evaluate`.

use crate::error::RelearnError;
use crate::folder::Folder;
use meniscus_report::checks::Check;
use serde_json::Value;
use std::path::Path;

/// Name in the report of a run, name behind `LIQUID_learned_`, and largest value, per cent.
const ERRORS: [(&str, &str, f64); 7] = [
    ("held_q", "field_q", 7.0),
    ("held_v", "field_v", 10.0),
    ("held_e", "field_e", 25.0),
    ("held_sigma_frame_late", "sigma_frame_late", 20.0),
    ("held_tau", "field_tau", 20.0),
    ("held_surface", "slosh", 4.0),
    ("held_planned_250ms", "planned_250ms", 8.0),
];

/// Largest error of v in honey, per cent: the slosh is gone within half a period.
const HONEY_V: f64 = 15.0;

/// Largest ratio of an error to that of the model that was learned with the true liquid.
const OVER_ORACLE: f64 = 1.25;

/// Returns the figures of the finished run in `folder`, under the name of its liquid. Groups that the model does not know have no row.
///
/// # Errors
/// [`RelearnError::Unfinished`] without a report, [`RelearnError::Malformed`] when it is not one of this program.
pub fn learned_rows(folder: &Path) -> Result<Vec<Check>, RelearnError> {
    let path = Folder::new(folder).report();
    let text = std::fs::read_to_string(&path).map_err(|_| RelearnError::Unfinished(folder.into()))?;
    let malformed = |fault: String| RelearnError::Malformed { path: path.clone(), fault };
    let report: Value = serde_json::from_str(&text).map_err(|error| malformed(error.to_string()))?;
    let liquid = report["liquid"].as_str().ok_or_else(|| malformed("it names no liquid".into()))?;
    let figures = report["checks"].as_array().ok_or_else(|| malformed("it has no checks".into()))?;
    let value = |name: &str| figures.iter().find(|figure| figure["name"] == name)?["value"].as_f64();
    let mut rows = Vec::new();
    for (from, to, most) in ERRORS {
        let Some(error) = value(from) else { continue };
        let most = if (liquid, to) == ("honey", "field_v") { HONEY_V } else { most };
        rows.push(Check::at_most(format!("{liquid}_learned_{to}"), error, "%", most));
        if let Some(oracle) = value(&format!("oracle_{from}")) {
            let name = format!("{liquid}_learned_{to}_over_oracle");
            rows.push(Check::at_most(name, error / oracle, "1", OVER_ORACLE));
        }
    }
    for figure in figures {
        let named = figure["name"].as_str().and_then(|name| name.strip_prefix("coverage_"));
        let Some((group, share)) = named.zip(figure["value"].as_f64()) else { continue };
        rows.push(Check::within(format!("{liquid}_learned_coverage_{group}"), share, "%", 85.0, 95.0));
    }
    if let Some(shown) = value("unknown_groups_shown") {
        rows.push(Check::exactly(format!("{liquid}_learned_unknown_groups_shown"), shown, "1", 0.0));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows_of(report: &str) -> Result<Vec<Check>, RelearnError> {
        let folder = std::env::temp_dir().join(format!("meniscus-learned-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("report.json"), report).expect("written");
        let rows = learned_rows(&folder);
        std::fs::remove_dir_all(&folder).expect("removed");
        rows
    }

    #[test]
    fn rows_have_the_liquids_name_and_its_targets() {
        let rows = rows_of(
            r#"{ "liquid": "honey", "checks": [{ "name": "held_v", "value": 12.0 }, { "name": "held_q", "value": 8.0 },
                { "name": "coverage_v", "value": 80.0 }, { "name": "oracle_held_v", "value": 8.0 }] }"#,
        )
        .expect("a report");
        let of = |name: &str| rows.iter().find(|row| row.name == name).expect("a row");
        assert_eq!(of("honey_learned_field_v").ok, Some(true));
        assert_eq!(of("honey_learned_field_q").ok, Some(false));
        assert_eq!(of("honey_learned_field_v_over_oracle").ok, Some(false));
        assert_eq!(of("honey_learned_coverage_v").ok, Some(false));
        assert!(rows.iter().all(|row| !row.name.contains("field_e")), "{rows:?}");
    }

    #[test]
    fn a_run_without_a_report_and_a_broken_report_are_refused() {
        let nowhere = Path::new("no-such-run");
        assert!(matches!(learned_rows(nowhere), Err(RelearnError::Unfinished(_))));
        assert!(matches!(rows_of("{ \"checks\": [] }"), Err(RelearnError::Malformed { .. })));
    }
}
