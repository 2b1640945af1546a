//! Other programs as simulators: a command that reads a scene and writes heights, and what any other carrier of them shares.
//!
//! ```text
//! set-up, motions --Scene--> request.json --CMD request.json answer.json--> answer.json --Answer--> heights
//! ```
//! The page "A simulator of your own" of the book (`docs/simulators.md`) is the protocol for people; [`scene::FORMAT`] is its version.
//!
//! | file | purpose |
//! |---|---|
//! | `scene` | request to a simulator |
//! | `answer` | its heights, checked |
//! | `command` | a command as [`GlassSimulator`](crate::insert::simulator::GlassSimulator) |
//! | `process` | a program that runs for a limited time and writes a file of limited size |

pub mod answer;
pub mod command;
mod process;
pub mod scene;

use crate::insert::simulator::is_around;
use meniscus::reduced::effects::{Active, Simulator, Stated};
use meniscus_data::effects::Effects;

/// Returns `effects`, counted from `stated`, in SI units: all that act in the liquid or the glass.
///
/// # Errors
/// In words, when a value is out of its range.
pub fn carried(effects: &[Active], stated: &Stated) -> Result<Effects, String> {
    let mut inside = Effects::default();
    for effect in effects.iter().filter(|effect| !is_around(effect)) {
        let taken = match effect.entry.simulator {
            // The others say how much of a recorded motion is taken.
            Simulator::Law(law) => law.parameters(),
            Simulator::Absent(_) => effect.entry.parameters.len(),
        };
        let values = effect.stated_values(stated).into_iter().flatten();
        for (parameter, value) in effect.entry.parameters.iter().zip(values).take(taken) {
            inside.set(parameter.spelling, value).map_err(|error| error.to_string())?;
        }
    }
    Ok(inside)
}
