//! The motion of a rigid glass at one instant, inclined in the x-z plane alone, and the polynomials it is made of.

/// Motion of the glass at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kinematics {
    /// Acceleration of the pivot in the room: along x, away from the camera, upwards, m/s2.
    pub acceleration_m_s2: [f64; 3],
    /// Inclination towards +x, rad.
    pub tilt_rad: f64,
    /// Its rate, rad/s.
    pub tilt_rate: f64,
    /// Its second derivative, rad/s2.
    pub tilt_acceleration: f64,
    /// The point of the glass about which it is inclined: x and z from the middle of its bottom, m.
    pub pivot_m: [f64; 2],
}

impl Kinematics {
    /// An upright glass that is accelerated along x, m/s2.
    #[must_use]
    pub fn along_x(acceleration: f64) -> Self {
        Self { acceleration_m_s2: [acceleration, 0.0, 0.0], ..Self::default() }
    }
}

/// One polynomial piece: `x(t) = sum_k coefficient[k] (t - start)^k`, valid until the next piece starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) start_s: f64,
    pub(super) coefficient: [f64; 6],
}

/// One coordinate over time; zero before its first piece.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Channel(pub(super) Vec<Piece>);

impl Channel {
    fn piece(&self, time_s: f64) -> Option<(&Piece, f64)> {
        let after = self.0.partition_point(|p| p.start_s <= time_s);
        let piece = self.0.get(after.checked_sub(1)?)?;
        Some((piece, time_s - piece.start_s))
    }

    /// Start of the piece that holds at `time_s`, s.
    pub(super) fn began_s(&self, time_s: f64) -> Option<f64> {
        self.piece(time_s).map(|(piece, _)| piece.start_s)
    }

    pub(super) fn value(&self, time_s: f64) -> f64 {
        self.piece(time_s).map_or(0.0, |(p, t)| p.coefficient.iter().rev().fold(0.0, |sum, c| sum * t + c))
    }

    pub(super) fn rate(&self, time_s: f64) -> f64 {
        self.piece(time_s).map_or(0.0, |(p, t)| {
            let [_, c1, c2, c3, c4, c5] = p.coefficient;
            c1 + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + t * 5.0 * c5)))
        })
    }

    pub(super) fn acceleration(&self, time_s: f64) -> f64 {
        self.piece(time_s).map_or(0.0, |(p, t)| {
            let [_, _, c2, c3, c4, c5] = p.coefficient;
            2.0 * c2 + t * (6.0 * c3 + t * (12.0 * c4 + t * 20.0 * c5))
        })
    }

    /// The same course, `factor` times as far.
    pub(super) fn scaled(mut self, factor: f64) -> Self {
        for c in self.0.iter_mut().flat_map(|piece| &mut piece.coefficient) {
            *c *= factor;
        }
        self
    }
}
