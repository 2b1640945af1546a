//! Sizes of effects by simulation: the reduced model names an effect and its rough size, the simulator finds the size.
//!
//! ```text
//! candidates -> search at a coarse spacing -> comparison -> judge -> search at the fine spacing -> Sizing
//!                    |    ^
//!                    v    |
//!                simulations (store on disk, shards)
//! ```
//!
//! | file | purpose |
//! |---|---|
//! | `stage`, `fine`, `planning`, `description` | [`size`](stage::size), the whole stage; its expected work and its outcome |
//! | `candidate` | effects of the reduced model as parameters of a search |
//! | `search`, `next`, `best`, `tried`, `emulator` | the size that fits best at one spacing |
//! | `projection` | simulated against measured channels, nuisances projected out |
//! | `interval` | interval of a size by curvature, packings and spacing |
//! | `comparison`, `judgement` | rivals on recordings that were not fitted, and the verdict |
//! | `outcome`, `cautions` | sizes and verdict for people |
//! | `glass`, `forward` | the simulator as a model that is sized; the interface for any other |
//! | `simulations`, `store`, `workload` | simulations on disk, made here or elsewhere, and the time that they take |
//!
//! All that is simulated lies in the store under a digest of its inputs. The stage asks for simulations in rounds; with
//! [`Shard`](simulations::Shard) it makes its part of a round and ends, so that several machines that share the folder can make
//! a round together. The same call then goes on with the next round.

mod best;
pub mod candidate;
mod cautions;
pub mod comparison;
mod description;
pub mod emulator;
pub mod error;
mod fine;
pub mod forward;
pub mod glass;
pub mod interval;
pub mod judgement;
mod next;
pub mod outcome;
mod planning;
pub mod projection;
pub mod search;
pub mod simulations;
pub mod stage;
pub mod store;
pub mod tried;
pub mod workload;

#[cfg(test)]
mod toy_tests;
