//! `meniscus simulate --list`: liquids, motions and effects.

use meniscus::reduced::effects::{LIBRARY, Simulator};
use meniscus_data::liquids::{Liquid, known};
use meniscus_data::motion::KINDS;

/// Prints liquids, motions and effects.
pub(super) fn print() -> anyhow::Result<()> {
    println!("LIQUIDS (--liquid NAME; their sources stand in liquids/NAME.toml)");
    println!("  {:12} {:>8} {:>9} {:>6} {:>8} {:>9}", "", "density", "k", "n", "tau0", "cap");
    println!("  {:12} {:>8} {:>9} {:>6} {:>8} {:>9}", "name", "kg/m3", "Pa s^n", "1", "Pa", "Pa s");
    for name in known() {
        let liquid = Liquid::load(name)?;
        let law = liquid.rheology;
        let cap = if law.is_newtonian() { String::from("-") } else { law.largest.to_string() };
        println!(
            "  {name:12} {:>8} {:>9} {:>6} {:>8} {cap:>9}",
            liquid.density_kg_m3, law.consistency, law.index, law.yield_stress
        );
    }
    println!(
        "\nMOTIONS (--motion KIND:SEED; m and s; also a CSV file with the columns t, x_m, y_m, z_m, tilt_rad)"
    );
    for (kind, what) in KINDS {
        println!("  {kind:12} {what}");
    }
    effects();
    Ok(())
}

/// Prints the effects with their parameters, first those that the simulator carries.
fn effects() {
    println!(
        "\nEFFECTS (--effect NAME=VALUE; the same names, values and units in scene files, `insert` and `discover`)"
    );
    for effect in &LIBRARY {
        let Simulator::Law(law) = effect.simulator else { continue };
        for parameter in effect.parameters.iter().take(law.parameters()) {
            let (least, largest) = parameter.admissible;
            println!("  {:22} {least} to {largest} {}", parameter.spelling, parameter.unit);
            println!("  {:22} {}", "", parameter.meaning);
        }
        println!("  {:22} source: {}", "", effect.source);
    }
    println!("\nEFFECTS THAT ARE NOT SIMULATED (for `insert` and `discover`)");
    for effect in &LIBRARY {
        let Simulator::Absent(why) = effect.simulator else { continue };
        for parameter in effect.parameters {
            let (least, largest) = parameter.admissible;
            println!("  {:22} {least} to {largest} {}", parameter.spelling, parameter.unit);
            println!("  {:22} {}", "", parameter.meaning);
        }
        println!("  {:22} not simulated: {why}", "");
        println!("  {:22} source: {}", "", effect.source);
    }
}
