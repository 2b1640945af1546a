//! Report of all parts of a sweep.

use super::manifest::Manifest;
use super::part::{Record, record};
use anyhow::{bail, ensure};
use meniscus_platform::files::{check_writable, write_whole};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Figures of a check over the parts.
struct Over {
    unit: String,
    values: Vec<f64>,
    missed: usize,
}

/// Merges the parts in `folder` into `report.json` and `report.csv`.
pub(super) fn merge(folder: &Path, partial: bool, print: bool) -> anyhow::Result<()> {
    let manifest = Manifest::read(folder)?;
    let (json_path, csv_path) = (folder.join("report.json"), folder.join("report.csv"));
    check_writable(&json_path)?;
    check_writable(&csv_path)?;
    let records: Vec<Option<Record>> =
        (0..manifest.parts.len()).map(|part| record(folder, part)).collect::<Result<_, _>>()?;
    let missing: Vec<usize> =
        (1..).zip(&records).filter(|(_, r)| r.is_none()).map(|(number, _)| number).collect();
    if let (Some(first), false) = (missing.first(), partial) {
        let folder = folder.display();
        bail!(
            "{} of {} parts are not done, the first is {first}: `meniscus sweep run {folder}` runs them, --partial merges \
             the others",
            missing.len(),
            records.len()
        );
    }
    ensure!(missing.len() < records.len(), "no part is done: there is nothing to merge");
    let report = report(&manifest, &records, &missing);
    write_whole(&json_path, format!("{report:#}\n").as_bytes())?;
    write_whole(&csv_path, table(&manifest, &records).as_bytes())?;
    if print {
        println!("{report:#}");
    } else {
        print!("{}", summary(&over(&manifest, &records)));
        println!("{} and {}", json_path.display(), csv_path.display());
    }
    Ok(())
}

/// The checks of a record that are merged: name, unit, value, verdict.
fn checks<'a>(manifest: &'a Manifest, record: &'a Record) -> impl Iterator<Item = (&'a str, &'a Value)> {
    let checks = record.answer.as_ref().and_then(|answer| answer.get("checks")).and_then(Value::as_array);
    let named = |check: &'a Value| Some((check.get("name")?.as_str()?, check));
    let merged = |(name, _): &(&str, &Value)| !manifest.leave_out.iter().any(|left| left == name);
    checks.into_iter().flatten().filter_map(named).filter(merged)
}

/// The figures of each check over all parts, by name.
fn over(manifest: &Manifest, records: &[Option<Record>]) -> BTreeMap<String, Over> {
    let mut all: BTreeMap<String, Over> = BTreeMap::new();
    for record in records.iter().flatten() {
        for (name, check) in checks(manifest, record) {
            let Some(value) = check.get("value").and_then(Value::as_f64) else { continue };
            let unit = check.get("unit").and_then(Value::as_str).unwrap_or_default().to_owned();
            let one = all.entry(name.to_owned()).or_insert(Over { unit, values: Vec::new(), missed: 0 });
            one.values.push(value);
            one.missed += usize::from(check.get("ok") == Some(&Value::Bool(false)));
        }
    }
    for one in all.values_mut() {
        one.values.sort_by(f64::total_cmp);
    }
    all
}

impl Over {
    fn mean(&self) -> f64 {
        self.values.iter().sum::<f64>() / self.values.len() as f64
    }

    /// The value in the middle; the mean of both for an even number.
    fn median(&self) -> f64 {
        let middle = self.values.len() / 2;
        if self.values.len().is_multiple_of(2) {
            0.5 * (self.values[middle - 1] + self.values[middle])
        } else {
            self.values[middle]
        }
    }
}

/// The whole report, without anything that depends on who ran the parts.
fn report(manifest: &Manifest, records: &[Option<Record>], missing: &[usize]) -> Value {
    let part = |(number, record): (usize, &Option<Record>)| {
        let plan = &manifest.parts[number - 1];
        let record = record.as_ref()?;
        let checks: Vec<&Value> = checks(manifest, record).map(|(_, check)| check).collect();
        Some(json!({
            "part": number,
            "values": plan.values,
            "command": format!("meniscus {}", plan.words.join(" ")),
            "checks": checks,
            "outputs": record.outputs,
        }))
    };
    let parts: Vec<Value> = (1..).zip(records).filter_map(part).collect();
    let rows: Vec<Value> = over(manifest, records)
        .iter()
        .map(|(name, over)| {
            json!({
                "name": name,
                "unit": over.unit,
                "parts": over.values.len(),
                "mean": over.mean(),
                "least": over.values[0],
                "median": over.median(),
                "largest": over.values[over.values.len() - 1],
                "missed": over.missed,
            })
        })
        .collect();
    json!({
        "version": manifest.version,
        "partial": !missing.is_empty(),
        "missing": missing,
        "summary": rows,
        "parts": parts,
    })
}

/// Values and checks of each part, one a line.
fn table(manifest: &Manifest, records: &[Option<Record>]) -> String {
    let names: Vec<String> = over(manifest, records).into_keys().collect();
    let mut values: Vec<&String> = manifest.parts.iter().flat_map(|part| part.values.keys()).collect();
    values.sort();
    values.dedup();
    let header = std::iter::once("part").chain(values.iter().map(|name| name.as_str()));
    let mut text =
        header.chain(names.iter().map(String::as_str)).map(quoted).collect::<Vec<_>>().join(",") + "\n";
    for (number, record) in (1..).zip(records) {
        let Some(record) = record else { continue };
        let plan = &manifest.parts[number - 1];
        let found: BTreeMap<&str, &Value> = checks(manifest, record).collect();
        let value = |name: &String| found.get(name.as_str()).and_then(|check| check.get("value")?.as_f64());
        let mut cells = vec![number.to_string()];
        cells.extend(
            values.iter().map(|name| plan.values.get(*name).map_or(String::new(), |value| quoted(value))),
        );
        cells.extend(names.iter().map(|name| value(name).map_or(String::new(), |value| value.to_string())));
        text += &(cells.join(",") + "\n");
    }
    text
}

/// A cell of a table, in quotes where it needs them (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// The summary for people.
fn summary(over: &BTreeMap<String, Over>) -> String {
    let mut text = String::new();
    if over.is_empty() {
        return "no part answered with checks: the report has the outputs\n".into();
    }
    let wide = over.keys().map(String::len).max().unwrap_or(0).max(5);
    // A `String` takes every line.
    let _written = writeln!(
        text,
        "{:wide$} {:>12} {:>12} {:>12} {:>6}  unit",
        "check", "least", "median", "largest", "parts"
    );
    for (name, over) in over {
        let (least, largest) = (over.values[0], over.values[over.values.len() - 1]);
        let _written = writeln!(
            text,
            "{name:wide$} {least:>12.5} {:>12.5} {largest:>12.5} {:>6}  {}",
            over.median(),
            over.values.len(),
            over.unit
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::manifest::Part;

    fn manifest() -> Manifest {
        let part = |x: &str| Part {
            values: [("x".to_owned(), x.to_owned())].into(),
            words: vec!["a".into(), x.into()],
        };
        Manifest {
            version: "0".into(),
            files_from: "/".into(),
            resumes: false,
            leave_out: vec!["seconds".into()],
            parts: vec![part("1"), part("two, three")],
        }
    }

    fn record(value: f64) -> Option<Record> {
        let check = |name: &str| json!({"name": name, "value": value, "unit": "%", "ok": value < 2.0});
        let answer = json!({"seconds": 3.0, "checks": [check("error"), check("seconds")]});
        Some(Record { answer: Some(answer), outputs: Vec::new() })
    }

    #[test]
    fn the_report_has_every_check_but_those_left_out() {
        let records = [record(1.0), record(4.0)];
        let report = report(&manifest(), &records, &[]);
        let summary = report["summary"].as_array().expect("rows");
        assert_eq!(summary.len(), 1);
        assert_eq!((&summary[0]["median"], &summary[0]["missed"]), (&json!(2.5), &json!(1)));
        assert_eq!(report["parts"][1]["checks"].as_array().map(Vec::len), Some(1));
        assert_eq!(table(&manifest(), &records), "part,x,error\n1,1,1\n2,\"two, three\",4\n");
    }

    #[test]
    fn a_part_that_is_missing_is_named() {
        let report = report(&manifest(), &[record(1.0), None], &[2]);
        assert_eq!((&report["partial"], &report["missing"]), (&json!(true), &json!([2])));
    }
}
