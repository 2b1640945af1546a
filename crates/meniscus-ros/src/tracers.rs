//! Tracers and surface as clouds in the frame of the glass.

use crate::message::{Header, PointCloud2};
use meniscus::blob::{FieldGroup, Model};
use meniscus::latent::decoder::{GROUP_COMPONENTS, Selection};
use meniscus::surface::{Config, POINTS, profile_abscissa};
use meniscus_service::timed_turn::TimedTurn;

/// Names of the numbers of each group: position (m), velocity (m/s), internal energy (J/kg), normal and shear stresses (Pa).
const NAMES: [&[&str]; 5] =
    [&["x", "y", "z"], &["vx", "vy", "vz"], &["energy"], &["sxx", "syy", "szz"], &["sxy", "syz", "szx"]];

/// Names of the numbers of a point of the surface.
const SURFACE: [&str; 5] = ["x", "y", "z", "half_width", "measured"];

/// Place of one group in the field.
#[derive(Clone, Copy, Debug)]
struct Carried {
    first: usize,
    components: usize,
}

/// Layout of the tracers' cloud: the groups that are decoded and that the model knows.
#[derive(Clone, Debug)]
pub(crate) struct TracerLayout {
    tracers: usize,
    field_len: usize,
    names: Vec<&'static str>,
    carried: Vec<Carried>,
}

impl TracerLayout {
    /// Returns the layout for a field of the groups `decoded`; `None` where it has no positions.
    pub(crate) fn of(model: &Model<'_>, decoded: Selection) -> Option<Self> {
        let (known, tracers) = (model.header.known(), model.header.particles as usize);
        let (mut field_len, mut names, mut carried) = (0, Vec::new(), Vec::new());
        let groups = FieldGroup::ALL.into_iter().zip(GROUP_COMPONENTS).zip(NAMES).enumerate();
        for (index, ((group, components), of_group)) in groups.filter(|(index, _)| decoded.holds(*index)) {
            debug_assert_eq!(components, of_group.len(), "group {index}");
            if known.contains(group) {
                names.extend(of_group);
                carried.push(Carried { first: field_len, components });
            }
            field_len += tracers * components;
        }
        names.starts_with(NAMES[0]).then_some(Self { tracers, field_len, names, carried })
    }

    /// Returns the numbers of the field.
    pub(crate) fn field_len(&self) -> usize {
        self.field_len
    }

    /// Returns the cloud of a field.
    pub(crate) fn cloud(&self, header: Header, field: &[f32]) -> PointCloud2 {
        let mut data = Vec::with_capacity(4 * self.tracers * self.names.len());
        for tracer in 0..self.tracers {
            for Carried { first, components } in &self.carried {
                let begin = first + tracer * components;
                for number in field.get(begin..begin + components).unwrap_or_default() {
                    data.extend_from_slice(&number.to_le_bytes());
                }
            }
        }
        PointCloud2::of(header, &self.names, data, true)
    }
}

/// Returns the surface of a turn along the wall that faces the camera: 21 points with the half-width of their height (90 %
/// coverage) and the measured height, which is not a number where the camera saw none.
pub(crate) fn surface(config: &Config, logged: &TimedTurn, header: Header) -> PointCloud2 {
    let estimate = &logged.turn.estimate;
    let profile = logged.turn.profile.and_then(Result::ok);
    let measured = |point: usize| {
        let profile = profile.as_ref().filter(|profile| profile.valid[point]);
        profile.map_or(f32::NAN, |profile| profile.height_m[point])
    };
    let (mut data, mut is_dense) = (Vec::with_capacity(4 * SURFACE.len() * POINTS), true);
    for (point, (height, half)) in estimate.surface_m.iter().zip(estimate.interval.surface_m).enumerate() {
        let [x, y, z] = config.wall_point(profile_abscissa(point) as f32, *height);
        let numbers = [x, y, z, half, measured(point)];
        is_dense &= numbers.iter().all(|number| number.is_finite());
        numbers.iter().for_each(|number| data.extend_from_slice(&number.to_le_bytes()));
    }
    PointCloud2::of(header, &SURFACE, data, is_dense)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meniscus_platform::files::AlignedBytes;

    fn numbers(cloud: &PointCloud2) -> Vec<f32> {
        let bytes = cloud.data.0.chunks_exact(4);
        bytes.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }

    #[test]
    fn a_tracer_has_its_numbers_under_their_names() {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let model = Model::load(&bytes).expect("the shipped model");
        let layout = TracerLayout::of(&model, Selection::ALL).expect("it has positions");
        assert_eq!(layout.field_len(), model.field_len());
        let count = model.header.particles as usize;
        let field: Vec<f32> = (0..layout.field_len()).map(|number| number as f32).collect();
        let cloud = layout.cloud(Header::default(), &field);
        assert_eq!((cloud.width as usize, cloud.point_step, cloud.data.0.len()), (count, 52, 52 * count));
        let fifth = &numbers(&cloud)[5 * 13..6 * 13];
        // Group after group in the field: three, three, one, three and three numbers of each tracer.
        let place = |group_first: usize, components: usize, k: usize| {
            (group_first * count + 5 * components + k) as f32
        };
        assert_eq!(fifth[..3], [place(0, 3, 0), place(0, 3, 1), place(0, 3, 2)]);
        assert_eq!((fifth[6], fifth[12]), (place(6, 1, 0), place(10, 3, 2)));
        let offsets: Vec<(&str, u32)> = cloud.fields.iter().map(|f| (f.name.as_str(), f.offset)).collect();
        assert_eq!((offsets[6], offsets[12]), (("energy", 24), ("szx", 48)));
    }

    #[test]
    fn groups_that_are_not_known_or_not_decoded_are_absent() {
        let bytes = AlignedBytes::copy(meniscus_shipped::MODEL);
        let mut model = Model::load(&bytes).expect("the shipped model");
        let part = TracerLayout::of(&model, Selection::NONE.with(0).with(2)).expect("it has positions");
        assert_eq!(part.names, ["x", "y", "z", "energy"]);
        model.header.stated_known = meniscus::blob::KnownGroups::KINEMATICS;
        let layout = TracerLayout::of(&model, Selection::ALL).expect("it has positions");
        assert_eq!(layout.names, ["x", "y", "z"]);
        assert_eq!(layout.field_len(), model.field_len(), "the field has all groups all the same");
        assert!(TracerLayout::of(&model, Selection::NONE).is_none());
        assert!(TracerLayout::of(&model, Selection::NONE.with(1)).is_none(), "no cloud without positions");
    }
}
