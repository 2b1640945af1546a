//! Tracers as a point cloud, with the fields of the groups that the model knows.

use super::name;
use super::scene::{GLASS, here};
use ::foxglove::messages::packed_element_field::NumericType;
use ::foxglove::messages::{PackedElementField, PointCloud, Timestamp};
use meniscus::blob::{FieldGroup, KnownGroups};
use meniscus::latent::decoder::GROUP_COMPONENTS;

/// One field of a tracer in the point cloud, `f32` in SI units, made from the numbers of one group.
struct Carried {
    name: &'static str,
    group: FieldGroup,
    of: fn(&[f32]) -> f32,
}

/// Fields of a tracer: position, velocity, speed, internal energy, pressure -tr(sigma)/3, and the size of the shear stress |tau|.
const CARRIED: [Carried; 10] = {
    use FieldGroup::{InternalEnergy, NormalStress, Position, ShearStress, Velocity};
    const fn carried(name: &'static str, group: FieldGroup, of: fn(&[f32]) -> f32) -> Carried {
        Carried { name, group, of }
    }
    [
        carried("x", Position, |q| q[0]),
        carried("y", Position, |q| q[1]),
        carried("z", Position, |q| q[2]),
        carried("vx", Velocity, |v| v[0]),
        carried("vy", Velocity, |v| v[1]),
        carried("vz", Velocity, |v| v[2]),
        carried("speed", Velocity, size),
        carried("e", InternalEnergy, |e| e[0]),
        carried("pressure", NormalStress, |sigma| -sigma.iter().sum::<f32>() / 3.0),
        carried("shear", ShearStress, size),
    ]
};

/// Length of a vector.
fn size(vector: &[f32]) -> f32 {
    vector.iter().map(|x| x * x).sum::<f32>().sqrt()
}

/// Returns the `known` groups of `count` tracers as a cloud in the frame of the glass; `field` has them group after group, as
/// the decoder writes them. The fields of a group that is not known are absent.
pub(super) fn tracers(count: usize, known: KnownGroups, field: &[f32], stamp: Timestamp) -> PointCloud {
    let mut rest = field;
    let groups =
        FieldGroup::ALL.into_iter().zip(GROUP_COMPONENTS).filter(|(group, _)| known.contains(*group));
    let groups: Vec<_> = groups
        .map(|(group, components)| {
            let (part, behind) = rest.split_at((components * count).min(rest.len()));
            rest = behind;
            (group, part, components)
        })
        .collect();
    let carried: Vec<&Carried> = CARRIED.iter().filter(|carried| known.contains(carried.group)).collect();
    let stride = 4 * carried.len() as u32;
    let mut data = Vec::with_capacity(count * stride as usize);
    for tracer in 0..count {
        let numbers = |group: FieldGroup| {
            let part = groups.iter().find(|(kind, ..)| *kind == group);
            part.and_then(|(_, part, components)| part.get(tracer * components..(tracer + 1) * components))
        };
        for carried in &carried {
            let number = numbers(carried.group).map_or(f32::NAN, carried.of);
            data.extend_from_slice(&number.to_le_bytes());
        }
    }
    let fields = carried.iter().enumerate().map(|(place, carried)| PackedElementField {
        name: name(carried.name),
        offset: 4 * place as u32,
        r#type: NumericType::Float32 as i32,
    });
    PointCloud {
        timestamp: Some(stamp),
        frame_id: name(GLASS),
        pose: Some(here([0.0; 3])),
        point_stride: stride,
        fields: fields.collect(),
        data: data.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tracer_keeps_its_numbers() {
        // Two tracers: q, v, e, sigma, tau.
        let mut field = vec![0.0_f32; 26];
        field[3..6].copy_from_slice(&[0.01, 0.02, 0.03]);
        field[9..12].copy_from_slice(&[0.3, 0.0, 0.4]);
        field[13] = 7.0;
        field[17..20].copy_from_slice(&[-1.0, -2.0, -3.0]);
        field[23..26].copy_from_slice(&[0.0, 3.0, 4.0]);
        let cloud = tracers(2, KnownGroups::ALL, &field, Timestamp::new(1, 0));
        assert_eq!(cloud.data.len(), 2 * cloud.point_stride as usize);
        let numbers: Vec<f32> =
            cloud.data.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        assert_eq!(&numbers[10..], [0.01, 0.02, 0.03, 0.3, 0.0, 0.4, 0.5, 7.0, 2.0, 5.0]);
        assert_eq!(cloud.fields.len(), CARRIED.len());
    }

    #[test]
    fn a_cloud_has_no_field_of_a_group_that_is_not_known() {
        // Positions and internal energies of two tracers.
        let known = KnownGroups::KINEMATICS.with(FieldGroup::InternalEnergy);
        let field = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
        let cloud = tracers(2, known, &field, Timestamp::new(1, 0));
        let names: Vec<&str> = cloud.fields.iter().map(|field| field.name.as_str()).collect();
        assert_eq!((names, cloud.point_stride), (vec!["x", "y", "z", "e"], 16));
        let numbers = cloud.data.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
        assert_eq!(numbers.collect::<Vec<_>>(), [1.0, 2.0, 3.0, 7.0, 4.0, 5.0, 6.0, 8.0]);
    }
}
