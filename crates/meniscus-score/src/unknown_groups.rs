//! Field groups that the outputs of a run show although the model does not know them: there should be none.
//!
//! Each output is made as a run makes it and read back as its readers do: the field of a turn, packet, field frame, estimate
//! file, page and picture. [`in_checks`] reads the rows of a report.

use crate::score::field_of;
use meniscus::blob::{FieldGroup, KnownGroups, Model};
use meniscus::latent::decoder::GROUP_COMPONENTS;
use meniscus::runtime::output::{OUTPUT_MAX, Packet};
use meniscus::runtime::{Estimator, Memory, Mode, TurnInput};
use meniscus_data::recording::{EstimateRecording, GROUP_NAMES, Lattice, Recording, STATE};
use meniscus_platform::clock::NoClock;
use meniscus_report::checks::Check;
use meniscus_service::publish::FieldFrame;
use meniscus_service::timed_turn::TimedTurn;
use meniscus_ui::figure_parts::slice;
use meniscus_ui::page::{Messages, messages};
use serde_json::Value;

/// Group that an output shows and the model does not know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownShown {
    /// Name of the output.
    pub output: &'static str,
    /// Group.
    pub group: FieldGroup,
}

/// Returns the groups that the outputs for the last tracked turn of `turns` show and `model` does not know.
#[must_use]
pub fn in_outputs(model: &Model<'_>, recording: &Recording, turns: &[TimedTurn]) -> Vec<UnknownShown> {
    let tracked = turns.iter().rev().find(|logged| logged.turn.estimate.mode == Mode::Tracking);
    let Some(logged) = tracked else { return Vec::new() };
    let packet = Packet::of(&logged.turn, 0, &model.header);
    let outputs = [
        ("turn", of_turn(model)),
        ("packet", of_packet(&packet)),
        ("field frame", of_field_frame(model, &packet, logged)),
        ("estimate file", of_estimates(&packet)),
        ("page", of_page(&messages(model, logged))),
        ("picture", of_picture(model, recording, logged)),
    ];
    outputs.into_iter().flat_map(|(output, shown)| outside(output, shown, model.header.known())).collect()
}

/// Returns the groups that the rows of a report show and that are not in `known`.
#[must_use]
pub fn in_checks(checks: &[Check], known: KnownGroups) -> Vec<UnknownShown> {
    let shown = named(|name| {
        let ends = [format!("field_{name}"), format!("field_error_{name}"), format!("coverage_{name}")];
        let late = format!("field_{name}_frame_late");
        let error_late = format!("field_error_{name}_frame_late");
        let shows = |check: &Check| {
            let row = check.name.as_str();
            check.value.is_some()
                && (ends.iter().any(|end| row.ends_with(end))
                    || row.ends_with(&late)
                    || row.ends_with(&error_late))
        };
        checks.iter().any(shows)
    });
    outside("report", shown, known).collect()
}

/// Returns the groups of `shown` that are not in `known`.
fn outside(
    output: &'static str,
    shown: KnownGroups,
    known: KnownGroups,
) -> impl Iterator<Item = UnknownShown> {
    let groups = FieldGroup::ALL.into_iter().filter(move |g| shown.contains(*g) && !known.contains(*g));
    groups.map(move |group| UnknownShown { output, group })
}

/// Returns the groups of the field whose name `is` shown.
fn named(is: impl Fn(&str) -> bool) -> KnownGroups {
    let groups = FieldGroup::ALL.into_iter().zip(GROUP_NAMES).filter(|(_, name)| is(name));
    groups.fold(KnownGroups::NONE, |shown, (group, _)| shown.with(group))
}

/// Returns the groups whose half-width or total is a number.
fn of_numbers(halves: &[f32], slosh_j: f64, heat_j: f64) -> KnownGroups {
    let shown = FieldGroup::ALL.into_iter().zip(halves).filter(|(_, half)| half.is_finite());
    let mut shown = shown.fold(KnownGroups::NONE, |shown, (group, _)| shown.with(group));
    if slosh_j.is_finite() {
        shown = shown.with(FieldGroup::Velocity);
    }
    if heat_j.is_finite() {
        shown = shown.with(FieldGroup::InternalEnergy);
    }
    shown
}

/// Returns the groups that a turn writes into its field.
fn of_turn(model: &Model<'_>) -> KnownGroups {
    // A variant without a field writes none of it.
    let mut field = vec![f32::NAN; model.field_len()];
    Estimator::new(model).turn(&mut Memory::default(), TurnInput::default(), &mut NoClock, &mut field);
    let tracers = model.header.particles as usize;
    let mut first = 0;
    let mut written = FieldGroup::ALL.into_iter().zip(GROUP_COMPONENTS).filter(|(_, components)| {
        let part = &field[first..first + components * tracers];
        first += part.len();
        part.iter().any(|number| number.is_finite())
    });
    written.by_ref().fold(KnownGroups::NONE, |shown, (group, _)| shown.with(group))
}

/// Returns the groups in the bytes of a packet; all if it cannot be read.
fn of_packet(packet: &Packet) -> KnownGroups {
    let mut buffer = [0; OUTPUT_MAX];
    let read = packet.write(&mut buffer).and_then(Packet::read);
    read.map_or(KnownGroups::ALL, |Packet { estimate, .. }| {
        of_numbers(&estimate.interval.field, estimate.slosh_j, estimate.heat_j)
    })
}

/// Returns the groups in a field frame, made from a field that has all of them.
fn of_field_frame(model: &Model<'_>, packet: &Packet, logged: &TimedTurn) -> KnownGroups {
    let mut field = vec![0.0; model.field_len()];
    field_of(model, &logged.turn.estimate, &mut field);
    let mut frame = FieldFrame::room(&model.header, field.len());
    frame.take(packet, &field);
    let sizes = FieldGroup::ALL.into_iter().zip(GROUP_COMPONENTS);
    let stated = sizes.filter(|(group, _)| frame.groups.contains(*group)).map(|(_, components)| components);
    let numbers = stated.sum::<usize>() * model.header.particles as usize;
    // Numbers of no stated group could be those of any.
    if frame.field.len() == numbers { frame.groups } else { KnownGroups::ALL }
}

/// Returns the groups in the columns of an estimate file.
fn of_estimates(packet: &Packet) -> KnownGroups {
    let file = EstimateRecording::of(std::slice::from_ref(packet), "");
    of_numbers(&file.group_half, file.energy_j[0], file.energy_j[1])
}

/// Returns the groups that the page can show from its messages; all if they cannot be read.
fn of_page(messages: &Messages) -> KnownGroups {
    page_groups(messages).unwrap_or(KnownGroups::ALL)
}

/// Returns the groups with a basis, with numbers at rest (but for positions, which say where a tracer is drawn), or with a
/// half-width or total.
fn page_groups(messages: &Messages) -> Option<KnownGroups> {
    let Messages { model, frame } = messages;
    let length = u32::from_le_bytes(*model.first_chunk()?) as usize;
    let facts: Value = serde_json::from_slice(model.get(4..4 + length)?).ok()?;
    let names = facts["numbers"].as_array()?;
    let number = |name: &str| {
        let place = 16 + 8 * names.iter().position(|one| one == name)?;
        frame.get(place..)?.first_chunk().map(|bytes| f64::from_le_bytes(*bytes))
    };
    let groups = facts["groups"].as_array()?;
    let drawn = named(|name| {
        let group = groups.iter().find(|group| group["name"] == name);
        group.is_none_or(|group| group["rank"] != 0 || group["numbers"] != 0 && name != "q")
    });
    let halves: Option<Vec<f32>> =
        GROUP_NAMES.iter().map(|name| Some(number(&format!("{name}_half"))? as f32)).collect();
    let known = of_numbers(&halves?, number("slosh_j")?, number("heat_j")?);
    Some(FieldGroup::ALL.into_iter().filter(|g| known.contains(*g)).fold(drawn, KnownGroups::with))
}

/// Returns the groups in the slice of a picture.
fn of_picture(model: &Model<'_>, recording: &Recording, logged: &TimedTurn) -> KnownGroups {
    let mut state = vec![0.0; STATE];
    field_of(model, &logged.turn.estimate, &mut state);
    let slice = slice(&Lattice::new(&recording.glass), recording, model.header.known(), &state);
    let mut shown = KnownGroups::NONE;
    if !slice.tracers.is_empty() {
        shown = shown.with(FieldGroup::Position);
    }
    if slice.values().next().is_some() {
        shown = shown.with(FieldGroup::Velocity);
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus::runtime::Turn;
    use meniscus::units::Micros;
    use meniscus_platform::files::AlignedBytes;

    /// The count would find each group in each output: a model that knows all shows all.
    #[test]
    fn a_model_that_knows_all_shows_all() {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let path = std::path::Path::new("shipped");
        let recording = Recording::from_bytes(path, meniscus_shipped::RECORDING).expect("the recording");
        let estimate =
            Estimator::new(&model).turn(&mut Memory::default(), TurnInput::default(), &mut NoClock, &mut []);
        let turn = Turn { time: Micros(0), stamp: None, profile: None, estimate };
        let logged = TimedTurn::untimed(turn);
        let packet = Packet::of(&logged.turn, 0, &model.header);
        let field = named(|_| true);
        assert_eq!(of_turn(&model), field);
        assert_eq!(of_packet(&packet), field);
        assert_eq!(of_field_frame(&model, &packet, &logged), KnownGroups::ALL);
        assert_eq!(of_estimates(&packet), field);
        assert_eq!(of_page(&messages(&model, &logged)), field);
        let picture = KnownGroups::NONE.with(FieldGroup::Position).with(FieldGroup::Velocity);
        assert_eq!(of_picture(&model, &recording, &logged), picture);
    }

    #[test]
    fn a_row_of_a_report_shows_its_group() {
        let rows = [
            Check::informational("water_field_tau", 20.0, "%"),
            Check::informational("field_error_sigma_frame_late", 0.2, "1"),
            Check::informational("interval_coverage_q", 90.0, "%"),
            Check::informational("interval_coverage", 90.0, "%"),
            // Nothing was measured, so nothing is shown.
            Check::informational("water_field_e", f64::NAN, "%"),
        ];
        let shown = in_checks(&rows, KnownGroups::KINEMATICS);
        let groups: Vec<FieldGroup> = shown.iter().map(|one| one.group).collect();
        assert_eq!(groups, [FieldGroup::NormalStress, FieldGroup::ShearStress]);
        assert!(in_checks(&rows, KnownGroups::ALL).is_empty());
    }

    #[test]
    fn numbers_show_their_group_and_totals_the_one_that_they_sum() {
        let none = f32::NAN;
        let shown = of_numbers(&[1.0, none, none, none, 2.0], f64::NAN, 0.0);
        let expected = KnownGroups::NONE
            .with(FieldGroup::Position)
            .with(FieldGroup::InternalEnergy)
            .with(FieldGroup::ShearStress);
        assert_eq!(shown, expected);
        assert!(of_numbers(&[none; 5], 1.0, f64::NAN).contains(FieldGroup::Velocity));
    }
}
