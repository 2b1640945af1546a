//! Section through the middle of the glass in a terminal, two pixels a character, coloured by the speed of the liquid.

use meniscus::blob::{FieldGroup, Model};
use meniscus::latent::decoder::Selection;
use meniscus::runtime::Estimate;
use meniscus::surface::{POINTS, profile_abscissa};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::{Color, Stylize};
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

/// Half the thickness of the section about the plane y = 0, in units of the radius.
const HALF_THICKNESS: f64 = 0.12;

/// Slow to fast, of the colours of a terminal with 256: near viridis, whose lightness rises for every eye.
const SPEEDS: [u8; 8] = [53, 60, 24, 30, 36, 77, 149, 226];
/// Liquid whose speed is not known.
const UNKNOWN: Color = Color::Indexed(243);
/// Wall and base of the glass.
const GLASS: Color = Color::Indexed(250);

/// Tracer of the section.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tracer {
    x_m: f64,
    z_m: f64,
    speed_m_s: Option<f64>,
}

/// Liquid of one turn in the plane that the camera faces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Section {
    radius_m: f64,
    rim_m: f64,
    surface_m: [f32; POINTS],
    tracers: Vec<Tracer>,
}

impl Section {
    /// Decodes positions and velocities of the tracers near the plane y = 0.
    pub(super) fn of(model: &Model<'_>, estimate: &Estimate) -> Self {
        let header = &model.header;
        let known = header.known();
        let (placed, fast) = (known.contains(FieldGroup::Position), known.contains(FieldGroup::Velocity));
        let [positions, velocities, ..] = &model.decoder.groups;
        let near = |y: f32| f64::from(y).abs() < HALF_THICKNESS * header.radius_m;
        let latent = estimate.latent.map(|x| x as f32);
        let coefficients = model.decoder.coefficients(&latent, estimate.port);
        let wanted = Selection::NONE.with(0).with(1);
        let mut field = vec![0.0; model.decoder.part_len(wanted)];
        model.decoder.part(wanted, &coefficients, 0.0, &mut field);
        let (q, v) = field.split_at(positions.rest.len().min(field.len()));
        debug_assert_eq!(v.len(), velocities.rest.len());
        let rest = positions.rest.chunks_exact(3);
        let tracers = rest.zip(q.chunks_exact(3)).zip(v.chunks_exact(3)).filter_map(|((rest, q), v)| {
            // Where positions are not known, the tracers stay at rest.
            let q = if placed { q } else { rest };
            let ([_, y, _], [x, _, z], [a, b, c]) = (rest, q, v) else { return None };
            let speed = (f64::from(*a).powi(2) + f64::from(*b).powi(2) + f64::from(*c).powi(2)).sqrt();
            let tracer = Tracer { x_m: f64::from(*x), z_m: f64::from(*z), speed_m_s: fast.then_some(speed) };
            near(*y).then_some(tracer)
        });
        let tracers = tracers.collect();
        Self { radius_m: header.radius_m, rim_m: header.rim_m, surface_m: estimate.surface_m, tracers }
    }

    /// Returns the largest speed, m/s; `None` where speeds are not known.
    pub(super) fn fastest_m_s(&self) -> Option<f64> {
        self.tracers.iter().filter_map(|tracer| tracer.speed_m_s).reduce(f64::max)
    }

    /// Returns the columns of a picture that is `rows` characters high: as wide as the glass at that height, walls included.
    pub(super) fn columns(radius_m: f64, rim_m: f64, rows: u16) -> u16 {
        let pixels = 2.0 * f64::from(rows);
        (2.0 * radius_m / rim_m * pixels).round() as u16 + 2
    }

    /// Height of the surface at `x_m`, between its points.
    fn height_m(&self, x_m: f64) -> f64 {
        let place = |index: usize| self.radius_m * profile_abscissa(index);
        let after = (1..POINTS - 1).find(|index| x_m < place(*index)).unwrap_or(POINTS - 1);
        let (left, right) = (place(after - 1), place(after));
        let share = ((x_m - left) / (right - left)).clamp(0.0, 1.0);
        let [low, high] = [after - 1, after].map(|index| f64::from(self.surface_m[index]));
        low + share * (high - low)
    }

    /// Colour of the liquid at a place: that of the nearest tracer. `None` above the surface.
    fn colour(&self, x_m: f64, z_m: f64, top_m_s: f64) -> Option<Color> {
        let apart = |tracer: &Tracer| (tracer.x_m - x_m).powi(2) + (tracer.z_m - z_m).powi(2);
        let nearest = self.tracers.iter().min_by(|one, other| apart(one).total_cmp(&apart(other)))?;
        (z_m <= self.height_m(x_m)).then(|| nearest.speed_m_s.map_or(UNKNOWN, |speed| shade(speed / top_m_s)))
    }

    /// The picture, with the speed of its brightest colour.
    pub(super) fn drawn(&self, top_m_s: f64) -> Drawn<'_> {
        Drawn { section: self, top_m_s }
    }
}

/// Colour of a share of the largest speed.
fn shade(share: f64) -> Color {
    let step = (share.clamp(0.0, 0.999) * SPEEDS.len() as f64) as usize;
    Color::Indexed(SPEEDS[step])
}

/// Scale of the colours in a line: `0▇▇▇▇200 mm/s`.
pub(super) fn scale(top_m_s: f64) -> Line<'static> {
    let blocks = SPEEDS.map(|colour| Span::from("▇").fg(Color::Indexed(colour)));
    let (low, high) = (Span::from("0"), Span::from(format!("{:.0} mm/s", 1e3 * top_m_s)));
    Line::from([vec![low], blocks.to_vec(), vec![high]].concat())
}

/// [`Section`] as a widget.
pub(super) struct Drawn<'s> {
    section: &'s Section,
    top_m_s: f64,
}

impl Drawn<'_> {
    /// Colour of the pixel in column `x` and row `y` of a picture of `across` by `down` pixels; `None` for air.
    fn pixel(&self, x: u16, y: u16, (across, down): (u16, u16)) -> Option<Color> {
        if x == 0 || x + 1 == across || y + 1 == down {
            return Some(GLASS);
        }
        let Section { radius_m, rim_m, .. } = self.section;
        let x_m = radius_m * (2.0 * (f64::from(x) - 0.5) / f64::from(across - 2) - 1.0);
        let z_m = rim_m * (1.0 - (f64::from(y) + 0.5) / f64::from(down - 1));
        self.section.colour(x_m, z_m, self.top_m_s)
    }
}

impl Widget for Drawn<'_> {
    fn render(self, area: Rect, buffer: &mut Buffer) {
        if area.width < 4 || area.height < 2 {
            return;
        }
        let size = (area.width, 2 * area.height);
        for (row, y) in (area.top()..area.bottom()).enumerate() {
            for (column, x) in (area.left()..area.right()).enumerate() {
                let pixel = |half: u16| self.pixel(column as u16, 2 * row as u16 + half, size);
                let Some(cell) = buffer.cell_mut((x, y)) else { continue };
                // The colour of air is that of the terminal, which a half block cannot have in front.
                match [pixel(0), pixel(1)] {
                    [None, None] => cell.set_symbol(" "),
                    [None, Some(lower)] => cell.set_symbol("▄").set_fg(lower),
                    [Some(upper), None] => cell.set_symbol("▀").set_fg(upper),
                    [Some(upper), Some(lower)] => cell.set_symbol("▀").set_fg(upper).set_bg(lower),
                };
            }
        }
    }
}
